"""A whole trade-off of a body of two cells: what is measured, kept, chosen and written."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo import runtime
from fenics_defo.analysis import Simulation
from fenics_defo.errors import DivergenceError, SceneError
from fenics_defo.scene import Extent, Tradeoff, play, read_scene, tradeoff
from fenics_defo.scene.trade import bench, measuring, timing
from fenics_defo.scene.trade.records import FAILED, FILTER, FULL, MEASURED, PRUNED
from fenics_defo.view.trade_report import write_report
from tests.unit.scene.two_cells import IMPULSES, MOTIONS, SCENE, write_scene

# All motions of the body, with the forces of its law: as good as the full order.
ALL = Extent(
    modes=(3, MOTIONS),
    sizes=(12,),
    plain=MOTIONS,
    training=(4,),
    cubatures=(0.05,),
    cubature_sizes=(12,),
    factors=(1, 2),
    integrators=("backward-euler",),
    laws=("linear",),
)
FEW = Extent(
    modes=(4, MOTIONS),
    sizes=(),
    plain=MOTIONS,
    training=(),
    cubatures=(),
    laws=(),
    factors=(1,),
    integrators=(),
)
REQUIRE = '\n[require]\ntolerance = 0.02\noutputs = "roof"\n'
FAST = SCENE.replace("step = 1e-3\nduration = 0.04", "step = 2e-3\nduration = 0.04")


@pytest.fixture(scope="module", autouse=True)
def _short_timing() -> Iterator[None]:
    """Times need not be good here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timing, "_ROUNDS", 1)
        patch.setattr(timing, "_SECONDS", 0.01)
        yield


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Tradeoff, Path]:
    folder = tmp_path_factory.mktemp("trade")
    scene = write_scene(folder, SCENE + REQUIRE)
    return tradeoff(scene, folder / "out", extent=ALL), folder


def row_of(found: Tradeoff, **wanted: Any) -> Any:
    for row in found.rows:
        parts = {"kind": row.candidate.kind, "factor": row.candidate.factor}
        parts |= {"law": row.candidate.law, "integrator": row.candidate.integrator}
        if row.candidate.model is not None:
            model = row.candidate.model
            parts |= {"force": model.force, "size": model.size, "basis": model.basis}
        if all(parts.get(name) == value for name, value in wanted.items()):
            return row
    raise AssertionError(wanted)


def test_a_model_with_all_motions_errs_as_the_full_order(
    measured: tuple[Tradeoff, Path],
) -> None:
    found, _ = measured
    full = row_of(found, kind=FULL, law="")
    model = row_of(
        found, basis="linear", force="cubic", size=MOTIONS, factor=1, integrator="implicit-newmark"
    )
    assert full.error > 1e-5
    np.testing.assert_allclose(model.errors, full.errors, rtol=1e-6, atol=1e-12)
    assert model.best_error < 1e-6
    assert model.energy_error == pytest.approx(full.energy_error, rel=1e-4)
    assert model.probe_errors["tip"] == pytest.approx(full.probe_errors["tip"], rel=1e-4)
    # Linear forces of all motions are those of the linear law at full order.
    linear = row_of(found, force="linear", size=MOTIONS, factor=1, integrator="implicit-newmark")
    other = row_of(found, kind=FULL, law="linear")
    np.testing.assert_allclose(linear.errors, other.errors, rtol=1e-6, atol=1e-12)


def test_halving_the_step_tells_the_error_of_the_reference(
    measured: tuple[Tradeoff, Path],
) -> None:
    found, _ = measured
    full = row_of(found, kind=FULL, law="")
    assert found.reference.step == 0.5e-3
    assert found.reference.error == pytest.approx(full.error / 3.0, rel=1e-12)
    # Of second order: twice the step, five times the distance from the run at half of it.
    twice = row_of(
        found, basis="linear", force="cubic", size=MOTIONS, factor=2, integrator="implicit-newmark"
    )
    assert twice.error == pytest.approx(5.0 * full.error, rel=0.3)


def test_the_filter_is_as_good_as_linear_steps(measured: tuple[Tradeoff, Path]) -> None:
    found, _ = measured
    exact = row_of(found, kind=FILTER, size=MOTIONS, factor=1)
    steps = row_of(found, force="linear", size=MOTIONS, factor=1, integrator="implicit-newmark")
    assert exact.error == pytest.approx(steps.error, rel=0.05)
    assert exact.batch_rate > 0.0


def test_what_cannot_help_is_left_out_with_its_reason(measured: tuple[Tradeoff, Path]) -> None:
    found, _ = measured
    left = [row for row in found.rows if row.status == PRUNED]
    assert left
    assert all("at best, and 2 % is allowed" in row.reason for row in left)
    assert all(row.best_error > 0.02 for row in left)
    assert not [row for row in found.rows if row.status == FAILED]


def test_the_cheapest_good_model_is_written(measured: tuple[Tradeoff, Path]) -> None:
    found, folder = measured
    chosen = found.chosen
    assert chosen is not None
    assert chosen.error <= 0.02
    good = [
        row.cost
        for row in found.rows
        if row.status == MEASURED
        and row.candidate.kind != FULL
        and not row.candidate.is_trained
        and row.error <= 0.02
    ]
    assert chosen.cost <= 1.2 * min(good)
    model = runtime.load(folder / "out" / "model.npz")
    assert len(model.nodes) == 4  # of the roof
    assert model.size == chosen.candidate.model.size
    certificate = model.certificate["scene"]
    assert certificate["error"] == chosen.error
    assert certificate["step_s"] == chosen.candidate.step
    assert (folder / "out" / "model.npz").stat().st_size >= chosen.model_bytes
    summary = play(folder / "out" / "model.npz", folder / "scene.toml", folder / "played")
    assert summary["status"] == "finished"


def test_tables_and_pictures_hold_all_rows(measured: tuple[Tradeoff, Path]) -> None:
    found, folder = measured
    record = json.loads((folder / "out" / "tradeoff.json").read_text("utf-8"))
    assert len(record["rows"]) == len(found.rows)
    assert record["chosen"]["name"] == found.chosen.candidate.name  # type: ignore[union-attr]
    table = (folder / "out" / "tradeoff.csv").read_text("utf-8").splitlines()
    assert len(table) == 1 + len(found.rows)
    assert "error_tip" in table[0].split(",")
    assert write_report(found, folder / "out") == ("tradeoff.png", "errors.png", "report.html")
    for name in ("tradeoff.png", "errors.png"):
        assert (folder / "out" / name).read_bytes().startswith(b"\x89PNG")
    page = (folder / "out" / "report.html").read_text("utf-8")
    for word in ("<script", "http:", "https:", "src='/", "<link"):
        assert word not in page
    assert page.count("data:image/png;base64,") == 2
    assert "st-venant-kirchhoff" in page  # of the scene file
    for row in found.rows:
        model = row.candidate.model
        assert (model.name if model else row.candidate.name) in page


def counted(monkeypatch: pytest.MonkeyPatch, name: str, stop_at: int | None = None) -> list[Any]:
    """Count the calls of a function of the bench; the one of that number is interrupted."""
    calls: list[Any] = []
    work: Callable[..., Any] = getattr(bench, name)

    def call(*arguments: Any, **options: Any) -> Any:
        calls.append(arguments[0])
        if len(calls) == stop_at:
            raise KeyboardInterrupt
        return work(*arguments, **options)

    monkeypatch.setattr(bench, name, call)
    return calls


def test_what_is_interrupted_goes_on_and_nothing_is_measured_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = write_scene(tmp_path, FAST)
    with monkeypatch.context() as patch:
        first = counted(patch, "measure_model", stop_at=2)
        with pytest.raises(KeyboardInterrupt):
            tradeoff(scene, tmp_path / "out", extent=FEW)
    with monkeypatch.context() as patch:
        second = counted(patch, "measure_model")
        found = tradeoff(scene, tmp_path / "out", extent=FEW)
    assert len(first) == 2
    assert second[0] in first  # the model that was under way
    models = [row for row in found.rows if row.candidate.kind != FULL and row.status == MEASURED]
    assert len({row.candidate for row in models}) == len(models)
    with monkeypatch.context() as patch:
        third = counted(patch, "measure_model")
        again = tradeoff(scene, tmp_path / "out", extent=FEW)
        assert third == []
        assert again.rows == found.rows
        # What is required of the model changes the choice alone.
        write_scene(tmp_path, FAST + "\n[require]\nrate = 1e9\n")
        none = tradeoff(scene, tmp_path / "out", extent=FEW)
        assert third == []
        assert none.choice is None
        assert none.misses
        assert not (tmp_path / "out" / "model.npz").exists()
        write_report(none, tmp_path / "out")
        assert "No model fits." in (tmp_path / "out" / "report.html").read_text("utf-8")
        # Another scene is measured anew.
        write_scene(tmp_path, FAST.replace("stiffness = 2e-4", "stiffness = 4e-4"))
        tradeoff(scene, tmp_path / "out", extent=FEW)
        assert len(third) == len(models)


def test_an_interrupted_reference_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = write_scene(tmp_path, FAST)
    whole = tradeoff(scene, extent=FEW)
    steps = []
    advance = Simulation.advance

    def counting(self: Simulation) -> Any:
        steps.append(self.steps)
        if len(steps) == 35:  # the second run, at half the step
            raise KeyboardInterrupt
        return advance(self)

    with monkeypatch.context() as patch:
        patch.setattr(Simulation, "advance", counting)
        with pytest.raises(KeyboardInterrupt):
            tradeoff(scene, tmp_path / "out", extent=FEW)
        found = tradeoff(scene, tmp_path / "out", extent=FEW)
    assert steps[:20] == list(range(20))
    assert steps[20:35] == list(range(15))
    assert steps[35:] == list(range(14, 40))
    assert found.reference == whole.reference


def test_impulses_and_statics_are_measured_too(tmp_path: Path) -> None:
    scene = write_scene(tmp_path, FAST.replace("[damping]", IMPULSES + "[damping]"))
    found = tradeoff(scene, extent=FEW)
    exact = row_of(found, kind=FILTER, size=MOTIONS)
    steps = row_of(found, force="linear", size=MOTIONS, integrator="implicit-newmark")
    assert exact.error == pytest.approx(steps.error, rel=0.3)
    text = FAST.replace('"implicit-newmark"', '"static"').replace("step = 2e-3", "step = 0.01")
    scene = write_scene(tmp_path, text)
    found = tradeoff(scene, extent=FEW)
    assert {row.candidate.kind for row in found.rows} == {FULL, "reduced"}
    model = row_of(found, force="cubic", size=MOTIONS)
    assert model.error < 1e-4
    assert model.batch_rate is None


def test_what_no_model_can_do_is_told_first(tmp_path: Path) -> None:
    moved = FAST.replace('region = "floor"', 'region = "floor"\ndisplacement = [0.1, 0, 0]', 1)
    with pytest.raises(SceneError, match="moved as told"):
        tradeoff(read_scene(write_scene(tmp_path, moved)))
    still = FAST[: FAST.index("[[load]]")] + FAST[FAST.index("[damping]") :]
    with pytest.raises(SceneError, match="nothing moves at the outputs"):
        tradeoff(write_scene(tmp_path, still), extent=FEW)


def test_a_candidate_that_fails_is_told_and_the_others_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> Any:
        raise DivergenceError("no step was found", time=0.0, step=1.0, reason="it blew up")

    monkeypatch.setattr(measuring, "step_seconds", fail)
    found = tradeoff(write_scene(tmp_path, FAST), tmp_path / "out", extent=FEW)
    assert found.choice is None
    assert found.misses == ()
    failed = [row for row in found.rows if row.status == FAILED]
    assert failed
    assert all(row.reason == "it blew up" for row in failed)
    write_report(found, tmp_path / "out")
