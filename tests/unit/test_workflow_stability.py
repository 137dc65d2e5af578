"""The reduced stability map: its cells are sound, and what theory demands stands in them."""

import math
import time
from functools import partial

import pytest

from fenics_defo import analysis
from workflows import stability
from workflows.stability_map import report
from workflows.stability_map.cases import Case, Cell
from workflows.stability_map.outcomes import Kind, Measured, judged
from workflows.stability_map.references import oscillator
from workflows.stability_map.runner import run

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cells() -> list[Cell]:
    return stability.compute(stability.all_cases(quick=True))


def chosen(cells: list[Cell], sweep: str, row: str = "", column: str = "") -> list[Cell]:
    found = [
        cell
        for cell in cells
        if cell.sweep.startswith(sweep) and row in cell.row and column in ("", cell.column)
    ]
    assert found, (sweep, row, column)
    return found


def test_no_cell_hangs_crashes_or_deceives(cells: list[Cell]) -> None:
    assert not [
        (cell.sweep, cell.row, cell.column, cell.outcome) for cell in report.findings(cells)
    ]


def test_explicit_steps_above_the_limit_are_refused_with_the_limit(cells: list[Cell]) -> None:
    for column in ("1.01", "10000"):
        for cell in chosen(cells, "Time step: central differences", column=column):
            if "allowed" not in cell.sweep:
                assert cell.outcome.kind is Kind.REFUSED
                assert "largest stable step" in cell.outcome.message


def test_explicit_steps_below_the_limit_are_right(cells: list[Cell]) -> None:
    for cell in chosen(cells, "Time step: central differences", column="0.99"):
        assert cell.outcome.kind is Kind.RIGHT


def test_an_unstable_motion_that_was_asked_for_ends_with_a_message(cells: list[Cell]) -> None:
    for cell in chosen(cells, "Time step: central differences, unstable"):
        assert cell.outcome.kind is Kind.DIVERGED


def test_average_acceleration_is_stable_on_the_linear_body_at_any_step(cells: list[Cell]) -> None:
    (cell,) = chosen(cells, "Time step: Newmark, 1 iteration", "linear", "10000")
    assert cell.outcome.kind is Kind.INACCURATE
    assert "residual" in cell.outcome.message


def test_scales_cost_no_digits(cells: list[Cell]) -> None:
    for sweep in ("Young's modulus", "Size of the body"):
        for cell in chosen(cells, sweep):
            if "step" not in cell.row:
                assert cell.outcome.error is not None
                assert cell.outcome.error < 1e-6


def test_poisson_ratio_of_one_half_is_refused() -> None:
    cases = [case for case in stability.all_cases(quick=False, only=["tension; linear; 0.5"])]
    (cell,) = stability.compute(cases)
    assert cell.outcome.kind is Kind.REFUSED
    assert "0.5" in cell.outcome.message


def test_flat_cells_recover_where_the_law_allows(cells: list[Cell]) -> None:
    (cell,) = chosen(cells, "Recovery", "invertible", "flat")
    assert cell.outcome.kind is Kind.RIGHT


def test_the_page_lists_every_table_and_figure(cells: list[Cell]) -> None:
    text = report.page(cells, 1.0, machine="a machine")
    assert all(row in text for row in {cell.row for cell in cells})
    assert "None: no cell hung" in text


def test_a_finding_is_listed_on_the_page() -> None:
    bad = judged(Measured(error=0.1, growth=100.0))
    text = report.page([Cell("Sweep", "row", "1", bad, 0.1)], 1.0, machine="a machine")
    assert "Sweep; row; 1: **WRONG" in text


def die() -> Measured:
    raise SystemExit(3)


def sleep() -> Measured:

    time.sleep(60.0)
    return Measured(error=0.0)


def number(value: float) -> Measured:
    return Measured(error=value)


def test_crashes_hangs_and_nans_are_cells_and_the_next_ones_go_on() -> None:
    computations = [("die", die), ("sleep", sleep), ("nan", partial(number, math.nan))]
    computations.append(("fine", partial(number, 1e-9)))
    cases = [
        Case(
            sweep="s",
            row=name,
            column="1",
            compute=compute,
            patience=2.0 if name == "sleep" else 60.0,
        )
        for name, compute in computations
    ]
    kinds = [cell.outcome.kind for cell in run(cases, jobs=1, told=lambda cell: None)]
    assert kinds == [Kind.CRASH, Kind.HANG, Kind.SILENT_NAN, Kind.RIGHT]


def test_the_scalar_references_are_the_closed_forms() -> None:
    omega, step, count = 3.0, 0.2, 40
    turn = omega * step
    exact = {
        analysis.ImplicitNewmark(): lambda n: math.sin(2.0 * n * math.atan(0.5 * turn)),
        analysis.BackwardEuler(): lambda n: ((1.0 - 1j * turn) ** -n).imag,
        analysis.CentralDifferences(): lambda n: (
            math.sin(2.0 * n * math.asin(0.5 * turn)) / math.sqrt(1.0 - 0.25 * turn**2)
        ),
    }
    for integrator, closed in exact.items():
        path = oscillator(integrator, omega, step, count)
        for n in (1, 7, count):
            assert path[n] == pytest.approx(closed(n), abs=1e-12)
