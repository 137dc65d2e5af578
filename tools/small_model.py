"""Make a small reduced model with FEniCSx, for ``run_model.py`` to run without it."""

import sys

import fenics_defo.fem.compat  # noqa: F401 -- MPI before DOLFINx
from fenics_defo import analysis, energy, fem, reduction


def main(path: str) -> None:
    """Write a model of a short neo-Hookean bar, by cubature, to ``path``."""
    rubber = energy.NeoHookean(young=1e6, poisson=0.4, density=1000.0)
    mesh = fem.read_mesh("scenes/meshes/bar.msh")
    bar = fem.Solid(mesh, rubber, fixed=["clamped"])
    modes = analysis.linear_modes(bar, 3)
    basis = reduction.modal_derivative_basis(bar, modes, size=5)
    reduction.reduce(bar, basis, "cubature").save(path)


if __name__ == "__main__":
    main(sys.argv[1])
