"""One page about a trade-off that needs nothing else: no scripts, no other files, no hosts."""

import base64
from html import escape
from pathlib import Path

from fenics_defo.runtime import atomic_path
from fenics_defo.scene.trade.choosing import duration, percent, step_text
from fenics_defo.scene.trade.records import FILTER, Measurement, Tradeoff
from fenics_defo.view.trade_charts import chart_png, history_png, write_picture
from fenics_defo.view.trade_table import (
    bytes_text,
    left_out_html,
    measured_rows,
    method_text,
    seconds_text,
    table_html,
    telling_rows,
    times_text,
)

CHART, HISTORY, REPORT = "tradeoff.png", "errors.png", "report.html"

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff;
  max-width: 72rem; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.6rem; margin-bottom: .2rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
.sub { color: #666; margin-top: 0; }
.answer { border-left: 5px solid #009e73; background: #f2faf7; padding: .8rem 1.1rem; }
.answer.none { border-color: #d55e00; background: #fdf4ee; }
.answer b.big { font-size: 1.2rem; }
img { max-width: 100%; height: auto; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #e3e3e3; text-align: right;
  white-space: nowrap; }
th { border-bottom: 2px solid #999; vertical-align: bottom; }
td.text, th.text { text-align: left; }
tr.chosen td { background: #e2f4ec; font-weight: 600; }
tr.front td.text:first-child::after { content: " \\25CB"; }
td.bad { color: #b3471b; } td.good { color: #00734f; }
dl { display: grid; grid-template-columns: max-content auto; gap: .15rem 1.2rem; }
dt { color: #666; } dd { margin: 0; }
pre { background: #f6f6f6; padding: .6rem .8rem; overflow-x: auto; font-size: 13px; }
details { margin: .8rem 0; } summary { cursor: pointer; color: #0072b2; }
"""


def write_report(found: Tradeoff, folder: Path) -> tuple[str, ...]:
    """Write ``tradeoff.png``, ``errors.png`` and ``report.html``.

    Args:
        found: the trade-off.
        folder: that they go to.

    Returns:
        the names of the files.
    """
    chart, history = chart_png(found), history_png(found)
    write_picture(chart, folder / CHART)
    write_picture(history, folder / HISTORY)
    with atomic_path(folder / REPORT) as name:
        name.write_text(report_html(found, chart, history), "utf-8")
    return CHART, HISTORY, REPORT


def report_html(found: Tradeoff, chart: bytes, history: bytes) -> str:
    """The page.

    Args:
        found: the trade-off.
        chart: picture of error against cost, PNG.
        history: picture of error over time, PNG.
    """
    name = escape(Path(found.scene).name)
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{name}: which model does it require?</title><style>{_STYLE}</style></head><body>",
        f"<h1>{name}</h1><p class='sub'>{escape(found.title)}</p>",
        _answer(found),
        "<h2>What accuracy costs</h2>",
        _image(chart, "error against the time for one step of the scene"),
        "<p>Each mark is one way to compute this scene. Down is more accurate, left is cheaper; "
        "circled marks are beaten by no other in both. Hollow squares know this very motion and do "
        "not count.</p>",
        "<h2>Error over time</h2>",
        _image(history, "error over time of the candidates on the front"),
        "<h2>What it was held against</h2>",
        _reference(found),
        "<h2>What was measured</h2>",
        table_html(found, telling_rows(found)),
        f"<details><summary>All {len(measured_rows(found))} that were measured</summary>",
        table_html(found, measured_rows(found)),
        "</details>",
        left_out_html(found),
        _notes(found),
        _scene_text(found),
        "</body></html>",
    ]
    return "\n".join(parts) + "\n"


def _answer(found: Tradeoff) -> str:
    row = found.chosen
    if row is None:
        misses = "".join(f"<li>{_short(found.rows[n])}</li>" for n in found.misses)
        return (
            "<div class='answer none'><b class='big'>No model fits.</b>"
            f"<p>{escape(_sentence(found.reason))}</p>"
            + (f"<p>Nearest misses:</p><ul>{misses}</ul>" if misses else "")
            + "<p>Allow a larger error, ask for fewer steps a second, or look at fewer outputs in "
            "<code>[require]</code>.</p></div>"
        )
    candidate = row.candidate
    rate = "" if found.rate is None else f", at least {found.rate:g} steps a second"
    default = " (the scene names none: the default)" if found.is_default else ""
    return (
        f"<div class='answer'><b class='big'>{escape(candidate.name)}</b>"
        f"<p>Saved as <code>{escape(found.model)}</code>; step it by "
        f"{escape(method_text(row))} with {candidate.step:.6g} s:</p>"
        f"<pre>{escape(_recipe(found, row))}</pre>"
        f"<p>{escape(_sentence(found.reason))}</p>"
        f"<dl><dt>asked for</dt><dd>error at most {percent(found.tolerance)}{default}{rate}</dd>"
        f"<dt>error</dt><dd>{percent(row.error)} at worst, {percent(row.error_rms)} root mean "
        f"square</dd><dt>a step</dt><dd>{duration(row.microseconds)} (99 of 100 within "
        f"{duration(row.microseconds_p99)}), {times_text(row.real_time)} real time</dd>"
        f"<dt>made in</dt><dd>{seconds_text(row.offline_seconds)}, "
        f"{bytes_text(row.model_bytes)}</dd>"
        "</dl></div>"
    )


def _recipe(found: Tradeoff, row: Measurement) -> str:
    """How the chosen model is run as it was measured."""
    candidate = row.candidate
    classes = {
        "exact": "ModalFilter",
        "implicit-newmark": "ImplicitNewmark",
        "backward-euler": "BackwardEuler",
        "central-differences": "CentralDifferences",
        "symplectic-euler": "SymplecticEuler",
    }
    if candidate.integrator not in classes or found.flies:
        return f"fenics-defo play {found.model} {Path(found.scene).name} --output played"
    more = ', hold="linear"' if candidate.kind == FILTER else ""
    return (
        "from fenics_defo import runtime\n\n"
        f'model = runtime.load("{found.model}")\n'
        f"motion = runtime.{classes[candidate.integrator]}(model, step={candidate.step!r}{more})\n"
        "motion.advance(load)  # load (r,): see model.load, model.gravity, model.point_load\n"
        "model.displacement(motion.q)  # of the stored nodes [m]"
    )


def _reference(found: Tradeoff) -> str:
    reference = found.reference
    facts = [
        ("reference", f"all {reference.unknowns:,} unknowns, step {reference.step:.4g} s"),
        ("its own error", f"{percent(reference.error)}, estimated from the run at twice its step"),
        ("largest displacement", f"{reference.largest:.4g} m"),
    ]
    if reference.mesh_error is not None:
        facts.append(
            ("error of the mesh", f"{percent(reference.mesh_error)}, by a run of second order")
        )
    if reference.frequency is not None:
        facts.append(("strongest frequency", f"{reference.frequency:.4g} Hz"))
    if reference.energy_ratio is not None:
        facts.append(
            (
                "energy of linear forces",
                f"{reference.energy_ratio:.3g} times the true one at the largest displacement "
                "(1: small displacements)",
            )
        )
    machine = found.machine
    facts.append(
        (
            "machine",
            f"{machine['processor']}, {machine['cores']} cores, Python {machine['python']}, "
            f"NumPy {machine['numpy']}, fenics_defo {found.version}",
        )
    )
    rows = "".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in facts)
    return f"<dl>{rows}</dl>"


def _notes(found: Tradeoff) -> str:
    text = [
        "The error is the norm of the difference of displacements, weighed by the mass at the "
        "nodes, over its largest value in the reference; the largest over the motion decides.",
        "Errors below that of the reference itself (the dotted line) say nothing: they count as "
        "equal to it.",
        "Models are made within the first columns of the largest basis of their kind, whose making "
        "counts for each.",
        "The time of a step is the runtime's alone: no files, no energies. Full order is there to "
        "be compared with and is never chosen.",
    ]
    if any(row.candidate.is_trained for row in found.rows):
        text.append(
            "A basis of the training motion is made from this very motion: for other motions of "
            "the body expect it to be worse than here. It is chosen only where nothing else fits."
        )
    return "<h2>How to read this</h2><ul>" + "".join(f"<li>{t}</li>" for t in text) + "</ul>"


def _scene_text(found: Tradeoff) -> str:
    """The scene file as it is, if it still is."""
    try:
        text = Path(found.scene).read_text("utf-8")
    except (OSError, UnicodeDecodeError):
        return ""
    return f"<details><summary>The scene file</summary><pre>{escape(text)}</pre></details>"


def _short(row: Measurement) -> str:
    return escape(
        f"{row.candidate.name}, {method_text(row)}, step {step_text(row)}: error "
        f"{percent(row.error)}, {duration(row.microseconds)} a step"
    )


def _image(png: bytes, what: str) -> str:
    data = base64.b64encode(png).decode("ascii")
    return f"<img alt='{escape(what)}' src='data:image/png;base64,{data}'>"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."
