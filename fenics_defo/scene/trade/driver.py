"""A scene's candidates measured, the choice made, its model written."""

import logging
import os
import platform
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fenics_defo import __version__
from fenics_defo.errors import DefoError, SceneError
from fenics_defo.fem import Solid
from fenics_defo.fem.regions import select_nodes
from fenics_defo.runtime import ReducedModel, check_writable, load
from fenics_defo.scene.building import build_solid, told
from fenics_defo.scene.reading import read_scene
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reducing import check_held_or_free, check_held_still
from fenics_defo.scene.together import with_our_errors
from fenics_defo.scene.trade.bench import Bench
from fenics_defo.scene.trade.choosing import Limits, choose, in_order, pareto_front
from fenics_defo.scene.trade.files import write_tables
from fenics_defo.scene.trade.ladder import SMALL, Extent, ladder
from fenics_defo.scene.trade.observer import Observer
from fenics_defo.scene.trade.records import Measurement, Tradeoff
from fenics_defo.scene.trade.store import Store

_log = logging.getLogger(__name__)

DEFAULT_TOLERANCE = 0.05
MODEL = "model.npz"


def tradeoff(
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    extent: Extent | None = None,
    refine: bool = False,
    observer: Observer | None = None,
) -> Tradeoff:
    """Measure which model a scene requires, and write that model.

    The scene is run with all of its body, at its step and at half of it: the second run is the
    reference, their difference tells its error. Then a ladder of models is made, moved through the
    scene and timed. The cheapest within ``[require]`` tolerance (5 % if it has none) and rate is
    chosen. For one process: times are measured, and others would disturb them.

    Args:
        scene: scene, or the name of its file.
        output: folder that gets ``tradeoff.json``, ``tradeoff.csv``, the chosen ``model.npz`` and,
            in ``work``, what has been measured, which is not measured again; None: nothing is kept.
        extent: how far the ladder reaches.
        refine: estimate the mesh's error too, by a run of second order.
        observer: who looks on.

    Returns:
        the table and the choice; ``choice`` is None if no model fits.

    Raises:
        SceneError: the scene file is at fault, or no model can stand for it.
        DefoError: the reference cannot be run, or the folder cannot be written.
    """
    observer = observer or Observer()
    with ExitStack() as stack, _once_each("fenics_defo.scene.reduced_flight"):
        if output is None:
            output = stack.enter_context(tempfile.TemporaryDirectory())
        folder = Path(output)
        with observer.phases("read"):
            if not isinstance(scene, Scene):
                scene = read_scene(scene)
            check_held_still(scene)
        with observer.phases("build"):
            solid = build_solid(scene)
            check_held_or_free(scene, solid)
            store = _store(folder, scene, solid)
            candidates = ladder(scene, solid, extent or Extent())
            outputs = _outputs(scene, solid)
        bench = Bench(scene, solid, store, candidates, outputs=outputs, observer=observer)
        limits = _limits(scene)
        with observer.phases("reference"):
            reference = bench.hold_reference(refine=refine)
        _warn_of_reference(reference.error, limits.tolerance)
        with observer.phases("candidates"):
            rows = in_order(bench.measure(limits.tolerance))
        with observer.phases("write"):
            limits = replace(limits, floor=reference.error)
            found = _chosen(scene, solid, rows, limits, reference)
            if found.choice is not None:
                model = bench.model_of(rows[found.choice].candidate)
                certified(model, found).save(folder / MODEL)
            else:
                (folder / MODEL).unlink(missing_ok=True)
            write_tables(found, folder)
    return found


@contextmanager
def _once_each(name: str) -> Iterator[None]:
    """Let a module say the same thing once only: it does for each candidate."""
    told: set[str] = set()

    def is_new(entry: logging.LogRecord) -> bool:
        is_known = entry.getMessage() in told
        told.add(entry.getMessage())
        return not is_known

    logger = logging.getLogger(name)
    logger.addFilter(is_new)
    try:
        yield
    finally:
        logger.removeFilter(is_new)


def choose_model(
    scene: Scene, output: str | os.PathLike[str], *, observer: Observer | None = None
) -> Tradeoff:
    """Write the model that a scene requires, found on a short ladder.

    Args:
        scene: scene.
        output: file of the model, replaced if one was chosen.
        observer: who looks on.

    Returns:
        the table and the choice; nothing was written if ``choice`` is None.

    Raises:
        DefoError: as `tradeoff`, or the file cannot be written.
    """
    with_our_errors(lambda: check_writable(output))
    with tempfile.TemporaryDirectory() as folder:
        found = tradeoff(scene, folder, extent=SMALL, observer=observer)
        if found.choice is not None:
            load(Path(folder) / MODEL).save(output)
    return found


def is_required(scene: Scene) -> bool:
    """Whether a scene says what a model of it must be good for."""
    return scene.require.tolerance is not None or scene.require.rate is not None


def certified(model: ReducedModel, found: Tradeoff) -> ReducedModel:
    """The chosen model with what was measured of it in its certificate.

    Args:
        model: model.
        found: the table.
    """
    row = found.chosen
    assert row is not None
    measured = {
        "error": row.error,
        "error_rms": row.error_rms,
        "error_whole": row.error_whole,
        "probe_errors": dict(row.probe_errors),
        "tolerance": found.tolerance,
        "rate_hz": found.rate,
        "reference_error": found.reference.error,
        "method": row.candidate.kind,
        "integrator": row.candidate.integrator,
        "step_s": row.candidate.step,
        "step_us": row.microseconds,
        "step_us_p99": row.microseconds_p99,
        "machine": dict(found.machine),
        "reason": found.reason,
    }
    return replace(model, certificate={**model.certificate, "scene": measured})


def _store(folder: Path, scene: Scene, solid: Solid) -> Store:
    if solid.comm.size > 1:
        raise SceneError(
            f"{scene.path}: a trade-off measures times, which other processes disturb; run it on "
            "one process"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return Store(folder / "work", scene)
    except OSError as error:
        raise DefoError(
            f"{folder}: cannot be made a folder ({error.strerror or error}); choose another"
        ) from error


def _outputs(scene: Scene, solid: Solid) -> Any:
    wanted = scene.require.outputs
    if wanted is None:
        return None
    with told(scene, "[require]"):
        return np.flatnonzero(select_nodes(solid.mesh_data, solid.space, solid.nodes, wanted))


def _limits(scene: Scene) -> Limits:
    tolerance = scene.require.tolerance
    return Limits(
        tolerance=DEFAULT_TOLERANCE if tolerance is None else tolerance,
        rate=scene.require.rate,
        step=scene.time.step,
    )


def _warn_of_reference(error: float, tolerance: float) -> None:
    if not error <= 0.5 * tolerance:
        _log.warning(
            "the error of the reference itself is about %.2g, not small beside the tolerance %.2g; "
            "a smaller step in [time] makes it smaller",
            error,
            tolerance,
        )


def _chosen(
    scene: Scene,
    solid: Solid,
    rows: tuple[Measurement, ...],
    limits: Limits,
    reference: Any,
) -> Tradeoff:
    choice, misses, reason = choose(rows, limits)
    trained = choice is not None and rows[choice].candidate.is_trained
    return Tradeoff(
        scene=str(scene.path),
        title=f"{len(solid.points):,} nodes, {solid.dof_count:,} unknowns, "
        f"{scene.time.steps:,} steps of {scene.time.step:g} s, "
        f"{scene.time.integrator.replace('static', 'statics')}",
        step=scene.time.step,
        duration=scene.time.duration,
        flies=not solid.held.any(),
        tolerance=limits.tolerance,
        is_default=scene.require.tolerance is None,
        rate=limits.rate,
        reference=reference,
        rows=rows,
        front=pareto_front(rows, limits.floor, trained=trained),
        choice=choice,
        reason=reason,
        misses=misses,
        machine={
            "processor": _processor(),
            "cores": os.cpu_count(),
            "python": platform.python_version(),
            "numpy": np.__version__,
        },
        model=MODEL if choice is not None else "",
        version=__version__,
    )


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text("utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
