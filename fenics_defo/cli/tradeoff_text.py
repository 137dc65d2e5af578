"""A trade-off for people."""

import textwrap
from collections.abc import Sequence

from fenics_defo.scene.trade.choosing import duration, percent, step_text
from fenics_defo.scene.trade.records import FAILED, MEASURED, PRUNED, Tradeoff

_WIDTH = 78


def tradeoff_text(found: Tradeoff, folder: str, files: Sequence[str]) -> str:
    """Write the front and the choice.

    Args:
        found: the trade-off.
        folder: of its files.
        files: names of the pictures and of the report.
    """
    reference = found.reference
    counts = {state: 0 for state in (MEASURED, PRUNED, FAILED)}
    for row in found.rows:
        counts[row.status] += 1
    lines = [
        f"scene: {found.scene}, {found.title}",
        f"reference: step {reference.step:.4g} s, its own error about {percent(reference.error)}",
        f"candidates: {counts[MEASURED]} measured, {counts[PRUNED]} left out, "
        f"{counts[FAILED]} failed",
        "",
        f"{'on the front':44s} {'step':>9s} {'error':>9s} {'a step':>9s}",
    ]
    for number in found.front:
        row, mark = found.rows[number], "*" if number == found.choice else " "
        step = step_text(row)
        cost = duration(row.microseconds)
        lines.append(
            f"{mark} {row.candidate.name:42s} {step:>9s} {percent(row.error):>9s} {cost:>9s}"
        )
    lines.append("")
    lines += choice_lines(found)
    written = [found.model] if found.model else []
    written += ["tradeoff.json", "tradeoff.csv", *files]
    lines += textwrap.wrap(
        f"written: {', '.join(written)} in {folder}", _WIDTH, subsequent_indent="  "
    )
    return "\n".join(lines) + "\n"


def choice_lines(found: Tradeoff) -> list[str]:
    """The choice and its reason, as lines.

    Args:
        found: the trade-off.
    """
    chosen, name = found.chosen, "none fits"
    if chosen is not None:
        name = f"{chosen.candidate.name}, {chosen.candidate.integrator}, step {step_text(chosen)}"
    text = f"chosen: {name}: {found.reason}"
    return textwrap.wrap(text, _WIDTH, subsequent_indent="  ", break_long_words=False)
