"""A scene's body reduced to a model in one file."""

import logging
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Phases, linear_modes
from fenics_defo.analysis.free_motions import free_motions
from fenics_defo.errors import SceneError
from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.reduction import (
    Basis,
    CubatureTraining,
    linear_basis,
    modal_derivative_basis,
    reduce,
    snapshot_basis,
    train_cubature,
)
from fenics_defo.reduction.load_projection import MassKind, mass_of
from fenics_defo.runtime import ReducedModel, check_writable
from fenics_defo.scene.building import build_solid, told
from fenics_defo.scene.carried import body_identity
from fenics_defo.scene.reading import read_scene
from fenics_defo.scene.recipe import Recipe
from fenics_defo.scene.records import Scene
from fenics_defo.scene.schema import EXPLICIT
from fenics_defo.scene.together import with_our_errors
from fenics_defo.scene.unit_loads import initial_fields, unit_loads
from fenics_defo.scene.watching import Watcher

Array = NDArray[np.float64]

_log = logging.getLogger(__name__)


def reduce_scene(
    scene: Scene | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    recipe: Recipe | None = None,
    watcher: Watcher | None = None,
) -> ReducedModel:
    """Reduce a scene's body and write the model, with all that `play` needs of the scene.

    That is: its loads' projections, a unit of each along each axis; momenta of unit fields, from
    which its initial state is put together; its probes and damping; and what the body is known by.
    The mass is lumped where the scene's integrator is explicit, as in `simulate`. Collective; rank
    0 alone writes.

    Args:
        scene: scene, or the name of its file.
        output: file of the model, replaced if it is there.
        recipe: how the model is made; settled by the law of the body if not given.
        watcher: who looks on.

    Returns:
        the model.

    Raises:
        SceneError: the scene file is at fault, or asks for what a model cannot do.
        MeshError, MaterialError, SelectionError, LoadError: what it asks for does not fit its mesh.
        EigenSolveError, SolverError: the modes, or their derivatives, were not found.
        DefoError: the recipe does not fit the body, or the file cannot be written.
    """
    phases = (watcher or Watcher()).phases
    with phases("read"):
        if not isinstance(scene, Scene):
            scene = read_scene(scene)
        _check_held_still(scene)
    with phases("build"):
        solid = build_solid(scene)
        on_first_rank(solid.comm, lambda: with_our_errors(lambda: check_writable(output)))
        _check_held_or_free(scene, solid)
        settled = (recipe or Recipe()).settled(scene, solid)
    with phases("basis"):
        basis = _basis(solid, settled)
    training = _training(solid, basis, settled, phases) if settled.force == "cubature" else None
    with phases("force"):
        # A body in flight moves by an implicit method in any case.
        is_lumped = scene.time.integrator in EXPLICIT and solid.held.any()
        mass: MassKind = "lumped" if is_lumped else "consistent"
        with told(scene, "[[load]], [require] and [[probe]]"):
            model = reduce(
                solid,
                basis,
                settled.force,  # type: ignore[arg-type]  # the recipe has checked it
                outputs=scene.require.outputs,
                loads=unit_loads(scene, solid),
                probes={probe.name: probe.point for probe in scene.probes},
                damping=(scene.damping.mass, scene.damping.stiffness),
                mass=mass,
                training=training,
            )
    with phases("start"):
        model = replace(
            model,
            loads={**model.loads, **_momenta(scene, solid, basis, mass)},
            provenance={**model.provenance, "scene": _origin(scene, solid)},
        )
    with phases("write"):
        on_first_rank(solid.comm, lambda: with_our_errors(lambda: model.save(output)))
    return model


def _check_held_still(scene: Scene) -> None:
    for number, item in enumerate(scene.fixed, 1):
        if item.displacement is not None:
            raise SceneError(
                f"{scene.path}: [[fixed]] {number}: nodes that are moved as told cannot be part of "
                "a model; hold them still (leave displacement out), or simulate the scene"
            )


def _check_held_or_free(scene: Scene, solid: Solid) -> None:
    motions = len(free_motions(solid))
    if motions and solid.held.any():
        raise SceneError(
            f"{scene.path}: [[fixed]]: {motions} rigid motions of the body or of its parts are not "
            "held, though others are: a model knows bodies that are held or that fly; hold more, "
            "or leave [[fixed]] out"
        )


def _basis(solid: Solid, recipe: Recipe) -> Basis:
    if recipe.basis == "snapshots":
        assert recipe.snapshots is not None  # the recipe has seen to it
        return snapshot_basis(solid, Path(recipe.snapshots), recipe.size, share=recipe.share)
    assert recipe.modes is not None
    # There may be more than asked for: a cluster of equal frequencies is never cut.
    modes = linear_modes(solid, recipe.modes, keep_rigid=False, verify=False)
    if recipe.basis == "linear":
        return linear_basis(solid, modes, recipe.size)
    return modal_derivative_basis(solid, modes, recipe.size, share=recipe.share)


def _training(solid: Solid, basis: Basis, recipe: Recipe, phases: Phases) -> CubatureTraining:
    with phases("train"):
        found = train_cubature(solid, basis.shapes, tolerance=recipe.tolerance)
    if found.advice is not None and solid.comm.rank == 0:
        _log.warning("cubature: %s", found.advice)
    return found


def _momenta(scene: Scene, solid: Solid, basis: Basis, kind: MassKind) -> Mapping[str, Array]:
    """Momenta of the fields that the initial state is put together from, projected."""
    projection, mass = Projection(solid, basis.shapes), mass_of(solid, kind)
    found = {}
    for name, field in initial_fields(scene, solid):
        own = np.ascontiguousarray(solid.nodes.scatter(field)[: solid.nodes.owned])
        found[name] = projection.project(mass.apply(own))
    return found


def _origin(scene: Scene, solid: Solid) -> dict[str, Any]:
    """What the body is known by, and what `play` tells of it."""
    identity = on_first_rank(solid.comm, lambda: body_identity(scene))
    return {
        **identity,
        "file": scene.path.name,
        "mesh file": scene.mesh.file.name,
        "order": solid.order,
        "nodes": len(solid.points),
        "dofs": solid.dof_count,
        "notes": list(solid.record.notes),
    }
