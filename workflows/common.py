"""What the workflows share: a command line, bodies, tables and figures."""

import argparse
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before NumPy loads: its BLAS reads it once
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from fenics_defo import fem  # noqa: E402
from fenics_defo.fem.compat import MPI, dolfinx  # noqa: E402
from meshes import scripting  # noqa: E402


def parser(text: str | None, name: str) -> argparse.ArgumentParser:
    """The command line of a workflow: ``--output`` and ``--quick``.

    Args:
        text: the script's docstring, whose first line says what it does.
        name: of the files that it writes.
    """
    made = argparse.ArgumentParser(description=(text or "").split("\n", maxsplit=1)[0])
    made.add_argument(
        "--output",
        type=Path,
        default=Path("build/workflows"),
        metavar="DIR",
        help=f"folder for {name}.md and {name}.png (default: %(default)s)",
    )
    made.add_argument("--quick", action="store_true", help="a coarse mesh and few steps")
    return made


def box(
    size: Sequence[float], cells: Sequence[int], *, hexahedra: bool = False
) -> "dolfinx.io.gmsh.MeshData":
    """A box from the origin to ``size`` [m], of hexahedra or of six tetrahedra to a brick."""
    kind = dolfinx.mesh.CellType.hexahedron if hexahedra else dolfinx.mesh.CellType.tetrahedron
    mesh = dolfinx.mesh.create_box(MPI.COMM_WORLD, [[0.0, 0.0, 0.0], list(size)], cells, kind)
    return dolfinx.io.gmsh.MeshData(mesh, None, None, None, None, {})


def drawn(body: Callable[..., None], **options: Any) -> fem.ImportedMesh:
    """A body of ``meshes/``, by way of a file of gmsh's."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "body.msh"
        scripting.write(body, path, **options)
        return fem.read_mesh(path)


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table as Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def tell(folder: Path, name: str, text: str, figure: Any) -> None:
    """Print a text, and write it with its figure to a folder as ``name``.md and ``name``.png."""
    folder.mkdir(parents=True, exist_ok=True)
    print(text)
    (folder / f"{name}.md").write_text(text, encoding="utf-8")
    figure.savefig(folder / f"{name}.png", dpi=150)


def new_figure(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    """A figure of a size [in] without a window, and its axes."""
    from matplotlib.figure import Figure  # draws with Agg

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns)


def exponent(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Exponent p of values ~ sizes^p, by least squares of the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])
