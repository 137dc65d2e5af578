"""What runs in a game or on a robot: the runtime, with NumPy and nothing else installed."""

import subprocess
import sys
from pathlib import Path

import numpy as np

from tests.unit.runtime.reduced_models import make_frame, make_model

# Hides everything but NumPy, the standard library and the package itself: more than the libraries
# that we know today.
BARE = """
import importlib, importlib.abc, pkgutil, sys

class NumpyAlone(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in {"numpy", "fenics_defo"} and top not in sys.stdlib_module_names:
            raise ModuleNotFoundError(f"{name} is hidden", name=name)

sys.meta_path.insert(0, NumpyAlone())
for name in ("dolfinx", "ufl", "petsc4py", "slepc4py", "mpi4py", "scipy", "gmsh", "meshio",
             "rich", "pyvista"):
    assert name not in sys.modules, f"{name} was loaded before the test began"
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        assert "is hidden" in str(error), error
    else:
        raise AssertionError(f"{name} is not hidden")

import fenics_defo
import fenics_defo.runtime as runtime

for module in pkgutil.walk_packages(runtime.__path__, runtime.__name__ + "."):
    importlib.import_module(module.name)
    print(module.name)
"""


def test_the_runtime_needs_numpy_only() -> None:
    done = subprocess.run(
        [sys.executable, "-c", BARE], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split(), "the runtime holds no module"


def test_a_model_is_loaded_and_evaluated_with_numpy_alone(tmp_path: Path) -> None:
    model = make_model("cubic", frame=make_frame())
    model.save(tmp_path / "model.npz")
    move = (
        f"model = runtime.load({str(tmp_path / 'model.npz')!r})\n"
        "q = [0.1, -0.2, 0.3]\n"
        "results = model.force(q), model.displacement(q)[3], model.point_load(2, (0, 0, 1))\n"
        "print('found', *(value.hex() for result in results for value in result.tolist()))"
    )
    done = subprocess.run(
        [sys.executable, "-c", BARE + move],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    q = np.array([0.1, -0.2, 0.3])
    expected = [model.force(q), model.displacement(q)[3], model.point_load(2, (0, 0, 1))]
    found = [float.fromhex(word) for word in done.stdout.splitlines()[-1].split()[1:]]
    np.testing.assert_array_equal(found, np.concatenate(expected))


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = (
        "import sys, fenics_defo\n"
        "heavy = {'numpy', 'scipy', 'dolfinx', 'ufl', 'mpi4py', 'petsc4py', 'gmsh', 'pyvista'}\n"
        "print(*sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.split() == []
