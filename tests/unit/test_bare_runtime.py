"""What runs in a game or on a robot: the runtime, with NumPy and nothing else installed."""

import subprocess
import sys

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
