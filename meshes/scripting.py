"""From a body to a file: a gmsh session, writing to disk, a command line.

A body is a function of keyword arguments that fills the current gmsh model: geometry, named groups
and mesh. `built` and `write` give it a model of its own, `run` gives it a command line made from
its signature, where each parameter is annotated ``Annotated[type, "help"]``.
"""

import argparse
import inspect
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NoReturn, get_args, get_origin

import gmsh
import numpy as np

if __package__:
    from meshes.modelling import MeshScriptError, check_cells
else:  # imported by a body that runs as a script
    from modelling import MeshScriptError, check_cells  # type: ignore[import-not-found,no-redef]

type Body = Callable[..., None]

# Formats that keep volume cells; others that gmsh writes are pictures, surfaces or its own scripts.
FORMATS = (".msh", ".vtk", ".mesh", ".inp", ".unv", ".bdf", ".su2", ".key")

# One thread and fixed seeds: the same arguments give the same mesh. The rest pins the defaults, so
# that a session the user has already configured gives that mesh too.
_OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.RandomSeed": 1,
    "Mesh.MaxNumThreads1D": 1,
    "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1,
    "Mesh.Algorithm": 6,
    "Mesh.Algorithm3D": 10,
    "Mesh.ElementOrder": 1,
    "Mesh.SecondOrderLinear": 0,
    "Mesh.SecondOrderIncomplete": 0,
    "Mesh.RecombineAll": 0,
    "Mesh.Optimize": 1,
    "Mesh.SaveAll": 0,
    "Mesh.Binary": 0,
    "Mesh.MshFileVersion": 4.1,
    "Mesh.MeshSizeMin": 0.0,
    "Mesh.MeshSizeMax": 1.0e22,
    "Mesh.MeshSizeFactor": 1.0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.MeshSizeExtendFromBoundary": 1,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshSummary:
    """What a finished mesh holds.

    Args:
        nodes: number of nodes.
        cells: number of volume cells.
        quality: smallest signed inverse condition number of a cell's Jacobian [-]: 1 for a
            regular cell, 0 for a flat one, negative for an inverted one.
        groups: names of the physical groups.
    """

    nodes: int
    cells: int
    quality: float
    groups: tuple[str, ...]

    def __str__(self) -> str:
        groups = ", ".join(self.groups)
        return (
            f"{self.nodes} nodes, {3 * self.nodes} dofs, {self.cells} cells, "
            f"worst quality {self.quality:.2f}, groups {groups}"
        )


@contextmanager
def session() -> Iterator[None]:
    """Give the body a gmsh model of its own and leave the caller's session as it was.

    A session that is already open stays open, with its options and its current model.
    """
    owner = not gmsh.isInitialized()
    if owner:
        gmsh.initialize(argv=["gmsh"], readConfigFiles=False, interruptible=False)
    before = {name: gmsh.option.getNumber(name) for name in _OPTIONS}
    current = gmsh.model.getCurrent()
    for name, value in _OPTIONS.items():
        gmsh.option.setNumber(name, value)
    gmsh.model.add(f"meshes-{time.monotonic_ns()}")  # models are found by name: a fresh one
    try:
        yield
    finally:
        gmsh.model.remove()
        gmsh.model.setCurrent(current)
        for name, value in before.items():
            gmsh.option.setNumber(name, value)
        if owner:
            gmsh.finalize()


@contextmanager
def built(body: Body, **options: Any) -> Iterator[MeshSummary]:
    """Build ``body(**options)`` in a fresh gmsh model, which is current inside the block."""
    with session():
        body(**options)
        _, cells, cell_nodes = gmsh.model.mesh.getElements(3)
        names = [gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()]
        yield MeshSummary(
            nodes=len(np.unique(np.concatenate(cell_nodes))),
            cells=sum(map(len, cells)),
            quality=check_cells(),
            groups=tuple(names),
        )


def write(
    body: Body, path: str | os.PathLike[str], *, format_version: float = 4.1, **options: Any
) -> MeshSummary:
    """Build ``body(**options)`` and write its mesh to ``path``.

    The file is written beside its place and then renamed: a reader never meets half of one.

    Args:
        body: function that fills the current gmsh model.
        path: file to write; its ending, one of `FORMATS`, chooses the format.
        format_version: 4.1 or 2.2, for ``.msh`` files.
        options: keyword arguments of ``body``.

    Raises:
        MeshScriptError: the options or the ending are not allowed, or the file cannot be written.
    """
    target = Path(path)
    if target.suffix not in FORMATS:
        raise MeshScriptError(f"{target}: the file's ending must be one of {', '.join(FORMATS)}.")
    if target.is_dir():
        raise MeshScriptError(f"{target} is a folder; give the name of a file in it.")
    try:
        with tempfile.TemporaryDirectory(prefix=f".{target.stem}-", dir=target.parent) as folder:
            part = Path(folder) / target.name
            with built(body, **options) as summary:
                gmsh.option.setNumber("Mesh.MshFileVersion", format_version)
                gmsh.write(str(part))
            part.replace(target)
    except OSError as error:
        raise MeshScriptError(
            f"cannot write {target}: {error.strerror}; choose a folder that exists and is yours."
        ) from error
    return summary


class _Parser(argparse.ArgumentParser):
    """A parser whose complaint is one sentence and exit status 1, like every mistake here."""

    def error(self, message: str) -> NoReturn:
        self.exit(1, f"{self.prog}: {message}; see {self.prog} --help.\n")


def _parser(body: Body) -> argparse.ArgumentParser:
    summary = (inspect.getdoc(body) or "").partition("\n\n")[0]
    parser = _Parser(prog=f"{body.__name__}.py", description=summary)
    for name, parameter in inspect.signature(body).parameters.items():
        kind, text = get_args(parameter.annotation)
        choices = get_args(kind) if get_origin(kind) is Literal else None
        parser.add_argument(
            f"--{name.replace('_', '-')}",
            type=type(choices[0]) if choices else kind,
            choices=choices,
            default=parameter.default,
            metavar=None if choices else "H" if name == "size" else "METRES",
            help=f"{text} (default: %(default)s)",
        )
    file = f"{body.__name__}.msh"
    parser.add_argument("-o", "--output", default=file, help="file to write (default: %(default)s)")
    parser.add_argument(
        "--format-version", type=float, choices=(2.2, 4.1), default=4.1, help="of .msh files"
    )
    return parser


def run(body: Body, argv: Sequence[str] | None = None) -> int:
    """Build a body as the command line asks, print one line about it, return the exit status."""
    options = vars(_parser(body).parse_args(argv))
    output = options.pop("output")
    start = time.perf_counter()
    try:
        summary = write(body, output, **options)
    except MeshScriptError as error:
        print(f"{body.__name__}.py: {error}", file=sys.stderr)
        return 1
    print(f"{output}: {summary}, {time.perf_counter() - start:.1f} s")
    return 0
