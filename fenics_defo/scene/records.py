"""What a scene file says, table by table, as frozen records. SI units throughout."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fenics_defo.scene.table import Vector

if TYPE_CHECKING:  # it needs UFL, which a scene that is played does without
    from fenics_defo.energy import Law

Selection = str | int


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshTable:
    """``[mesh]``: the body's mesh.

    Args:
        file: mesh, surface or CAD file; a relative name counts from the scene file's folder.
        order: polynomial order of the displacements, 1 or 2.
        size: edge length of the tetrahedra that fill a surface or CAD solid [m].
        merge: nodes closer than this become one [m].
    """

    file: Path
    order: int = 1
    size: float | None = None
    merge: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class HistoryTable:
    """``history``: the factor of a load or a prescribed displacement in time.

    Args:
        kind: "step", "ramp", "sine", "pulse" or "table".
        start: when it begins [s].
        duration: of a ramp or pulse [s].
        frequency: of a sine [Hz].
        phase: of a sine [rad].
        times: of a table, ascending [s].
        values: factors of a table at its times [-].
    """

    kind: str
    start: float = 0.0
    duration: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    times: tuple[float, ...] = ()
    values: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedTable:
    """``[[fixed]]``: nodes held, or moved as told.

    Args:
        region: selection of nodes.
        components: those held, some of "xyz".
        displacement: what the nodes' displacement grows to, one number for each of the components
            [m]; None holds them where they rest.
        history: factor of ``displacement`` in time.
    """

    region: Selection
    components: str = "xyz"
    displacement: tuple[float, ...] | None = None
    history: HistoryTable | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadTable:
    """``[[load]]``: one load.

    Args:
        kind: "gravity", "traction", "pressure", "point" or "impulse".
        region: selection of facets (traction, pressure) or of nodes (impulse).
        point: place at rest that the load acts on [m]; point and impulse.
        node: number of a node of the mesh file that the load acts on; point and impulse.
        vector: acceleration [m/s²], traction [Pa], force [N] or impulse [N s].
        value: pressure, positive inwards [Pa].
        time: when an impulse strikes [s].
        history: factor in time; None for a load that is always there.
    """

    kind: str
    region: Selection | None = None
    point: Vector | None = None
    node: int | None = None
    vector: Vector = (0.0, 0.0, 0.0)
    value: float = 0.0
    time: float = 0.0
    history: HistoryTable | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DampingTable:
    """``[damping]``: Rayleigh damping C = mass M + stiffness K(u).

    Args:
        mass: α [1/s].
        stiffness: β [s].
    """

    mass: float = 0.0
    stiffness: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeTable:
    """``[time]``: how time goes on.

    Args:
        integrator: one of `INTEGRATORS`.
        step: time step, of statics the load step [s].
        duration: length of the simulation; in statics the loads grow over it [s].
        newton: Newton iterations a step; None to converge.
        tolerance: of a converged Newton iteration, relative; None for its default.
        beta: of Newmark's method.
        gamma: of Newmark's method.
        allow_unstable: whether an explicit method may go beyond its largest stable step.
    """

    integrator: str
    step: float
    duration: float
    newton: int | None = 1
    tolerance: float | None = None
    beta: float = 0.25
    gamma: float = 0.5
    allow_unstable: bool = False

    @property
    def is_static(self) -> bool:
        """Whether the inertia is left out."""
        return self.integrator == "static"

    @property
    def steps(self) -> int:
        """Number of steps; the last one ends at the duration or, by less than a step, later."""
        count = self.duration / self.step
        whole = round(count)
        near = abs(count - whole) <= 1e-9 * max(1.0, count)
        return max(1, whole if near else int(count) + 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class SolverTable:
    """``[solver]``: how linear systems are solved.

    Args:
        linear: one of `LINEAR_SOLVERS`.
        tolerance: relative residual of the iterative ones.
    """

    linear: str = "cholesky"
    tolerance: float = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class ProbeTable:
    """``[[probe]]``: a point whose displacement is written down.

    Args:
        name: heads its columns.
        point: place at rest, in the body or on its surface [m].
    """

    name: str
    point: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialTable:
    """``[initial]``: the state at time 0; what is given is added up.

    Args:
        displacement: of all nodes [m].
        velocity: of all nodes [m/s].
        spin: angular velocity about the centre of mass [rad/s].
        stretch: factors of the coordinates, from the centre of mass; 0 flattens, -1 turns the
            body inside out [-].
        mode: number of an elastic vibration mode of the rest shape, from 1.
        amplitude: largest displacement of a node in that mode [m].
    """

    displacement: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)
    stretch: Vector = (1.0, 1.0, 1.0)
    mode: int | None = None
    amplitude: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputTable:
    """``[output]``: how much is written; the first and the last state always are.

    Args:
        rows: steps from one row of the tables to the next.
        every: steps from one frame of the series to the next; None for about 100 frames.
        interval: time from one frame to the next [s], instead of ``every``.
        vtk: whether the series for ParaView is written.
    """

    rows: int = 1
    every: int | None = None
    interval: float | None = None
    vtk: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class RequireTable:
    """``[require]``: what a cheaper model of the scene must give.

    Args:
        tolerance: relative error of displacements [-].
        rate: steps of the runtime a second [Hz].
        outputs: selection of the nodes that are looked at; None for all.
    """

    tolerance: float | None = None
    rate: float | None = None
    outputs: Selection | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A scene file, read and checked as far as that goes without its mesh.

    Args:
        path: the scene file.
        mesh: its mesh.
        time: how time goes on.
        materials: region (None: everywhere else) -> material; empty: those of the mesh file, or
            not looked at (`parse_scene`).
        fixed: constraints.
        loads: loads.
        damping: Rayleigh's.
        solver: of linear systems.
        probes: points to be followed.
        initial: state at time 0.
        output: how much is written.
        require: of a cheaper model.
        tables: the file's tables as they are, to compare scenes by.
    """

    path: Path
    mesh: MeshTable
    time: TimeTable
    materials: "Mapping[str | None, Law]" = field(default_factory=dict)
    fixed: tuple[FixedTable, ...] = ()
    loads: tuple[LoadTable, ...] = ()
    damping: DampingTable = DampingTable()
    solver: SolverTable = SolverTable()
    probes: tuple[ProbeTable, ...] = ()
    initial: InitialTable = InitialTable()
    output: OutputTable = OutputTable()
    require: RequireTable = RequireTable()
    tables: Mapping[str, Any] = field(default_factory=dict)
