"""How long 20 modes take, where the time goes, and what one factorisation costs beside it.

Runs each case in a process of its own (so that its peak memory is its own), prints a table, and
writes it to a folder as Markdown, JSON and a figure:

    python workflows/benchmark_modes.py --output docs/benchmarks

The bodies are the arch bridge of ``meshes/bridge.py`` at four sizes, and a clamped box beam 4 x 1 x
1 m of 64x14x14 (order 1) and 36x12x12 (order 2) cells of six tetrahedra, for which figures of other
programs are known. Each case is measured against three others on the same matrices: SLEPc's
Krylov-Schur, SciPy's ``eigsh`` (shift and invert with SuperLU; up to 50,000 dofs, beyond which
SuperLU needs minutes), and one factorisation by MUMPS, which is the floor.
"""

import argparse
import contextlib
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COUNT = 20
EIGSH_LIMIT = 50_000
STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7850.0}

#: name -> (body, element size [m] or cells, order)
CASES: dict[str, tuple[str, float | tuple[int, int, int], int]] = {
    "bridge 10k": ("bridge", 0.48, 1),
    "bridge 30k": ("bridge", 0.24, 1),
    "bridge 100k": ("bridge", 0.14, 1),
    "bridge 300k": ("bridge", 0.09, 1),
    "box beam 44k": ("box", (64, 14, 14), 1),
    "box beam 137k, order 2": ("box", (36, 12, 12), 2),
}
PHASES = ("assemble", "factorise", "solve", "count")
COLUMNS = (
    *("case", "dofs", "cells", "read", "assemble", "factorise", "solve", "total", "floor"),
    *(
        "total / floor",
        "count",
        "peak GiB",
        "Krylov-Schur",
        "eigsh",
        "factorise, OpenBLAS's own gemmt",
    ),
)


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark, or one case of it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--output", type=Path, help="folder for modes.md, modes.json, modes.png")
    parser.add_argument(
        "--repeat", type=int, default=3, help="runs of each case; medians are shown"
    )
    parser.add_argument("--cases", nargs="*", choices=CASES, default=list(CASES), metavar="CASE")
    parser.add_argument("--measure", choices=CASES, help=argparse.SUPPRESS)
    parser.add_argument("--beside", choices=("nothing", "krylov-schur", "eigsh", "plain-blas"))
    options = parser.parse_args(argv)
    if options.measure:
        print(json.dumps(measure(options.measure, options.beside or "nothing")))
        return 0
    results = {name: repeated(name, options.repeat) for name in options.cases}
    text = report(results, options.repeat)
    print(text)
    check(results)
    if options.output:
        options.output.mkdir(parents=True, exist_ok=True)
        (options.output / "modes.md").write_text(text, encoding="utf-8")
        (options.output / "modes.json").write_text(json.dumps(results, indent=1) + "\n")
        draw(results, options.output / "modes.png")
    return 0


def repeated(name: str, times: int) -> dict[str, float]:
    """Medians of several runs of a case, with the peers measured in turn with it."""
    runs: list[dict[str, float]] = []
    for _ in range(times):
        run = in_own_process(name, "nothing")
        run |= in_own_process(name, "krylov-schur")
        run |= in_own_process(name, "plain-blas")
        if run["dofs"] <= EIGSH_LIMIT:
            run |= in_own_process(name, "eigsh")
        runs.append(run)
        print(f"{name}: {run['total']:.2f} s", file=sys.stderr)
    return {key: statistics.median(run[key] for run in runs) for key in runs[0]}


def in_own_process(name: str, beside: str) -> dict[str, float]:
    """One measurement in a fresh process."""
    environment = {"OMP_NUM_THREADS": "1"} | dict(os.environ)
    if beside == "plain-blas":
        environment["FENICS_DEFO_GEMMT"] = "0"
    command = [sys.executable, __file__, "--measure", name, "--beside", beside]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def measure(name: str, beside: str) -> dict[str, float]:
    """Seconds by phase and peak memory of one case, or of a peer on the same matrices."""
    from fenics_defo import analysis

    solid, read = body(*CASES[name])
    warm(solid)
    if beside == "eigsh":
        return {"eigsh": by_eigsh(solid)}
    phases = analysis.Phases()
    solver = "krylov-schur" if beside == "krylov-schur" else "davidson"
    verify = beside == "nothing"
    modes = analysis.linear_modes(solid, COUNT, solver=solver, verify=verify, phases=phases)
    seconds = phases.seconds
    total = sum(seconds[phase] for phase in PHASES if phase in seconds and phase != "count")
    if beside == "krylov-schur":
        return {"krylov-schur": total}
    if beside == "plain-blas":
        return {"factorise, plain BLAS": seconds["factorise"]}
    assert modes.complete
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    seconds["floor"] = one_factorisation(solid)
    figures = {"dofs": solid.dof_count, "cells": len(solid.cells), "read": read, "total": total}
    return figures | seconds | {"peak_gib": peak, "residual": float(modes.residuals.max())}


def body(kind: str, size: float | tuple[int, int, int], order: int) -> tuple:
    """A case's body, and the seconds that reading its mesh took."""
    from fenics_defo import energy, fem
    from fenics_defo.fem.compat import MPI, dolfinx

    steel = energy.StVenantKirchhoff(**STEEL)
    if kind == "bridge":
        sys.path.insert(0, str(ROOT))
        from meshes.bridge import bridge
        from meshes.scripting import write

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "bridge.msh"
            write(bridge, path, size=size)
            begin = time.perf_counter()
            solid = fem.Solid(fem.read_mesh(path), steel, order=order, fixed=["abutments"])
            return solid, time.perf_counter() - begin
    begin = time.perf_counter()
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_WORLD, [[0, 0, 0], [4, 1, 1]], size, dolfinx.mesh.CellType.tetrahedron
    )
    data = dolfinx.io.gmsh.MeshData(mesh, None, None, None, None, {})
    solid = fem.Solid(data, steel, order=order, fixed=["x<1e-6"])
    return solid, time.perf_counter() - begin


def warm(solid: object) -> None:
    """Compile the forms, which DOLFINx keeps on disk between runs."""
    from fenics_defo.analysis.inertia import body_inertia

    body_inertia(solid)
    for matrix in (solid.assembly.stiffness_matrix(), solid.assembly.mass.matrix()):
        matrix.destroy()


def one_factorisation(solid: object) -> float:
    """Seconds of one factorisation of the stiffness by MUMPS in double precision."""
    from fenics_defo.fem.linalg import Factorization

    matrix = solid.assembly.stiffness_matrix()
    begin = time.perf_counter()
    Factorization(matrix, definite=True).close()
    matrix.destroy()
    return time.perf_counter() - begin


def by_eigsh(solid: object) -> float:
    """Seconds that SciPy's shift-and-invert Lanczos takes, its factorisation included."""
    from scipy.sparse.linalg import eigsh

    free = (~solid.held).ravel()
    stiffness, mass = solid.tangent()[free][:, free].tocsc(), solid.mass()[free][:, free].tocsc()
    begin = time.perf_counter()
    eigsh(stiffness, COUNT, M=mass, sigma=0.0)
    return time.perf_counter() - begin


def check(results: dict[str, dict[str, float]]) -> None:
    """The relations that hold on any machine, far from the noise."""
    for name, row in results.items():
        assert row["residual"] < 1e-6, name
        if row["dofs"] > 40_000:
            assert row["factorise"] < row["factorise, plain BLAS"], name
        if "eigsh" in row:
            assert row["eigsh"] > 2.0 * row["total"], name


def growth(results: dict[str, dict[str, float]], key: str) -> float:
    """Exponent p of key ~ dofs^p between the smallest and the largest bridge."""
    import math

    rows = [row for name, row in results.items() if name.startswith("bridge")]
    if len(rows) < 2:
        return math.nan
    first, last = rows[0], rows[-1]
    return math.log(last[key] / first[key]) / math.log(last["dofs"] / first["dofs"])


def report(results: dict[str, dict[str, float]], runs: int) -> str:
    """The table as Markdown."""
    lines = [
        "# 20 modes: seconds by phase",
        "",
        f"Medians of {runs} run{'s' if runs > 1 else ''}, one thread, {processor()}, Python",
        f"{platform.python_version()}. `floor` is one factorisation by MUMPS in double precision,",
        "`factorise` the one in single precision that the search uses;",
        "`total` is `assemble + factorise + solve`, without reading the mesh and without the count",
        "that proves completeness. Made by `workflows/benchmark_modes.py`.",
        "",
        "| " + " | ".join(COLUMNS) + " |",
        "| --- " * len(COLUMNS) + "|",
    ]
    lines += ["| " + " | ".join((name, *cells(row))) + " |" for name, row in results.items()]
    exponents = ", ".join(
        f"{key} {growth(results, key):.2f}" for key in (*PHASES[:3], "total", "peak_gib")
    )
    lines += ["", f"Growth with the bridge's dofs, exponents: {exponents}.", ""]
    lines += ["![Seconds against degrees of freedom](modes.png)", ""]
    return "\n".join(lines)


def cells(row: dict[str, float]) -> tuple[str, ...]:
    """A case's cells of the table, in the order of ``COLUMNS``, without its name."""
    eigsh = f"{row['eigsh']:.1f} ({row['eigsh'] / row['total']:.1f}x)" if "eigsh" in row else "–"
    return (
        f"{row['dofs']:.0f}",
        f"{row['cells']:.0f}",
        *(f"{row[key]:.2f}" for key in ("read", *PHASES[:3])),
        f"**{row['total']:.2f}**",
        f"{row['floor']:.2f}",
        f"{row['total'] / row['floor']:.1f}",
        f"{row['count']:.2f}",
        f"{row['peak_gib']:.2f}",
        f"{row['krylov-schur']:.2f}",
        eigsh,
        f"{row['factorise, plain BLAS']:.2f}",
    )


def processor() -> str:
    """Name of the processor, where the system tells it."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.machine()


def draw(results: dict[str, dict[str, float]], path: Path) -> None:
    """Seconds against dofs of the bridge, with the floor."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    rows = [row for name, row in results.items() if name.startswith("bridge")]
    figure, axes = plt.subplots(figsize=(6.4, 4.2), layout="constrained")
    dofs = [row["dofs"] for row in rows]
    for key, label, style in (
        ("total", "20 modes, block Davidson", "o-"),
        ("krylov-schur", "20 modes, SLEPc's Krylov-Schur", "s--"),
        ("floor", "one factorisation in double precision", "k:"),
    ):
        axes.loglog(dofs, [row[key] for row in rows], style, label=label)
    with_eigsh = [row for row in rows if "eigsh" in row]
    axes.loglog(
        [row["dofs"] for row in with_eigsh],
        [row["eigsh"] for row in with_eigsh],
        "^-.",
        label="20 modes, SciPy's eigsh",
    )
    axes.set(xlabel="degrees of freedom", ylabel="seconds")
    axes.grid(which="both", alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    sys.exit(main())
