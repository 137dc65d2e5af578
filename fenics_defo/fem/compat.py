"""The one place that imports MPI, PETSc and DOLFINx, in the order they need.

DOLFINx comes from PyPI's ``dolfinx-solver-real``, from Debian or from conda-forge: the first wants
its own package imported before everything else, and all want ``mpi4py.MPI`` loaded before the C++
libraries that link to MPI.
"""

from pathlib import Path

from fenics_defo.errors import MissingDependencyError
from fenics_defo.fem import gemmt

_SUPPORTED = (0, 11)

try:
    import dolfinx_solver
except ImportError:
    #: True when MUMPS uses this package's triangular product.
    FAST_GEMMT = False
else:
    FAST_GEMMT = gemmt.install(Path(dolfinx_solver.__file__).with_name("lib"))

try:
    from mpi4py import MPI
    from petsc4py import PETSc

    import dolfinx
    import dolfinx.fem.petsc
    import dolfinx.io.gmsh
except ImportError as error:
    raise MissingDependencyError(
        f"DOLFINx cannot be loaded ({error}): install it with `pip install 'fenics_defo[fem]'`, "
        "or from Debian (python3-dolfinx) or conda-forge (fenics-dolfinx), version 0.11"
    ) from error

if PETSc.ScalarType is not PETSc.RealType:
    raise MissingDependencyError(
        "this DOLFINx is built with complex numbers, and fenics_defo needs the real build: "
        "`pip uninstall dolfinx-solver dolfinx-solver-complex`, then "
        "`pip install dolfinx-solver-real`"
    )
if tuple(int(part) for part in dolfinx.__version__.split(".")[:2]) != _SUPPORTED:
    raise MissingDependencyError(
        f"DOLFINx {dolfinx.__version__} is installed, and fenics_defo needs version 0.11: "
        "`pip install 'dolfinx-solver-real==0.11.*'`"
    )

__all__ = ["FAST_GEMMT", "MPI", "PETSc", "dolfinx"]
