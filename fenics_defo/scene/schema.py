"""How the tables about the mesh, time and output become their records: keys, types, ranges."""

from pathlib import Path

from fenics_defo.scene.records import (
    DampingTable,
    InitialTable,
    MeshTable,
    OutputTable,
    ProbeTable,
    RequireTable,
    SolverTable,
    TimeTable,
)
from fenics_defo.scene.table import Table

INTEGRATORS = (
    "implicit-newmark",
    "backward-euler",
    "central-differences",
    "symplectic-euler",
    "static",
)
LINEAR_SOLVERS = ("cholesky", "pcg-jacobi", "pcg-amg")
EXPLICIT = ("central-differences", "symplectic-euler")
_STATIC_STEPS = 10


def read_mesh_table(table: Table) -> MeshTable:
    """``[mesh]``."""
    table.only(("file", "order", "size", "merge"))
    file = Path(table.text("file", example="beam.msh"))
    order = table.values.get("order", 1)
    if isinstance(order, bool) or order not in (1, 2):
        raise table.error(f"order must be 1 or 2, got {order!r}")
    return MeshTable(
        file=table.path.parent / file,
        order=int(order),
        size=_optional(table, "size", unit="m", example="0.01"),
        merge=_optional(table, "merge", unit="m", example="1e-6"),
    )


def read_damping(table: Table) -> DampingTable:
    """``[damping]``."""
    table.only(("mass", "stiffness"))
    return DampingTable(
        mass=table.number("mass", default=0.0, least=0.0, unit="1/s", example="0.1"),
        stiffness=table.number("stiffness", default=0.0, least=0.0, unit="s", example="0.001"),
    )


def read_time(table: Table) -> TimeTable:
    """``[time]``."""
    integrator = table.choice("integrator", INTEGRATORS)
    keys: tuple[str, ...] = ("integrator", "step", "duration")
    if integrator == "static":
        keys = (*keys, "tolerance")
    elif integrator in EXPLICIT:
        keys = (*keys, "allow_unstable")
    else:
        keys = (*keys, "newton", "tolerance")
    newmark = ("beta", "gamma") if integrator == "implicit-newmark" else ()
    table.only((*keys, *newmark), of=f'the integrator "{integrator}"')
    static = integrator == "static"
    duration = table.number(
        "duration", default=1.0 if static else None, above=0.0, unit="s", example="1.0"
    )
    step = table.number(
        "step",
        default=duration / _STATIC_STEPS if static else None,
        above=0.0,
        most=duration,
        unit="s",
        example="0.001",
    )
    if "newton" in table and "tolerance" in table:
        raise table.error(
            "has newton beside tolerance; give newton = 1 for so many iterations a step, "
            "or tolerance = 1e-8 for iterations until it is met"
        )
    beta, gamma = _newmark(table)
    converge = static or "tolerance" in table
    return TimeTable(
        integrator=integrator,
        step=step,
        duration=duration,
        newton=None if converge else table.count("newton", default=1, example="1"),
        tolerance=_optional(table, "tolerance", most=0.1, example="1e-8"),
        beta=beta,
        gamma=gamma,
        allow_unstable=table.flag("allow_unstable", default=False),
    )


def read_solver(table: Table) -> SolverTable:
    """``[solver]``."""
    table.only(("linear", "tolerance"))
    return SolverTable(
        linear=table.choice("linear", LINEAR_SOLVERS, default="cholesky"),
        tolerance=table.number("tolerance", default=1e-6, above=0.0, most=0.1, example="1e-6"),
    )


def read_probe(table: Table) -> ProbeTable:
    """``[[probe]]``."""
    table.only(("name", "point"))
    name = table.text("name", example="tip")
    if not name.isprintable() or any(c in name for c in ",;\"'") or name != name.strip():
        raise table.error(
            f"name heads columns of a table: it must be printable, without commas and quotes, "
            f'got {name!r}; write for instance name = "tip"'
        )
    return ProbeTable(name=name, point=table.vector("point", unit="m", example="[1.0, 0.0, 0.0]"))


def read_initial(table: Table) -> InitialTable:
    """``[initial]``."""
    table.only(("displacement", "velocity", "spin", "stretch", "mode", "amplitude"))
    if ("mode" in table) != ("amplitude" in table):
        raise table.error(
            "mode and amplitude belong together: the number of an elastic mode from 1, and the "
            "largest displacement in it [m]; write for instance mode = 1, amplitude = 0.01"
        )
    zero, one, example = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), "[0.0, 0.0, 1.0]"
    return InitialTable(
        displacement=table.vector("displacement", unit="m", example=example, default=zero),
        velocity=table.vector("velocity", unit="m/s", example=example, default=zero),
        spin=table.vector("spin", unit="rad/s", example=example, default=zero),
        stretch=table.vector("stretch", unit="-", example="[1.0, 1.0, 0.0]", default=one),
        mode=table.count("mode", example="1") if "mode" in table else None,
        amplitude=table.number("amplitude", default=0.0, unit="m", example="0.01"),
    )


def read_output(table: Table) -> OutputTable:
    """``[output]``."""
    table.only(("rows", "every", "interval", "vtk"))
    if "every" in table and "interval" in table:
        raise table.error(
            "has every beside interval; give every = 10 for a frame each 10 steps, "
            "or interval = 0.01 for one each 0.01 s"
        )
    return OutputTable(
        rows=table.count("rows", default=1, example="10"),
        every=table.count("every", example="10") if "every" in table else None,
        interval=_optional(table, "interval", unit="s", example="0.01"),
        vtk=table.flag("vtk", default=True),
    )


def read_require(table: Table) -> RequireTable:
    """``[require]``."""
    table.only(("tolerance", "rate", "outputs"))
    return RequireTable(
        tolerance=_optional(table, "tolerance", example="0.01"),
        rate=_optional(table, "rate", unit="Hz", example="1000.0"),
        outputs=table.selection("outputs") if "outputs" in table else None,
    )


def _optional(
    table: Table, key: str, *, most: float = float("inf"), unit: str = "", example: str
) -> float | None:
    """A positive number, or None where the key is missing."""
    if key not in table:
        return None
    return table.number(key, above=0.0, most=most, unit=unit, example=example)


def _newmark(table: Table) -> tuple[float, float]:
    """Newmark's β and γ, for which any step is stable on linear bodies."""
    beta = table.number("beta", default=0.25, above=0.0, example="0.25")
    gamma = table.number("gamma", default=0.5, least=0.5, example="0.5")
    if not 2.0 * beta >= gamma:
        raise table.error(
            f"beta = {beta!r} must be at least half of gamma = {gamma!r}, else no step is stable; "
            "the usual values are beta = 0.25 and gamma = 0.5"
        )
    return beta, gamma
