"""Charts of a trade-off: error against cost, and error over time."""

import io
import textwrap
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from fenics_defo.runtime import atomic_path
from fenics_defo.scene.trade.choosing import duration, percent
from fenics_defo.scene.trade.records import FILTER, FULL, MEASURED, Measurement, Tradeoff

# Colours that people who confuse red and green tell apart: Okabe and Ito (2008).
_BLACK, _ORANGE, _SKY, _GREEN = "#333333", "#e69f00", "#56b4e9", "#009e73"
_BLUE, _RED, _PURPLE, _GREY = "#0072b2", "#d55e00", "#cc79a7", "#999999"
_FAMILIES = {
    "exact filter": _SKY,
    "linear": _BLUE,
    "cubic": _GREEN,
    "taylor": _ORANGE,
    "cubature": _PURPLE,
    "full order": _BLACK,
}
_BASES = {"linear": "o", "modal-derivatives": "^", "snapshots": "s", "": "D"}
_BASE_NAMES = {
    "linear": "modes",
    "modal-derivatives": "modal derivatives",
    "snapshots": "this very motion",
}
_MOST_CURVES = 7
_SAME_HEIGHT = 1.3  # factor between errors whose labels would overlap
_LEAST = 1e-9  # errors below are drawn there


def chart_png(found: Tradeoff) -> bytes:
    """Error against time a step of all measured candidates, as PNG.

    Args:
        found: the trade-off.
    """
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    axes = figure.add_subplot()
    rows = [row for row in found.rows if row.status == MEASURED]
    _limits(axes, found, rows)
    for row in rows:
        is_tried, is_trained = row.candidate.factor == 1, row.candidate.is_trained
        colour = _FAMILIES[family(row)]
        axes.plot(
            row.cost or 0.0,
            _error(row),
            marker=_BASES["" if row.candidate.model is None else row.candidate.model.basis],
            color=colour,
            markersize=8 if is_tried else 5,
            alpha=0.9 if is_tried else 0.55,
            markerfacecolor="none" if is_trained else colour,
            markeredgecolor=colour if is_trained else "white",
            markeredgewidth=1.2 if is_trained else 0.7,
            linestyle="none",
            zorder=3,
        )
    _front(axes, found)
    _choice(axes, found)
    _name_full_order(axes, rows)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.12)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: duration(value)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: percent(value)))
    axes.set_xlabel(f"time to compute one step of the scene ({_seconds(found.step)} of motion)")
    axes.set_ylabel("error of displacements, largest over the motion")
    axes.set_title(f"{Path(found.scene).name}: what accuracy costs", loc="left", fontsize=12)
    axes.grid(visible=True, which="major", alpha=0.25)
    _legend(axes, rows)
    return _png(figure)


def history_png(found: Tradeoff) -> bytes:
    """Error over time of the candidates on the front, as PNG.

    Args:
        found: the trade-off.
    """
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    axes = figure.add_subplot()
    colours = cycle((_BLUE, _GREEN, _PURPLE, _SKY, _ORANGE, _BLACK, _GREY))
    times = np.array(found.reference.times)
    for number in _curves(found):
        row = found.rows[number]
        is_chosen, errors = number == found.choice, np.array(row.errors)
        seen = errors > _LEAST  # models begin in the reference's state, or nearly
        axes.plot(
            times[seen],
            errors[seen],
            color=_RED if is_chosen else next(colours),
            linewidth=2.4 if is_chosen else 1.2,
            label=f"{row.candidate.name}, step {_seconds(row.candidate.step)}"
            + (" (chosen)" if is_chosen else ""),
        )
    limit = f"tolerance {percent(found.tolerance)}"
    axes.axhline(found.tolerance, color=_RED, linestyle="--", linewidth=1.0, label=limit)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: percent(value)))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("error of displacements")
    axes.set_title("error over time of the models on the front", loc="left", fontsize=12)
    axes.grid(visible=True, alpha=0.25)
    figure.legend(fontsize=8, loc="outside lower left", ncols=2, frameon=False)
    return _png(figure)


def write_picture(png: bytes, path: Path) -> None:
    """Write a picture, all or nothing.

    Args:
        png: its bytes.
        path: file.
    """
    with atomic_path(path) as name:
        name.write_bytes(png)


def family(row: Measurement) -> str:
    """What candidates of one colour have in common."""
    candidate = row.candidate
    if candidate.kind == FULL:
        return "full order"
    if candidate.kind == FILTER:
        return "exact filter"
    assert candidate.model is not None
    return candidate.model.force


def _error(row: Measurement) -> float:
    return max(row.error or 0.0, _LEAST)


def _seconds(value: float) -> str:
    return duration(1e6 * value)


def _name_full_order(axes: Any, rows: list[Measurement]) -> None:
    """Say which law each diamond has; those at one height together, at the left one."""
    full = sorted((row for row in rows if row.candidate.kind == FULL), key=_error)
    groups: list[list[Measurement]] = []
    for row in full:
        if groups and _error(row) < _SAME_HEIGHT * _error(groups[-1][0]):
            groups[-1].append(row)
        else:
            groups.append([row])
    for group in groups:
        group.sort(key=lambda row: row.cost or 0.0)
        axes.annotate(
            ", ".join(row.candidate.law or "same law" for row in group),
            (group[0].cost, _error(group[0])), xytext=(-9, 0), textcoords="offset points",
            fontsize=8, color=_BLACK, ha="right", va="center",
        )  # fmt: skip


def _limits(axes: Any, found: Tradeoff, rows: list[Measurement]) -> None:
    told = f"tolerance {100 * found.tolerance:g} %" + (" (default)" if found.is_default else "")
    axes.axhline(found.tolerance, color=_RED, linestyle="--", linewidth=1.0, zorder=1)
    axes.annotate(
        told, (0.005, found.tolerance), xycoords=("axes fraction", "data"), color=_RED, fontsize=8,
        xytext=(0, 3), textcoords="offset points",
    )  # fmt: skip
    if found.rate is not None:
        limit = 1e6 / found.rate
        axes.axvline(limit, color=_RED, linestyle="--", linewidth=1.0, zorder=1)
        axes.annotate(
            f"{found.rate:g} steps a second", (limit, 0.01), xycoords=("data", "axes fraction"),
            color=_RED, fontsize=8, rotation=90, ha="right", va="bottom",
        )  # fmt: skip
    floor = found.reference.error
    if floor > _LEAST:
        axes.axhline(floor, color=_GREY, linestyle=":", linewidth=1.0, zorder=1)
        axes.annotate(
            "error of the reference itself", (0.005, floor), xycoords=("axes fraction", "data"),
            color=_GREY, fontsize=8, xytext=(0, 3), textcoords="offset points",
        )  # fmt: skip


def _front(axes: Any, found: Tradeoff) -> None:
    front = [found.rows[number] for number in found.front]
    costs, errors = [row.cost for row in front], [_error(row) for row in front]
    axes.step(costs, errors, where="post", color=_GREY, linewidth=1.4, zorder=2)
    axes.plot(
        costs, errors, "o", markersize=13, markerfacecolor="none", markeredgecolor=_BLACK,
        markeredgewidth=0.8, linestyle="none", zorder=4,
    )  # fmt: skip


def _choice(axes: Any, found: Tradeoff) -> None:
    row = found.chosen
    if row is None:
        return
    axes.plot(
        row.cost, _error(row), "*", markersize=19, color=_RED, markeredgecolor="white", zorder=5
    )
    text = textwrap.fill(f"chosen: {row.candidate.name}, step {_seconds(row.candidate.step)}", 30)
    # Where it would cover the tolerance it goes below.
    is_near = found.tolerance / 10.0 < _error(row) < found.tolerance
    axes.annotate(
        text, (row.cost, _error(row)), xytext=(12, -34 if is_near else 12),
        textcoords="offset points", fontsize=9, color=_RED, weight="bold", zorder=6,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.5},
    )  # fmt: skip


def _legend(axes: Any, rows: list[Measurement]) -> None:
    """Colours for forces, shapes for bases, sizes for steps."""
    style: dict[str, Any] = {"linestyle": "none", "markeredgecolor": "white"}
    known = [name for name in _FAMILIES if name in {family(row) for row in rows}]
    for name in known:
        marker = "D" if name == "full order" else "o"
        axes.plot([], [], marker=marker, color=_FAMILIES[name], label=name, markersize=8, **style)
    bases = {row.candidate.model.basis for row in rows if row.candidate.model is not None}
    for name in (base for base in _BASE_NAMES if base in bases):
        label = f"basis of {_BASE_NAMES[name]}"
        look = {**style, "markeredgecolor": _GREY, "markerfacecolor": "none"}
        look = look if name == "snapshots" else style
        axes.plot([], [], marker=_BASES[name], color=_GREY, label=label, markersize=8, **look)
    if any(row.candidate.factor > 1 for row in rows):
        axes.plot([], [], marker="o", color=_GREY, label="longer steps", markersize=5, **style)
    axes.plot(
        [], [], "o-", color=_GREY, markersize=11, markerfacecolor="none",
        markeredgecolor=_BLACK, label="Pareto front",
    )  # fmt: skip
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)


def _curves(found: Tradeoff) -> list[int]:
    """Rows whose errors are drawn: of the front some, the chosen one in any case."""
    front = [n for n in found.front if found.rows[n].candidate.kind != FULL]
    if len(front) > _MOST_CURVES:
        front = [front[i] for i in np.linspace(0, len(front) - 1, _MOST_CURVES).astype(int)]
    extra = [] if found.choice is None or found.choice in front else [found.choice]
    return front + extra


def _png(figure: Figure) -> bytes:
    buffer = io.BytesIO()
    FigureCanvasAgg(figure).print_png(buffer)
    figure.clear()
    return buffer.getvalue()
