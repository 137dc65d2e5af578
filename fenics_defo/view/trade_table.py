"""The tables of a trade-off's page."""

from html import escape

from fenics_defo.scene.trade.choosing import duration, percent, step_text
from fenics_defo.scene.trade.records import FULL, MEASURED, PRUNED, Measurement, Tradeoff


def measured_rows(found: Tradeoff) -> list[int]:
    """Numbers of the rows that were measured."""
    return [number for number, row in enumerate(found.rows) if row.status == MEASURED]


def telling_rows(found: Tradeoff) -> list[int]:
    """Rows that tell most: the front, the choice or the misses, the whole body."""
    telling = {*found.front, *found.misses, *([] if found.choice is None else [found.choice])}
    return [n for n in measured_rows(found) if n in telling or found.rows[n].candidate.kind == FULL]


def table_html(found: Tradeoff, numbers: list[int]) -> str:
    """A table of some rows, the cheapest first.

    Args:
        found: the trade-off.
        numbers: of the rows.
    """
    head = (
        "<th class='text'>model</th><th class='text'>method</th><th>step</th><th>error</th>"
        "<th>rms</th><th>basis<br>at best</th><th>energy</th><th>frequency</th>"
        "<th>a step</th><th>p99</th><th>real<br>time</th><th>batch<br>steps/s</th>"
        "<th>made in</th><th>file</th>"
    )
    body = "".join(
        _line(found, number, row) for number, row in enumerate(found.rows) if row.status == MEASURED
    )
    return (
        f"<div class='scroll'><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        "</div><p class='sub'>The cheapest for one step of the scene first. \u25cb: on the front. "
        "Errors are relative to the reference's largest.</p>"
    )


def _line(found: Tradeoff, number: int, row: Measurement) -> str:
    classes = ["chosen"] if number == found.choice else []
    classes += ["front"] if number in found.front else []
    judged = "good" if row.error is not None and row.error <= found.tolerance else "bad"
    batch = "-" if row.batch_rate is None else f"{row.batch_rate:,.0f}"
    made = "-" if row.candidate.kind == FULL else seconds_text(row.offline_seconds)
    cells = [
        f"<td class='text'>{escape(row.candidate.name)}</td>",
        f"<td class='text'>{escape(method_text(row))}</td>",
        f"<td>{duration(1e6 * row.candidate.step)}</td>",
        f"<td class='{judged}'>{percent(row.error)}</td>",
        *(
            f"<td>{percent(value)}</td>"
            for value in (row.error_rms, row.best_error, row.energy_error, row.frequency_error)
        ),
        f"<td>{duration(row.microseconds)}</td><td>{duration(row.microseconds_p99)}</td>",
        f"<td>{times_text(row.real_time)}</td><td>{batch}</td>",
        f"<td>{made}</td><td>{bytes_text(row.model_bytes)}</td>",
    ]
    return f"<tr class='{' '.join(classes)}'>{''.join(cells)}</tr>"


def left_out_html(found: Tradeoff) -> str:
    """What was not measured, and why; nothing where there is none."""
    rest = [row for row in found.rows if row.status != MEASURED]
    if not rest:
        return ""
    reasons: dict[tuple[str, str], str] = {}
    for row in rest:
        # One line for all steps and methods of a model that have the same reason.
        what = row.candidate.model.name if row.candidate.model else row.candidate.name
        if row.status != PRUNED:
            what = f"{row.candidate.name}, {method_text(row)}, step {step_text(row)}"
        reasons[what, row.reason] = "left out" if row.status == PRUNED else "failed"
    lines = "".join(
        f"<tr><td class='text'>{escape(what)}</td><td class='text'>{state}</td>"
        f"<td class='text' style='white-space: normal'>{escape(reason)}</td></tr>"
        for (what, reason), state in reasons.items()
    )
    return f"<h2>What was not measured, and why</h2><table><tbody>{lines}</tbody></table>"


def method_text(row: Measurement) -> str:
    """By what a candidate moves."""
    names = {"exact": "the exact filter", "static": "load steps"}
    return names.get(row.candidate.integrator, row.candidate.integrator)


def times_text(value: float | None) -> str:
    """A factor as text."""
    return "-" if value is None else f"{value:,.3g} ×" if value < 1000 else f"{value:,.0f} ×"


def seconds_text(value: float | None) -> str:
    """A time [s] as text."""
    return "-" if value is None else f"{value:.3g} s"


def bytes_text(value: int | None) -> str:
    """A size as text."""
    return (
        "-"
        if value is None
        else f"{value / 1e3:,.3g} kB"
        if value < 1e6
        else (f"{value / 1e6:,.3g} MB")
    )
