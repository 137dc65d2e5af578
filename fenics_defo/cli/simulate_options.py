"""What ``fenics-defo simulate`` understands."""

import argparse
import re
from typing import Any

from fenics_defo.cli.command import Parser

DESCRIPTION = """\
Full-order simulation of a scene: statics or dynamics of a deformable solid.

The scene is a TOML file; all quantities are in SI units. DIR gets summary.json,
probes.csv (time, then NAME_x, NAME_y, NAME_z: displacements [m]), energy.csv
(time, kinetic, strain, external, dissipated [J]), motion.pvd for ParaView, and
checkpoint.npz. A run that is stopped or killed leaves all that in order."""

DETAILS = """\
The tables of a scene
  [mesh]        file, order = 1|2, size and merge [m]
  [[material]]  region, law, young, poisson, density, ...; see mesh-to-modes
  [[fixed]]     region, components = ["x", "y", "z"]; to move nodes instead:
                displacement = [m for each component], history
  [[load]]      kind = "gravity" | "traction" | "pressure" | "point" | "impulse"
                region, or point = [x, y, z], or node = NUMBER; vector, or value
                of a pressure; time of an impulse
                history = { kind = "step", start } | { kind = "ramp", duration,
                start } | { kind = "sine", frequency, phase } | { kind = "pulse",
                start, duration } | { kind = "table", times, values }
  [damping]     mass [1/s], stiffness [s] (Rayleigh)
  [initial]     displacement, velocity, spin, stretch: vectors; mode, amplitude
  [time]        integrator = "implicit-newmark" | "backward-euler" | "static" |
                "central-differences" | "symplectic-euler"
                step, duration [s]; newton = 1, or tolerance to converge; beta,
                gamma (Newmark); allow_unstable (explicit)
  [solver]      linear = "cholesky" | "pcg-jacobi" | "pcg-amg", tolerance
  [[probe]]     name, point = [x, y, z]
  [output]      rows = steps a row; every = steps or interval = seconds a frame;
                vtk = false
  [require]     tolerance, rate, outputs; for cheaper models
Files and nodes:FILE count from the folder of the scene. In statics, loads without
a history grow with the time, from nothing to all of it at the duration.

Examples
  fenics-defo simulate cantilever.toml --output out
  fenics-defo simulate drop.toml --output out --restart
  mpiexec -n 4 fenics-defo simulate large.toml --output out

Exit status: 0 done, 1 something to mend (one sentence says what), 130 interrupted."""

_CADENCE = re.compile(r"(?P<number>\d+(\.\d+)?) ?(?P<unit>s|min|h)?")
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}


def add_simulate(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser: Parser = commands.add_parser(
        "simulate",
        help="move a scene, full order, into a folder of results",
        usage="fenics-defo simulate SCENE.toml --output DIR [options]",
        description=DESCRIPTION,
        epilog=DETAILS,
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "--output", required=True, metavar="DIR", help="folder of the results, made if missing"
    )
    again = parser.add_mutually_exclusive_group()
    again.add_argument(
        "--restart",
        action="store_true",
        help="go on from the checkpoint in DIR, to the same numbers as without the break; also "
        "makes a finished run longer",
    )
    again.add_argument(
        "--overwrite",
        action="store_true",
        help="begin anew though DIR holds an unfinished run of this scene",
    )
    parser.add_argument(
        "--checkpoint-every",
        type=checkpoint_cadence,
        default=(None, 60.0),
        metavar="N|TIME",
        help="save the state each N steps, or each TIME such as 30s, 5min (default: 60s)",
    )
    parser.add_argument(
        "--json", action="store_true", help="print summary.json instead of the summary"
    )


def checkpoint_cadence(text: str) -> tuple[int | None, float | None]:
    """Steps or seconds between checkpoints, for `argparse`."""
    match = _CADENCE.fullmatch(text.strip())
    if match is not None:
        unit, value = match["unit"], float(match["number"])
        if unit is not None and value > 0.0:
            return None, value * _SECONDS[unit]
        if unit is None and value >= 1.0 and value.is_integer():
            return int(value), None
    raise argparse.ArgumentTypeError(
        f"must be a number of steps such as 100, or a time such as 30s or 5min, got {text!r}"
    )
