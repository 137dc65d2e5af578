"""Parts of a trade-off on numbers made by hand: choice, front, pruning, times, frequencies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo.scene.records import MeshTable, RequireTable, Scene, TimeTable
from fenics_defo.scene.trade.choosing import (
    Limits,
    choose,
    duration,
    in_order,
    pareto_front,
)
from fenics_defo.scene.trade.comparing import Yardstick
from fenics_defo.scene.trade.full import Recorded
from fenics_defo.scene.trade.pruning import far_from, is_near_rest
from fenics_defo.scene.trade.records import (
    FULL,
    MEASURED,
    PRUNED,
    REDUCED,
    Candidate,
    Measurement,
    ModelSpec,
)
from fenics_defo.scene.trade.sampling import sampling
from fenics_defo.scene.trade.spectrum import strongest_frequency

STEP = 1e-3


def row(
    error: float, microseconds: float, *, factor: int = 1, basis: str = "linear"
) -> Measurement:
    spec = ModelSpec(basis=basis, size=10, force="cubic")
    return Measurement(
        candidate=Candidate(
            kind=REDUCED,
            model=spec,
            integrator="implicit-newmark",
            step=factor * STEP,
            factor=factor,
        ),
        status=MEASURED,
        error=error,
        microseconds=microseconds,
    )


def limits(tolerance: float = 0.01, rate: float | None = None) -> Limits:
    return Limits(tolerance=tolerance, rate=rate, step=STEP)


def test_the_cheapest_good_one_is_chosen() -> None:
    rows = in_order([row(0.001, 90.0), row(0.5, 5.0), row(0.008, 40.0), row(0.02, 20.0)])
    choice, misses, reason = choose(rows, limits())
    assert choice is not None
    assert rows[choice].microseconds == 40.0
    assert misses == ()
    assert "0.8 %" in reason
    assert "2 %" in reason  # the best of the cheaper ones


def test_of_equally_cheap_ones_the_more_accurate_is_chosen() -> None:
    rows = in_order([row(0.009, 10.0), row(0.001, 11.0), row(0.0001, 20.0)])
    choice, _, _ = choose(rows, limits())
    assert choice is not None
    assert rows[choice].error == 0.001


def test_a_longer_step_is_cheaper_for_the_same_time_of_a_step() -> None:
    rows = in_order([row(0.005, 10.0), row(0.005, 10.0, factor=4)])
    choice, _, _ = choose(rows, limits())
    assert choice is not None
    assert rows[choice].candidate.factor == 4
    # But its states come 250 times a second only.
    choice, _, _ = choose(rows, limits(rate=1000.0))
    assert choice is not None
    assert rows[choice].candidate.factor == 1


def test_what_is_made_from_this_motion_is_chosen_where_nothing_else_fits() -> None:
    trained = row(1e-6, 1.0, basis="snapshots")
    rows = in_order([trained, row(0.005, 50.0)])
    assert choose(rows, limits())[0] == 1
    assert pareto_front(rows) == (1,)
    assert pareto_front(rows, trained=True) == (0,)
    choice, _, reason = choose(in_order([trained, row(0.05, 50.0)]), limits())
    assert choice == 0
    assert "made from this very motion" in reason


def test_where_none_fits_the_nearest_misses_are_told() -> None:
    rows = in_order([row(0.5, 5.0), row(0.012, 400.0), row(0.02, 90.0), row(0.001, 5000.0)])
    choice, misses, reason = choose(rows, limits(rate=1000.0))
    assert choice is None
    assert [rows[n].error for n in misses] == [0.012, 0.02, 0.001]
    assert "no model has an error of at most 1 % at 1000 steps a second" in reason


def test_full_order_is_never_chosen() -> None:
    whole = Measurement(
        candidate=Candidate(kind=FULL, integrator="implicit-newmark", step=STEP),
        status=MEASURED,
        error=1e-6,
        microseconds=1.0,
    )
    assert choose([whole], limits())[0] is None
    left_out = Measurement(candidate=row(1.0, 1.0).candidate, status=PRUNED, reason="far")
    assert choose([left_out], limits())[:2] == (None, ())


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(1e-6, 1.0), st.floats(1.0, 1e6), st.sampled_from((1, 2, 4))),
        min_size=1,
        max_size=30,
    )
)
def test_no_row_beats_one_on_the_front(values: list[tuple[float, float, int]]) -> None:
    rows = in_order([row(e, t, factor=f) for e, t, f in values])
    front = pareto_front(rows)
    assert front
    for number, each in enumerate(rows):
        beaten = [
            n
            for n in front
            if rows[n].cost <= each.cost and rows[n].error <= each.error / 0.99  # type: ignore[operator]
        ]
        assert beaten or number in front
    costs = [rows[n].cost for n in front]
    assert costs == sorted(costs)  # type: ignore[type-var]


def test_errors_below_that_of_the_reference_count_as_equal() -> None:
    rows = in_order([row(0.03, 5.0), row(0.004, 10.0), row(0.0001, 20.0), row(0.002, 11.0)])
    assert pareto_front(rows) == (0, 1, 2, 3)
    assert pareto_front(rows, 0.005) == (0, 1)
    choice, _, _ = choose(rows, Limits(tolerance=0.01, rate=None, step=STEP, floor=0.005))
    assert choice == 1


def test_a_basis_that_is_far_off_is_left_out() -> None:
    spec = ModelSpec(basis="linear", size=5, force="cubic")
    known = {"energy_ratio": 1.0, "is_linear": False}
    assert not far_from(spec, tolerance=0.01, best_error=0.02, **known)
    assert "misses 40 %" in far_from(spec, tolerance=0.01, best_error=0.4, **known)
    assert not far_from(spec, tolerance=0.2, best_error=0.4, **known)


def test_linear_forces_are_left_out_where_the_body_bends_far() -> None:
    linear = ModelSpec(basis="linear", size=5, force="linear")
    cubic = ModelSpec(basis="linear", size=5, force="cubic")
    bent = {"tolerance": 0.01, "best_error": 0.0, "energy_ratio": 7.0}
    assert "7 times" in far_from(linear, is_linear=False, **bent)
    assert not far_from(cubic, is_linear=False, **bent)
    assert [is_near_rest(ratio) for ratio in (1.0, 0.9, 7.0, 0.5, None)] == [True] * 2 + [False] * 3
    assert not far_from(linear, is_linear=True, **bent)
    assert not far_from(linear, is_linear=False, **{**bent, "energy_ratio": 1.3})
    assert not far_from(linear, is_linear=False, **{**bent, "tolerance": 0.5})


@pytest.mark.parametrize("steps", [1, 7, 40, 1000, 123457])
@pytest.mark.parametrize("factors", [(1,), (1, 2, 4)])
def test_states_are_compared_where_all_steps_end(
    tmp_path, steps: int, factors: tuple[int, ...]
) -> None:
    scene = Scene(
        path=tmp_path / "scene.toml",
        mesh=MeshTable(file=tmp_path / "none.msh"),
        time=TimeTable(integrator="implicit-newmark", step=STEP, duration=steps * STEP),
        require=RequireTable(),
    )
    found = sampling(scene, 100, factors)
    assert found.count <= 201
    assert len(found.times) == found.count
    assert found.times[-1] <= scene.time.duration * (1 + 1e-12)
    assert all(found.stride % factor == 0 for factor in factors)
    if steps >= 1000:
        assert found.count >= 100
    assert sampling(scene, 10**9, factors).count <= 11


@pytest.mark.parametrize("frequency", [3.0, 7.77, 21.3])
def test_the_frequency_of_a_sine_is_found(frequency: float) -> None:
    times = np.arange(200) * 0.01
    found = strongest_frequency(0.3 + np.sin(2 * np.pi * frequency * times), 0.01)
    assert found == pytest.approx(frequency, rel=2e-3)


def test_no_frequency_is_told_of_less_than_two_periods() -> None:
    times = np.arange(200) * 0.01
    assert strongest_frequency(np.sin(2 * np.pi * 0.4 * times), 0.01) is None
    assert strongest_frequency(np.ones(200), 0.01) is None
    assert strongest_frequency(times**2, 0.01) is None
    assert strongest_frequency(np.sin(times[:5]), 0.01) is None


def yardstick(outputs: list[int] | None = None) -> Yardstick:
    random = np.random.default_rng(3)
    states = random.standard_normal((6, 4, 3)) * np.linspace(0, 1, 6)[:, None, None]
    reference = Recorded(states, np.ones((6, 2)), states[:, :1], np.ones(5))
    rows = None if outputs is None else np.array(outputs)
    return Yardstick(reference, np.array([1.0, 2.0, 3.0, 4.0]), rows, 0.1, ("a",))


def test_errors_are_relative_to_the_largest_displacement_by_mass() -> None:
    stick, half = yardstick(), yardstick([1, 3])
    states = stick.reference.displacements
    masses = stick.masses
    largest = max(np.sqrt(masses @ (u**2).sum(axis=1)) for u in states)
    moved = states[4] + 0.01
    expected = np.sqrt(3 * masses.sum()) * 0.01 / largest
    assert stick.error(4, moved) == pytest.approx((expected, expected), rel=1e-12)
    assert half.error(4, states[4]) == (0.0, 0.0)
    apart = states[4].copy()
    apart[0] += 1.0  # no output
    assert half.error(4, apart)[0] == 0.0
    assert half.error(4, apart)[1] > 0.0


def test_the_best_of_a_basis_falls_to_nothing_as_it_grows() -> None:
    random = np.random.default_rng(4)
    for stick in (yardstick(), yardstick([0, 2])):
        errors = stick.best_errors(random.standard_normal((6, 4, 3)))
        assert (np.diff(errors) <= 1e-12).all()
        assert errors[-1] > 0.0 or stick.outputs is not None
    everything = np.eye(12).reshape(12, 4, 3)
    errors = yardstick().best_errors(everything)
    assert errors[0] > 0.1
    assert errors[-1] < 1e-7
    inside = yardstick().reference.displacements[1:3]
    only = Yardstick(
        Recorded(inside, np.ones((2, 2)), inside[:, :1], np.ones(1)),
        np.array([1.0, 2.0, 3.0, 4.0]),
        None,
        0.1,
        ("a",),
    )
    assert only.best_errors(inside)[-1] < 1e-7


def test_times_are_told_in_three_digits() -> None:
    told = [duration(value) for value in (4.567, 999.7, 12345.0, 2.5e6, None)]
    assert told == ["4.57 µs", "1 ms", "12.3 ms", "2.5 s", "-"]
