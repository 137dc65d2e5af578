"""Run a reduced model where NumPy alone is installed."""

import sys

import numpy as np

from fenics_defo import runtime


def main(path: str) -> None:
    """Let the model of ``path`` fall for 50 steps and check that it moved."""
    model = runtime.load(path)
    stepper = runtime.ImplicitNewmark(model, step=1e-3)
    load = model.gravity((0.0, 0.0, -9.81))
    for _ in range(50):
        stepper.advance(load)
    if not 0.0 < np.abs(model.displacement(stepper.q)).max() < np.inf:
        raise SystemExit("the model did not move")
    foreign = {"dolfinx", "ufl", "petsc4py", "mpi4py", "scipy"} & set(sys.modules)
    if foreign:
        raise SystemExit(f"the runtime loaded {', '.join(sorted(foreign))}")


if __name__ == "__main__":
    main(sys.argv[1])
