"""The bench that candidates are measured on: a scene's reference, bases and models."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.runtime import ReducedModel, load
from fenics_defo.scene.building import build_solid
from fenics_defo.scene.records import Scene
from fenics_defo.scene.trade.comparing import Yardstick
from fenics_defo.scene.trade.full import Recorded, run_full, with_law
from fenics_defo.scene.trade.making import Maker, plain_key, with_outputs
from fenics_defo.scene.trade.measuring import failure, measure_full, measure_model
from fenics_defo.scene.trade.observer import Observer
from fenics_defo.scene.trade.pruning import far_from, is_near_rest
from fenics_defo.scene.trade.records import (
    FULL,
    PRUNED,
    Candidate,
    Measurement,
    ModelSpec,
    Reference,
)
from fenics_defo.scene.trade.sampling import sampling
from fenics_defo.scene.trade.store import Store

Array = NDArray[np.float64]


class Bench:
    """Measures candidates of a scene, each once.

    Args:
        scene: scene.
        solid: its body.
        store: of what was measured.
        candidates: all of them.
        outputs: numbers of the nodes that are looked at; None: all.
        observer: who looks on.
    """

    def __init__(
        self,
        scene: Scene,
        solid: Solid,
        store: Store,
        candidates: Sequence[Candidate],
        *,
        outputs: NDArray[np.int64] | None,
        observer: Observer,
    ) -> None:
        self._scene, self._solid, self._store = scene, solid, store
        self._candidates, self._outputs = candidates, outputs
        self._sampling = sampling(scene, len(solid.points), tuple({c.factor for c in candidates}))
        sizes: dict[str, int] = {}
        for spec in (c.model for c in candidates if c.model is not None):
            sizes[spec.basis] = max(spec.size, sizes.get(spec.basis, 0))
        self._maker = Maker(scene, solid, store, sizes, lambda: self._fine.displacements)
        self._progress = _Progress(observer, candidates)
        self._flies = not solid.held.any()

    def hold_reference(self, *, refine: bool) -> Reference:
        """Run the whole body at the scene's step and at half of it; the second is the reference.

        Args:
            refine: whether to look at the mesh's error too.

        Raises:
            DivergenceError: a step failed.
            SceneError: nothing moves.
        """
        steps = self._progress
        self._coarse = self._run(self._scene, self._solid, "full order", 1)
        self._fine = fine = self._run(self._scene, self._solid, "reference", 2)
        largest = np.linalg.norm(fine.displacements, axis=2).max(axis=1)
        self._yardstick = stick = Yardstick(
            fine,
            self._solid.lumped_mass(),
            self._outputs,
            self._sampling.stride * self._scene.time.step,
            tuple(probe.name for probe in self._scene.probes),
        )
        stick.check_moves(str(self._scene.path))
        apart = max(stick.error(i, u)[0] for i, u in enumerate(self._coarse.displacements))
        self._reference = Reference(
            step=0.5 * self._scene.time.step,
            times=self._sampling.times,
            # The error falls by 2^p from the coarse run to the fine one.
            error=apart / (2.0 ** _order(self._scene) - 1.0),
            mesh_error=self._mesh_error(stick) if refine else None,
            largest=float(largest.max()),
            energy_ratio=self._energy_ratio(fine.displacements[int(largest.argmax())]),
            frequency=stick.frequency(stick.track()),
            unknowns=self._solid.dof_count,
        )
        steps.done(0)
        return self._reference

    def measure(self, tolerance: float) -> list[Measurement]:
        """Measure all candidates, but those that cannot be good enough.

        Args:
            tolerance: error that is allowed [-].
        """
        rows: list[Measurement] = []
        for spec, group in groupby(self._candidates, key=lambda candidate: candidate.model):
            members = list(group)
            found = [self._kept(candidate) for candidate in members]
            missing = [c for c, row in zip(members, found, strict=True) if row is None]
            if missing and spec is None:
                missing_rows = [self._measured_full(candidate) for candidate in missing]
            elif missing:
                assert spec is not None
                missing_rows = self._measured_models(spec, missing, tolerance)
            rows += [row for row in found if row is not None] + (missing_rows if missing else [])
        return rows

    def model_of(self, candidate: Candidate) -> ReducedModel:
        """The model of a candidate with the rows at the outputs alone.

        Raises:
            DefoError: it cannot be made.
        """
        spec = candidate.model
        assert spec is not None
        path = self._store.path(plain_key(spec), ".npz")
        try:
            return load(path)
        except DefoError:  # it was deleted, or is damaged
            return with_outputs(self._maker.model(spec, swings=self._swings)[0], self._outputs)

    @property
    def _swings(self) -> bool:
        return is_near_rest(self._reference.energy_ratio)

    def _kept(self, candidate: Candidate) -> Measurement | None:
        row = self._store.measurement(candidate)
        if row is not None:
            self._progress.done(1, candidate)
        return row

    def _measured_full(self, candidate: Candidate) -> Measurement:
        try:
            if candidate.law:
                scene, solid = with_law(self._scene, self._solid, candidate.law)
                run = self._run(scene, solid, candidate.law, 1)
            else:
                run = self._coarse
            row = measure_full(candidate, run, self._yardstick)
        except DefoError as error:
            row = failure(candidate, error, {})
        self._store.keep(row)
        self._progress.done(1, candidate)
        return row

    def _measured_models(
        self, spec: ModelSpec, candidates: list[Candidate], tolerance: float
    ) -> list[Measurement]:
        rows = []
        self._progress.tell(f"make {spec.name}")
        model: ReducedModel | None = None
        try:
            costs: dict[str, Any] = {"best_error": self._best_error(spec)}
            why = self._why_not(spec, tolerance, costs["best_error"])
            if why:
                self._progress.done(len(candidates))
                return [
                    Measurement(candidate=candidate, status=PRUNED, reason=why, **costs)
                    for candidate in candidates
                ]
            model, seconds = self._maker.model(spec, swings=self._swings)
            costs |= {"offline_seconds": seconds, "model_bytes": self._saved(spec, model)}
        except DefoError as error:
            rows = [failure(candidate, error, {}) for candidate in candidates]
        for candidate in candidates if model is not None else ():
            assert model is not None
            self._progress.tell(f"{candidate.name}, step {candidate.step:.3g} s")
            row = measure_model(
                candidate,
                model,
                self._scene,
                yardstick=self._yardstick,
                sampling=self._sampling,
                costs=costs,
            )
            rows.append(row)
            self._progress.done(1, candidate)
        for row in rows:
            self._store.keep(row)
        return rows

    def _best_error(self, spec: ModelSpec) -> float | None:
        if self._flies:  # the body moves as a whole, which its shapes know nothing of
            return None
        basis, _ = self._maker.basis(spec)
        return float(self._yardstick.best_errors(np.asarray(basis.shapes))[-1])

    def _why_not(self, spec: ModelSpec, tolerance: float, best: float | None) -> str:
        return far_from(
            spec,
            tolerance=tolerance,
            best_error=best,
            energy_ratio=self._reference.energy_ratio,
            is_linear=self._solid.is_linear,
        )

    def _saved(self, spec: ModelSpec, model: ReducedModel) -> int:
        path = self._store.path(plain_key(spec), ".npz")
        with_outputs(model, self._outputs).save(path)
        return path.stat().st_size

    def _run(self, scene: Scene, solid: Solid, label: str, halves: int) -> Recorded:
        moved: Callable[[float], None] = self._progress.within(halves, f"{label}: all of the body")
        key = label if halves == 1 and label != "full order" else ""
        run = run_full(
            scene, solid, self._sampling, self._store, halves=halves, label=key, moved=moved
        )
        return run

    def _mesh_error(self, stick: Yardstick) -> float | None:
        """Difference to a run of second order at the scene's step, at the nodes they share."""
        if self._scene.mesh.order != 1:
            return None
        scene = replace(self._scene, mesh=replace(self._scene.mesh, order=2))
        run = self._run(scene, build_solid(scene), "second order", 1)
        shared = run.displacements[:, : len(self._solid.points)]
        difference = shared - self._coarse.displacements
        pairs = [
            stick.error(i, u + d)
            for i, (u, d) in enumerate(zip(stick.reference.displacements, difference, strict=True))
        ]
        return float(max(error for error, _ in pairs))

    def _energy_ratio(self, displacement: Array) -> float | None:
        """½ uᵀ K(0) u over the strain energy."""
        if self._flies:
            return None
        solid, tiny = self._solid, 1e-5
        energy = solid.energy(displacement)
        # K u by a difference: no matrix is put together for one product.
        push = (solid.internal_force(tiny * displacement) - solid.internal_force()) / tiny
        return float(0.5 * np.vdot(displacement, push) / energy) if energy > 0.0 else None


class _Progress:
    """Where a bench is. Runs of the whole body count by their steps, other candidates a little."""

    def __init__(self, observer: Observer, candidates: Sequence[Candidate]) -> None:
        self._moved = observer.moved
        fulls = sum(c.kind == FULL for c in candidates)
        self._total, self._at = 3.0 + (fulls - 1) + 1.0, 0.0
        self._share = 1.0 / max(1, len(candidates) - fulls)

    def within(self, weight: float, text: str) -> Callable[[float], None]:
        """What a run of the whole body calls with the part that it has done."""
        begin = self._at

        def moved(part: float) -> None:
            self._at = begin + weight * part
            self._moved(min(1.0, self._at / self._total), text)

        return moved

    def tell(self, text: str) -> None:
        """Say what is under way."""
        self._moved(min(1.0, self._at / self._total), text)

    def done(self, count: int, candidate: Candidate | None = None) -> None:
        """Count candidates as done; those of full order have counted their steps."""
        if candidate is None or candidate.kind != FULL:
            self._at += count * self._share


def _order(scene: Scene) -> int:
    """Order of the scene's method in the step; of equilibria any: they do not depend on it."""
    time = scene.time
    if time.integrator == "implicit-newmark":
        return 2 if time.gamma == 0.5 else 1
    return 2 if time.integrator == "central-differences" else 1
