"""``mesh-to-modes``: from a mesh file to its lowest vibration modes."""

import sys
import time
from argparse import Namespace

from fenics_defo import __version__
from fenics_defo.cli.command import Parser, Run, number, positive_count, run

DESCRIPTION = """\
Lowest vibration modes of an elastic body, from its mesh to verified numbers.

All quantities are in SI units (m, kg, s, Pa): a mesh in millimetres gives wrong
frequencies. Prints a table; saves frequencies, mode shapes, points and cells to
an .npz file that numpy.load opens, nodes and cells in the order of the mesh file."""

DETAILS = """\
SELECTION is one of
  NAME          a physical group or set of the mesh; in quotes if it looks like
                something else
  NUMBER        the number of a group
  CONDITION     on coordinates in metres: 'x<1e-6', 'z>=0.5 and y<0.1',
                'not abs(x)<2', 'x**2+y**2<0.01', 'y==0' (within 1e-9 of the size)
  nodes:FILE    a file of node numbers of the mesh file, from 1, separated by
                commas, spaces or lines
`fenics-defo info MESH` lists the groups and the size of a mesh. Write a selection
that starts with a minus sign as --fixed='-x>1'.

Examples
  mesh-to-modes fork.msh --fixed handle --count 10 --picture modes.png
  mesh-to-modes plate.inp --free --young 70e9 --poisson 0.33 --density 2700
  mesh-to-modes bracket.step --size 0.004 --order 2 --fixed 'z<1e-6'
  mesh-to-modes half.msh --fixed wall --fixed-in y 'y==0' --vtk modes.vtu
  mesh-to-modes body.veg --fixed nodes:body.bou --json
  mpiexec -n 4 mesh-to-modes large.msh --fixed base

Exit status: 0 done, 1 something to mend (one sentence says what), 130 interrupted."""


def build_parser() -> Parser:
    """Return the parser of the command line."""
    parser = Parser(
        prog="mesh-to-modes",
        usage="mesh-to-modes MESH [--fixed SELECTION]... [options]",
        description=DESCRIPTION,
        epilog=DETAILS,
        add_help=False,
    )
    _add_body(parser)
    _add_material(parser)
    _add_modes(parser)
    _add_output(parser)
    return parser


def _add_body(parser: Parser) -> None:
    body = parser.add_argument_group("the body")
    body.add_argument(
        "mesh",
        metavar="MESH",
        help="volume mesh: .msh .vtu .vtk .xdmf .inp .node .ele .mesh .veg; or, with --size, a "
        "closed surface .stl .obj .ply or a solid .step .iges .brep to be filled with tetrahedra",
    )
    body.add_argument(
        "--size", type=number, metavar="H", help="edge length [m] of those tetrahedra"
    )
    body.add_argument(
        "--unit",
        choices=("m", "cm", "mm", "um", "in", "ft"),
        default="m",
        help="unit of the file's coordinates (default: m); CAD programs often write mm",
    )
    body.add_argument(
        "--merge", type=number, metavar="TOL", help="make nodes closer than this [m] one node"
    )
    body.add_argument(
        "--order",
        type=int,
        choices=(1, 2),
        help="polynomial order of the displacements (default: that of the mesh's cells); order 2 "
        "is far more accurate in bending",
    )
    body.add_argument(
        "--fixed",
        action="append",
        default=[],
        metavar="SELECTION",
        help="hold these nodes; may be given again",
    )
    body.add_argument(
        "--fixed-in",
        action="append",
        default=[],
        nargs=2,
        metavar=("AXES", "SELECTION"),
        help="hold these nodes along some axes only: x, y, z, xy, ...; a plane of symmetry "
        "y = 0 is --fixed-in y 'y==0'; may be given again",
    )
    body.add_argument(
        "--free",
        action="store_true",
        help="hold nothing; the default where no --fixed is given",
    )


def _add_material(parser: Parser) -> None:
    material = parser.add_argument_group(
        "material",
        "Default: what the mesh file says, else steel: 2.1e11 Pa, 0.3, 7850 kg/m3.",
    )
    material.add_argument("--young", type=number, metavar="PA", help="Young's modulus [Pa]")
    material.add_argument("--poisson", type=number, metavar="NU", help="Poisson's ratio")
    material.add_argument("--density", type=number, metavar="KG_M3", help="density [kg/m3]")
    material.add_argument(
        "--materials",
        metavar="FILE.toml",
        help="one [[material]] table for each region, with the keys region (a group; left out: "
        "everywhere else), young, poisson, density, and perhaps law",
    )


def _add_modes(parser: Parser) -> None:
    modes = parser.add_argument_group("modes")
    modes.add_argument(
        "--count",
        type=positive_count,
        default=20,
        metavar="N",
        help="how many modes, the rigid ones of a free body included (default: 20)",
    )
    modes.add_argument("--drop-rigid", action="store_true", help="leave rigid modes out")
    modes.add_argument(
        "--no-count",
        action="store_true",
        help="skip the inertia count, which proves that no mode is missing and costs one more "
        "factorisation",
    )
    modes.add_argument(
        "--solver",
        choices=("davidson", "krylov-schur", "iterative"),
        default="davidson",
        help="davidson: block Davidson with MUMPS (default); krylov-schur: SLEPc's; iterative: "
        "with multigrid instead, for bodies whose factors exceed the memory, without a count",
    )


def _add_output(parser: Parser) -> None:
    output = parser.add_argument_group("output")
    output.add_argument(
        "--output",
        default="modes.npz",
        metavar="FILE.npz",
        help="where to save the modes (default: modes.npz)",
    )
    output.add_argument("--vtk", metavar="FILE", help="save .vtu or .vtk for ParaView")
    output.add_argument("--picture", metavar="FILE.png", help="draw the mode shapes")
    output.add_argument(
        "--json", action="store_true", help="print one JSON object instead of the table"
    )
    other = parser.add_argument_group("other")
    version = f"fenics_defo {__version__}"
    other.add_argument("--version", action="version", version=version, help="tell the version")
    other.add_argument("-h", "--help", action="help", help="show this and leave")


def main(argv: list[str] | None = None) -> int:
    """Run the command and return its exit status.

    Args:
        argv: arguments; those of the process if not given.
    """
    begin = time.perf_counter()
    parser = build_parser()
    try:
        options = parser.parse_args(argv)
        if options.free and (options.fixed or options.fixed_in):
            parser.error("--free and --fixed exclude each other, give one of them")
        if options.materials is not None and _constants(options):
            parser.error(f"--materials and {_constants(options)[0]} exclude each other")
    except SystemExit as leaving:  # --help, --version, or an error already told
        return int(leaving.code or 0)
    return run(parser.prog, lambda current: _work(options, current, begin))


def _constants(options: Namespace) -> list[str]:
    names = ("young", "poisson", "density")
    return [f"--{name}" for name in names if getattr(options, name) is not None]


def _work(options: Namespace, current: Run, begin: float) -> None:
    # Late imports: DOLFINx takes a second to load, and --help should not.
    from fenics_defo.cli.output import loading_libraries
    from fenics_defo.cli.progress import progress_shown

    with progress_shown(show=not options.json) as progress:
        progress.start("load")
        with loading_libraries():
            from fenics_defo.cli import modes_run

        modes_run.compute_and_print(options, current, progress, begin)


if __name__ == "__main__":
    sys.exit(main())
