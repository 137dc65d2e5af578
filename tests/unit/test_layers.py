"""The package's imports go to the left in the order of ARCHITECTURE.md, and nothing runs data."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

import fenics_defo

LAYERS = (
    "errors",
    "beams",
    "runtime",
    "energy",
    "fem",
    "analysis",
    "reduction",
    "scene",
    "view",
    "cli",
)

# What a layer may load besides the standard library; a layer that is not here may load anything
# but what PARALLEL keeps to two of them.
THIRD_PARTY = {
    "": frozenset(),  # the package itself
    "errors": frozenset(),
    "beams": frozenset({"numpy", "scipy"}),
    "runtime": frozenset({"numpy"}),
    "energy": frozenset({"numpy", "ufl"}),
}
PARALLEL = frozenset({"dolfinx", "dolfinx_solver", "mpi4py", "petsc4py", "slepc4py"})
PARALLEL_LAYERS = frozenset({"fem", "analysis"})
OF_THE_LEFT = {"runtime": frozenset({"errors"})}  # where it is less than everything to the left

RUN_DATA = frozenset({"eval", "exec", "compile"})
UNPICKLERS = frozenset({"cloudpickle", "dill", "joblib", "marshal", "pickle", "shelve"})
IMPORTERS = frozenset({"import_module", "__import__"})


class Module(NamedTuple):
    """One source file: its dotted name within the package (empty for the package), and its tree."""

    name: str
    is_package: bool
    tree: ast.Module
    path: Path

    @property
    def layer(self) -> str:
        return self.name.partition(".")[0]


class Import(NamedTuple):
    line: int
    target: str  # dotted and absolute


def modules_of(root: Path) -> Iterator[Module]:
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        name = ".".join(parts[:-1] if is_package else parts)
        yield Module(name, is_package, ast.parse(path.read_text(encoding="utf-8")), path)


def absolute(module: Module, package: str, level: int, target: str) -> str:
    """Dotted name of ``target`` seen ``level`` dots up from ``module``."""
    if level == 0:
        return target
    here = [package, *module.name.split(".")] if module.name else [package]
    up = level - 1 if module.is_package else level
    base = here[: len(here) - up]
    return ".".join([*base, target] if target else base)


def name_of(function: ast.expr) -> str:
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ""


def is_own_name(argument: ast.expr) -> bool:
    """Whether it is an f-string that starts with ``__name__``: a package's own submodule."""
    if not isinstance(argument, ast.JoinedStr) or not argument.values:
        return False
    first = argument.values[0]
    return isinstance(first, ast.FormattedValue) and name_of(first.value) == "__name__"


def imports_of(module: Module, package: str) -> Iterator[Import]:
    """Every import, wherever it stands: in functions, under TYPE_CHECKING, through importlib."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield Import(node.lineno, alias.name)
        elif isinstance(node, ast.ImportFrom):
            base = absolute(module, package, node.level, node.module or "")
            for alias in node.names:
                yield Import(node.lineno, f"{base}.{alias.name}")
        elif isinstance(node, ast.Call) and name_of(node.func) in IMPORTERS and node.args:
            argument = node.args[0]
            if isinstance(argument, ast.Constant) and isinstance(argument.value, str):
                target = argument.value.lstrip(".")
                level = len(argument.value) - len(target)
                yield Import(node.lineno, absolute(module, package, level, target))
            elif not is_own_name(argument):
                yield Import(node.lineno, "?")


def fault_within(module: Module, target: str) -> str:
    """What is wrong with importing ``target``, a dotted name within the package."""
    layer = target.partition(".")[0]
    if layer in ("", "__version__") or layer == module.layer:
        return ""
    if layer not in LAYERS:
        return f"{layer!r} is no layer"
    if module.layer in OF_THE_LEFT and layer not in OF_THE_LEFT[module.layer]:
        return f"{module.layer} may not import {layer}"
    if module.layer not in LAYERS or LAYERS.index(layer) > LAYERS.index(module.layer):
        return f"{module.layer or 'the package'} imports {layer}, which is not on its left"
    return ""


def fault_outside(module: Module, target: str) -> str:
    """What is wrong with importing ``target`` from outside the package."""
    library = target.partition(".")[0]
    if library == "?":
        return "imports a module whose name cannot be read here"
    if library in UNPICKLERS:
        return f"{library} runs what it reads"
    if library in sys.stdlib_module_names:
        return ""
    if library in PARALLEL and module.layer not in PARALLEL_LAYERS:
        return f"{library} is for {' and '.join(sorted(PARALLEL_LAYERS))} only"
    if library not in THIRD_PARTY.get(module.layer, {library}):
        return f"{module.layer or 'the package'} may not load {library}"
    return ""


def calls_that_run_data(module: Module) -> Iterator[tuple[int, str]]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Name) and node.id in RUN_DATA:
            yield node.lineno, f"{node.id} runs data as code"
        elif isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            given = node.value
            if not (isinstance(given, ast.Constant) and given.value is False):
                yield given.lineno, "allow_pickle must be False"


def faults(root: Path) -> list[str]:
    """Every breach of the rules below ``root``, as ``file:line: what``."""
    package = root.name
    found = []
    for module in modules_of(root):
        where = module.path.relative_to(root)
        if module.layer not in ("", *LAYERS):
            found.append(f"{where}:1: {module.layer!r} is no layer")
            continue
        for line, target in imports_of(module, package):
            inside = target == package or target.startswith(f"{package}.")
            fault = (
                fault_within(module, target.removeprefix(package).lstrip("."))
                if inside
                else fault_outside(module, target)
            )
            if fault:
                found.append(f"{where}:{line}: {fault}")
        found += [f"{where}:{line}: {fault}" for line, fault in calls_that_run_data(module)]
    return sorted(found)


def write_package(root: Path, sources: dict[str, str]) -> Path:
    for name, source in {"__init__.py": "", **sources}.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
    return root


def test_the_package_keeps_its_layers() -> None:
    root = Path(fenics_defo.__file__).parent
    names = {module.name for module in modules_of(root)}
    assert {"", "errors"} <= names
    assert faults(root) == []


def test_a_package_that_keeps_the_rules_passes(tmp_path: Path) -> None:
    root = write_package(
        tmp_path / "pack",
        {
            "__init__.py": "import importlib\nimportlib.import_module(f'{__name__}.fem')\n",
            "errors.py": "import math\n",
            "runtime/__init__.py": "import numpy as np\nfrom pack.errors import DefoError\n",
            "runtime/files.py": "from . import model\nfrom ..errors import DefoError\n",
            "runtime/model.py": "import numpy.linalg\nnp.load('f', allow_pickle=False)\n",
            "fem/solid.py": "from mpi4py import MPI\nfrom pack import energy\nu.eval(x)\n",
            "view/picture.py": "import pyvista\nfrom pack.analysis.modes import Modes\n",
            "cli/main.py": "def main():\n    from pack import __version__, view\n",
        },
    )
    assert faults(root) == []


@pytest.mark.parametrize(
    ("file", "source", "fault"),
    [
        ("fem/a.py", "import pack.analysis", "fem imports analysis"),
        ("fem/a.py", "from pack import cli", "fem imports cli"),
        ("fem/a.py", "from pack.view.picture import draw", "fem imports view"),
        ("fem/a.py", "from ..analysis import modes", "fem imports analysis"),
        ("fem/__init__.py", "from .. import analysis", "fem imports analysis"),
        ("fem/deep/a.py", "from ...analysis import modes", "fem imports analysis"),
        ("scene/a.py", "from pack import view", "scene imports view"),
        ("errors.py", "from pack.beams import rod", "errors imports beams"),
        ("fem/a.py", "def f():\n    from pack import view", "a.py:2: fem imports view"),
        ("fem/a.py", "if TYPE_CHECKING:\n    import pack.cli", "fem imports cli"),
        ("fem/a.py", "importlib.import_module('pack.cli.x')", "fem imports cli"),
        ("fem/a.py", "import_module('..cli', __name__)", "fem imports cli"),
        ("fem/a.py", "__import__(name)", "cannot be read"),
        ("fem/a.py", "from pack import *", "'*' is no layer"),
        ("__init__.py", "from pack import errors", "the package imports errors"),
        ("__init__.py", "import numpy", "the package may not load numpy"),
        ("utils.py", "", "'utils' is no layer"),
        ("runtime/a.py", "from pack import beams", "runtime may not import beams"),
        ("runtime/a.py", "import scipy.linalg", "runtime may not load scipy"),
        ("runtime/a.py", "def f():\n    import meshio", "runtime may not load meshio"),
        ("energy/a.py", "from basix.ufl import element", "energy may not load basix"),
        ("view/a.py", "import dolfinx.fem", "dolfinx is for analysis and fem only"),
        ("cli/a.py", "from mpi4py import MPI", "mpi4py is for analysis and fem only"),
        ("reduction/a.py", "from petsc4py import PETSc", "petsc4py is for"),
        ("view/a.py", "from slepc4py import SLEPc", "slepc4py is for"),
        ("fem/a.py", "import pickle", "pickle runs what it reads"),
        ("fem/a.py", "x = eval('1')", "eval runs data"),
        ("fem/a.py", "run = exec", "exec runs data"),
        ("runtime/a.py", "np.load(f, allow_pickle=True)", "allow_pickle must be False"),
        ("runtime/a.py", "np.load(f, allow_pickle=flag)", "allow_pickle must be False"),
    ],
)
def test_each_breach_is_found(tmp_path: Path, file: str, source: str, fault: str) -> None:
    root = write_package(tmp_path / "pack", {file: source})
    (found,) = faults(root)
    assert fault in found
    assert found.startswith(f"{file}:")
