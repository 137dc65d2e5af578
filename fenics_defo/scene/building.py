"""From a scene's record to the body, the loads and the method, ready to be simulated."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Impulse,
    Initial,
    Integrator,
    Load,
    PointLoad,
    Prescribed,
    Pressure,
    QuasiStatic,
    Simulation,
    SymplecticEuler,
    Traction,
    linear_modes,
    mode_displacement,
)
from fenics_defo.errors import LoadError, MaterialError, SceneError, SelectionError, StepSizeError
from fenics_defo.fem import Fixed, Solid, read_mesh
from fenics_defo.scene.load_factors import load_factor
from fenics_defo.scene.newton import newton_limits
from fenics_defo.scene.records import FixedTable, LoadTable, Scene, TimeTable
from fenics_defo.scene.table import AXES

Array = NDArray[np.float64]


def build_solid(scene: Scene) -> Solid:
    """Read the mesh and make the body: materials, order, what is held. Collective.

    Args:
        scene: scene.

    Raises:
        MeshError: the mesh cannot be read, or cannot carry a computation.
        MaterialError: the materials do not cover the mesh, or there are none.
        SelectionError: a constraint matches nothing.
    """
    mesh = read_mesh(scene.mesh.file, size=scene.mesh.size, merge=scene.mesh.merge)
    materials = scene.materials or mesh.record.materials
    with told(scene, "[[material]]"):
        if not materials:
            raise MaterialError(
                "there is none, and the mesh file has none either; add one with young, poisson "
                "and density"
            )
    fixed = [Fixed(item.region, item.components) for item in scene.fixed if not _moves(item)]
    with told(scene, "[[material]] and [[fixed]]"):
        return Solid(
            mesh,
            {region: material for region, material in materials.items()},
            order=scene.mesh.order,
            fixed=fixed,
        )


def build_loads(scene: Scene, solid: Solid) -> tuple[Load, ...]:
    """The loads; in statics those without a history grow with time.

    Raises:
        SceneError: a node that the mesh does not have.
    """
    return tuple(build_load(scene, i, load, solid) for i, load in enumerate(scene.loads, 1))


def build_prescribed(scene: Scene) -> tuple[Prescribed, ...]:
    """The displacements prescribed in time; in statics those without a history grow with it."""
    moved = []
    for item in scene.fixed:
        if item.displacement is None:
            continue
        entries: list[float | None] = [None, None, None]
        for component, value in zip(item.components, item.displacement, strict=True):
            entries[AXES.index(component)] = value
        moved.append(Prescribed(item.region, entries, load_factor(item.history, scene.time)))
    return tuple(moved)


def build_integrator(time: TimeTable) -> Integrator:
    """The method that carries the motion on."""
    match time.integrator:
        case "implicit-newmark":
            return ImplicitNewmark(beta=time.beta, gamma=time.gamma)
        case "backward-euler":
            return BackwardEuler()
        case "central-differences":
            return CentralDifferences()
        case "symplectic-euler":
            return SymplecticEuler()
    return QuasiStatic()


def build_initial(scene: Scene, solid: Solid) -> Initial:
    """The state at time 0; collective.

    Raises:
        EigenSolveError: the mode that the scene starts from was not found.
    """
    given = scene.initial
    arms = mass_arms(solid)
    displacement = np.asarray(given.displacement) + arms * (np.asarray(given.stretch) - 1.0)
    velocity = np.asarray(given.velocity) + np.cross(np.asarray(given.spin), arms)
    if given.mode is not None:
        displacement = displacement + given.amplitude * mode_field(scene, solid, given.mode)
    return Initial(displacement=unheld(displacement, solid), velocity=unheld(velocity, solid))


def mode_field(scene: Scene, solid: Solid, number: int) -> Array:
    """Displacement (n, 3) [m] in an elastic mode, at most 1 m; collective.

    Args:
        scene: scene, for messages.
        solid: its body.
        number: of the mode, from 1.

    Raises:
        EigenSolveError: the mode was not found.
    """
    with told(scene, "[initial]"):
        modes = linear_modes(solid, number, keep_rigid=False, verify=False)
        return mode_displacement(modes, number, 1.0)


def mass_arms(solid: Solid) -> Array:
    """Places of the nodes from the centre of mass at rest (n, 3) [m]; collective."""
    masses = solid.lumped_mass()
    return solid.points - np.asarray(masses @ solid.points / masses.sum())


def unheld(field: Array, solid: Solid) -> Array:
    """A field over the nodes (n, 3), zero where the body is held."""
    return np.where(solid.held, 0.0, np.broadcast_to(field, solid.points.shape))


def build_simulation(scene: Scene, solid: Solid, *, start: bool = True) -> Simulation:
    """The body of `build_solid` with all that happens to it; collective. Close it when done.

    Args:
        scene: scene.
        solid: its body.
        start: whether to give it the scene's initial state; not needed where one is restored.

    Raises:
        LoadError: a load, a prescribed motion or a probe that the body cannot take.
        StepSizeError: the step is beyond what an explicit integrator stands.
        SelectionError: a region that the mesh does not have.
    """
    time, damping = scene.time, (scene.damping.mass, scene.damping.stiffness)
    tolerance, iterations = newton_limits(time)
    loads = build_loads(scene, solid)
    initial = build_initial(scene, solid) if start else None
    with told(scene, "[[load]], [[fixed]] and [[probe]]"):
        return Simulation(
            solid,
            loads,
            build_integrator(time),
            step=time.step,
            damping=(0.0, 0.0) if time.is_static else damping,
            newton=time.newton,
            newton_tolerance=tolerance,
            newton_iterations=iterations,
            linear=scene.solver.linear,  # type: ignore[arg-type]  # checked when it was read
            linear_tolerance=scene.solver.tolerance,
            initial=initial,
            prescribed=build_prescribed(scene),
            probes={probe.name: probe.point for probe in scene.probes},
            allow_unstable=time.allow_unstable,
        )


def build_load(scene: Scene, number: int, load: LoadTable, solid: Solid) -> Load:
    """One load.

    Args:
        scene: scene.
        number: of the load, from 1, for messages.
        load: its table.
        solid: body.

    Raises:
        SceneError: a node that the mesh does not have.
    """
    history = load_factor(load.history, scene.time)
    node = None if load.node is None else _row(scene, number, load.node, solid)
    match load.kind:
        case "gravity":
            return Gravity(load.vector, history)
        case "traction":
            assert load.region is not None  # read_load has seen to it
            return Traction(load.region, load.vector, history)
        case "pressure":
            assert load.region is not None
            return Pressure(load.region, load.value, history)
        case "point":
            return PointLoad(point=load.point, node=node, vector=load.vector, history=history)
    return Impulse(
        region=load.region, point=load.point, node=node, vector=load.vector, time=load.time
    )


def _row(scene: Scene, load: int, number: int, solid: Solid) -> int:
    """Row of the node that the mesh file gives that number."""
    numbers = solid.record.node_numbers
    found = np.flatnonzero(numbers == number)
    if not found.size:
        raise SceneError(
            f"{scene.path}: [[load]] {load}: the mesh has no node {number}; its nodes are numbered "
            f"{numbers.min()} to {numbers.max()}"
        )
    return int(found[0])


def _moves(item: FixedTable) -> bool:
    return item.displacement is not None


@contextmanager
def told(scene: Scene, where: str) -> Iterator[None]:
    """Name the scene file and the table in errors about what the tables ask for."""
    try:
        yield
    except StepSizeError as error:
        raise StepSizeError(f"{scene.path}: [time]: {error}") from error
    except (LoadError, MaterialError, SelectionError) as error:
        raise type(error)(f"{scene.path}: {where}: {error}") from error
