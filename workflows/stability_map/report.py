"""The map as a page and as figures."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np

from workflows.stability_map.cases import Cell
from workflows.stability_map.outcomes import RIGHT, Kind
from workflows.stability_map.words import ADVICE, AFTER, BEFORE

matplotlib.use("agg")
import matplotlib.pyplot as plt
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch

_COLOURS = {
    Kind.RIGHT: "#4a9d5b",
    Kind.INACCURATE: "#f2c45a",
    Kind.REFUSED: "#9fb7d9",
    Kind.DIVERGED: "#b79fd0",
    Kind.HANG: "#000000",
    Kind.CRASH: "#5a0f0f",
    Kind.SILENT_NAN: "#d0306e",
    Kind.WRONG: "#d62222",
}


def table(cells: Sequence[Cell]) -> list[str]:
    """A sweep's cells as lines of Markdown."""
    columns, rows = _axes(cells)
    at = {(cell.row, cell.column): cell for cell in cells}
    lines = ["| | " + " | ".join(columns) + " |", "| --- " * (len(columns) + 1) + "|"]
    for row in rows:
        found = [at.get((row, column)) for column in columns]
        lines.append(f"| {row} | " + " | ".join(_short(cell) for cell in found) + " |")
    return lines


def _axes(cells: Sequence[Cell]) -> tuple[list[str], list[str]]:
    columns = list(dict.fromkeys(cell.column for cell in cells))
    return columns, list(dict.fromkeys(cell.row for cell in cells))


def _short(cell: Cell | None) -> str:
    if cell is None:
        return "–"
    kind, error = cell.outcome.kind, cell.outcome.error
    match kind:
        case Kind.RIGHT | Kind.INACCURATE:
            text = "0" if error == 0.0 else f"{error:.0e}"
            return text if kind is Kind.RIGHT else f"*{text}*"
        case Kind.REFUSED | Kind.DIVERGED:
            return str(kind)
        case _:
            return f"**{kind}**"


def by_sweep(cells: Sequence[Cell]) -> dict[str, list[Cell]]:
    """Cells by the table they belong to."""
    sweeps: dict[str, list[Cell]] = {}
    for cell in cells:
        sweeps.setdefault(cell.sweep, []).append(cell)
    return sweeps


def by_chapter(cells: Sequence[Cell]) -> dict[str, dict[str, list[Cell]]]:
    """Tables by chapter: what stands before a colon or comma of their titles."""
    chapters: dict[str, dict[str, list[Cell]]] = {}
    for sweep, some in by_sweep(cells).items():
        title = sweep.split(":")[0].split(", heavy")[0]
        chapters.setdefault(title, {})[sweep] = some
    return chapters


def findings(cells: Sequence[Cell]) -> list[Cell]:
    """Cells that no user should meet."""
    return [cell for cell in cells if not cell.outcome.kind.sound]


def page(cells: Sequence[Cell], seconds: float, *, machine: str) -> str:
    """The whole page as Markdown."""
    counts = {kind: sum(cell.outcome.kind is kind for cell in cells) for kind in Kind}
    tally = ", ".join(f"{count} {kind}" for kind, count in counts.items() if count)
    lines = [*BEFORE, "", f"{len(cells)} cells: {tally}.", "", *ADVICE, "", "## Open findings", ""]
    lines += _findings(cells)
    for chapter, sweeps in by_chapter(cells).items():
        lines += ["", f"## {chapter}", ""]
        if chapter in AFTER:
            lines += [*AFTER[chapter], ""]
        lines += [f"![{chapter}](stability/{file_name(chapter)})", ""]
        for sweep, some in sweeps.items():
            if len(sweeps) > 1:
                lines += [f"### {sweep}", ""]
            lines += [*table(some), ""]
    lines += [
        "## What was said",
        "",
        "One message of each kind and table, numbers as they came.",
        "",
    ]
    lines += _messages(cells)
    lines += ["", "Made by `python workflows/stability.py --output docs`. The cells took"]
    lines += [f"{seconds:.0f} s together, one thread each, {machine}."]
    return "\n".join(lines) + "\n"


def _findings(cells: Sequence[Cell]) -> list[str]:
    wrong = findings(cells)
    if not wrong:
        return ["None: no cell hung, crashed, gave a silent NaN or a wrong answer called right."]
    lines = [
        f"{len(wrong)} cells are not sound; `workflows/stability.py` fails because of them:",
        "",
    ]
    for sweep, some in by_sweep(wrong).items():
        rows: dict[str, list[Cell]] = {}
        for cell in some:
            rows.setdefault(cell.row, []).append(cell)
        for row, found in rows.items():
            at = ", ".join(cell.column for cell in found)
            lines.append(
                f"- {sweep}; {row}; {at}: **{found[0].outcome.kind}** ({found[0].outcome.message})"
            )
    return lines


def _messages(cells: Sequence[Cell]) -> list[str]:
    seen: dict[tuple[str, Kind], Cell] = {}
    for cell in cells:
        if cell.outcome.kind in (Kind.REFUSED, Kind.DIVERGED):
            seen.setdefault((cell.sweep, cell.outcome.kind), cell)
    return [
        f"- {sweep}, {kind} ({cell.row}, {cell.column}): “{cell.outcome.message}”"
        for (sweep, kind), cell in seen.items()
    ]


def file_name(chapter: str) -> str:
    """Name of a chapter's figure."""
    letters = "".join(c if c.isascii() and c.isalnum() else " " for c in chapter.lower())
    return "_".join(letters.split()) + ".png"


def draw(cells: Sequence[Cell], folder: Path) -> None:
    """A figure a chapter: its cells in colour, the error's exponent in each."""
    folder.mkdir(parents=True, exist_ok=True)
    for chapter, sweeps in by_chapter(cells).items():
        _draw_chapter(sweeps, folder / file_name(chapter))


def _draw_chapter(sweeps: dict[str, list[Cell]], path: Path) -> None:
    across = 1 if len(sweeps) == 1 else 2
    down = -(-len(sweeps) // across)
    tallest = max(len(_axes(cells)[1]) for cells in sweeps.values())
    size = (6.5 * across, (0.26 * tallest + 1.0) * down + 0.4)
    figure, plots = plt.subplots(down, across, figsize=size, layout="constrained", squeeze=False)
    for axes in plots.ravel()[len(sweeps) :]:
        axes.axis("off")
    for (sweep, cells), axes in zip(sweeps.items(), plots.ravel(), strict=False):
        _draw_sweep(axes, sweep, cells)
    there = {cell.outcome.kind for cells in sweeps.values() for cell in cells}
    patches = [Patch(color=_COLOURS[kind], label=str(kind)) for kind in Kind if kind in there]
    figure.legend(handles=patches, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_sweep(axes: plt.Axes, title: str, cells: Sequence[Cell]) -> None:
    columns, rows = _axes(cells)
    kinds = list(Kind)
    field = np.full((len(rows), len(columns)), np.nan)
    for cell in cells:
        at = rows.index(cell.row), columns.index(cell.column)
        field[at] = kinds.index(cell.outcome.kind)
        text = _exponent(cell)
        axes.text(at[1], at[0], text, ha="center", va="center", fontsize=7)
    colours = ListedColormap([_COLOURS[kind] for kind in kinds])
    norm = BoundaryNorm(np.arange(len(kinds) + 1) - 0.5, len(kinds))
    axes.imshow(field, cmap=colours, norm=norm, aspect="auto")
    axes.set_xticks(range(len(columns)), columns, fontsize=7)
    axes.set_yticks(range(len(rows)), rows, fontsize=7)
    axes.set_xticks(np.arange(len(columns) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=1.0)
    axes.tick_params(which="both", length=0)
    axes.set_title(title, fontsize=8)


def _exponent(cell: Cell) -> str:
    error = cell.outcome.error
    if error is None or cell.outcome.kind not in (Kind.RIGHT, Kind.INACCURATE):
        return ""
    if error < 1e-16:
        return "0"
    return f"{error:.0e}" if error < RIGHT else f"{error:.2g}"
