"""What ``fenics-defo reduce`` and ``fenics-defo play`` understand."""

import argparse
from typing import Any

from fenics_defo.cli.command import Parser, number, positive_count

REDUCE = """\
Make a small model of a scene's body, in one file that runs with NumPy alone.

The model moves in the span of r fields (the basis) and has the forces of the
scene's law in it. It carries the scene's loads, probes and damping, and knows
the mesh, materials and constraints that it stands for."""

REDUCE_DETAILS = """\
Bases
  modal-derivatives  vibration modes and how they change as the body bends: for
                     laws that are not linear (default there: 8 modes; of them
                     and their 36 derivatives the r = 20 fields that tell most)
  linear             vibration modes (default for linear laws: 20 of them)
  snapshots=DIR      what `fenics-defo simulate` has written into DIR of the
                     same mesh (default: r = 20)

Forces
  linear    small displacements (default for the law "linear")
  cubic     exact for the law "st-venant-kirchhoff" (default there)
  cubature  any law but springs, summed over few points that are chosen for
            this body (default for all other laws)
  taylor    the third-order Taylor polynomial at rest: strains of some per cent

The cost of a step grows with r^4 where forces are cubic, with r^3 where they are
summed: 10 to 30 is usual. Try the result: play the scene, and compare its folder
with that of simulate.

Examples
  fenics-defo reduce plucked_bar.toml --output bar.npz
  fenics-defo reduce bent.toml --output bent.npz --modes 6 --size 12
  fenics-defo reduce drop.toml --output drop.npz --basis snapshots=out --share 0.9999

Exit status: 0 done, 1 something to mend (one sentence says what), 130 interrupted."""

PLAY = """\
Move the model of a scene's body through the scene, with NumPy alone.

DIR gets the files that simulate writes: summary.json, probes.csv, energy.csv and,
if the model stores all nodes, motion.pvd: two folders compare directly. The
scene may differ from the one that was reduced in all but mesh, materials and
constraints; its loads and probes must be at places that the model carries."""

PLAY_DETAILS = """\
Pressures are taken at rest: they do not follow the surface. Statics (integrator =
"static") look for the equilibrium of the model.

Example
  fenics-defo play bar.npz plucked_bar.toml --output played

Exit status: 0 done, 1 something to mend (one sentence says what), 130 interrupted."""


def add_reduce(commands: Any) -> None:
    """Add ``reduce`` to the parser's commands."""
    parser: Parser = commands.add_parser(
        "reduce",
        help="make a small model of a scene's body, in one file",
        usage="fenics-defo reduce SCENE.toml --output MODEL.npz [options]",
        description=REDUCE,
        epilog=REDUCE_DETAILS,
    )
    parser.add_argument("scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "--output", required=True, metavar="MODEL.npz", help="file of the model, replaced if there"
    )
    parser.add_argument(
        "--basis",
        type=basis_choice,
        metavar="BASIS",
        help="modal-derivatives, linear, or snapshots=DIR",
    )
    parser.add_argument(
        "--modes", type=positive_count, metavar="K", help="vibration modes to make the basis from"
    )
    parser.add_argument(
        "--size", type=positive_count, metavar="R", help="fields to keep; with --share, at most"
    )
    parser.add_argument(
        "--share",
        type=number,
        metavar="S",
        help="keep as many fields as hold this share of the squares of all singular values, such "
        "as 0.9999",
    )
    parser.add_argument(
        "--force",
        choices=("linear", "cubic", "taylor", "cubature"),
        help="how the forces are computed",
    )
    parser.add_argument(
        "--tolerance",
        type=number,
        default=0.01,
        metavar="T",
        help="relative error of the force at the poses that a cubature is trained at (default: "
        "%(default)s)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def add_play(commands: Any) -> None:
    """Add ``play`` to the parser's commands."""
    parser: Parser = commands.add_parser(
        "play",
        help="move a model through a scene, into a folder of results",
        usage="fenics-defo play MODEL.npz SCENE.toml --output DIR [options]",
        description=PLAY,
        epilog=PLAY_DETAILS,
    )
    parser.add_argument("model", metavar="MODEL.npz", help="what reduce has written")
    parser.add_argument("scene", metavar="SCENE.toml", help="scene file")
    parser.add_argument(
        "--output", required=True, metavar="DIR", help="folder of the results, made if missing"
    )
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="write over what simulate has left in DIR",
    )
    parser.add_argument(
        "--json", action="store_true", help="print summary.json instead of the summary"
    )


def basis_choice(text: str) -> tuple[str, str | None]:
    """Kind of a basis and the folder of its snapshots, for `argparse`."""
    kind, equals, folder = text.partition("=")
    if kind in ("linear", "modal-derivatives") and not equals:
        return kind, None
    if kind == "snapshots" and folder:
        return kind, folder
    raise argparse.ArgumentTypeError(
        "must be modal-derivatives, linear, or snapshots=DIR with the folder of a simulation's "
        f"results, got {text!r}"
    )
