"""Bases and models of candidates, each made once."""

import time
from collections.abc import Callable
from dataclasses import asdict, replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem import Solid
from fenics_defo.reduction import Basis, snapshot_basis, train_cubature
from fenics_defo.runtime import Outputs, ReducedModel
from fenics_defo.scene.recipe import Recipe
from fenics_defo.scene.records import Scene
from fenics_defo.scene.reducing import recipe_basis, scene_model
from fenics_defo.scene.trade.records import ModelSpec
from fenics_defo.scene.trade.store import Store

Array = NDArray[np.float64]

_DERIVED_MODES = 10  # whose derivatives make the larger bases


class Maker:
    """Makes bases, the largest of each kind, and models within their first columns.

    Args:
        scene: scene.
        solid: its body.
        store: keeps bases.
        sizes: largest number of coordinates by kind of basis.
        training: gives the states (m, n, 3) of the reference.
    """

    def __init__(
        self,
        scene: Scene,
        solid: Solid,
        store: Store,
        sizes: dict[str, int],
        training: Callable[[], Array],
    ) -> None:
        # The models that are measured store all nodes.
        self._whole = replace(scene, require=replace(scene.require, outputs=None))
        self._solid, self._store, self._training = solid, store, training
        self._sizes = sizes
        self._bases: dict[str, tuple[Basis, float]] = {}

    def basis(self, spec: ModelSpec) -> tuple[Basis, float]:
        """The basis of a model, and the seconds that it took; it may have fewer columns."""
        if spec.basis not in self._bases:
            self._bases[spec.basis] = self._found_basis(spec.basis)
        largest, seconds = self._bases[spec.basis]
        return _first(largest, spec.size), seconds

    def model(self, spec: ModelSpec, *, swings: bool) -> tuple[ReducedModel, float]:
        """The model with all nodes, and the seconds that it and its basis took.

        Args:
            spec: model.
            swings: whether the motion stays near rest, where a cubature had better keep the exact
                stiffness and so the frequencies; far from rest that correction is wrong.

        Raises:
            DefoError: the force does not suit the body.
        """
        basis, seconds = self.basis(spec)
        begin = time.perf_counter()
        training = None
        if spec.force == "cubature":
            assert spec.tolerance is not None
            training = train_cubature(
                self._solid, basis.shapes, tolerance=spec.tolerance, keep_rest_stiffness=swings
            )
        model = scene_model(self._whole, self._solid, basis, spec.force, training=training)
        return model, seconds + time.perf_counter() - begin

    def _found_basis(self, kind: str) -> tuple[Basis, float]:
        size = self._sizes[kind]
        key = {"basis": kind, "size": size}
        kept = self._store.arrays(key)
        if kept is not None:
            origin = {"modes": int(kept["modes"][0])} if kind != "snapshots" else {}
            basis = Basis(shapes=kept["shapes"], mass=kept["mass"], kind=kind, origin=origin)
            return basis, float(kept["seconds"][0])
        begin = time.perf_counter()
        basis = self._made_basis(kind, size)
        seconds = time.perf_counter() - begin
        arrays = {"shapes": np.asarray(basis.shapes), "mass": np.asarray(basis.mass)}
        modes = np.array([float(basis.origin.get("modes", 0))])  # type: ignore[arg-type]
        self._store.keep_arrays(key, {**arrays, "modes": modes, "seconds": np.array([seconds])})
        return basis, seconds

    def _made_basis(self, kind: str, size: int) -> Basis:
        if kind == "snapshots":
            return snapshot_basis(self._solid, self._training(), size, share=1.0)
        modes = size if kind == "linear" else _DERIVED_MODES
        recipe = Recipe(basis=kind, modes=modes, size=size, share=None if kind == "linear" else 1.0)
        return recipe_basis(self._solid, recipe)


def _first(basis: Basis, size: int) -> Basis:
    """The first columns of a basis, itself the basis of that size: principal ones come first."""
    if size >= basis.size:
        return basis
    return replace(
        basis,
        shapes=basis.shapes[:size],
        mass=basis.mass[:size, :size],
        singular_values=None,
        kept=None,
        origin={**basis.origin, "first_of": basis.size},
    )


def with_outputs(model: ReducedModel, nodes: NDArray[np.int64] | None) -> ReducedModel:
    """The model with the rows of U at some nodes alone.

    Args:
        model: model with all nodes.
        nodes: their numbers, ascending; None: all.
    """
    if nodes is None or len(nodes) == len(model.nodes):
        return model
    full = model.outputs
    outputs = Outputs(nodes=nodes, points=full.points[nodes], shapes=full.shapes[nodes])
    return replace(model, outputs=outputs)


def plain_key(spec: ModelSpec) -> dict[str, object]:
    """What a model is kept under."""
    return {"model": asdict(spec)}
