"""A column half of which is up to a million times as dense as the other half."""

from functools import lru_cache, partial

from fenics_defo import fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np

from workflows.stability_map.bodies import DENSITY, box, material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, free_motion
from workflows.stability_map.outcomes import Measured
from workflows.stability_map.references import Spectrum, spectrum

TITLE = "Density contrast"
_CONTRASTS = (1.0, 1e2, 1e4, 1e6)
_SMALL = 1e-4
# More steps than this a cell does not do.
_MOST = 400


def cases(*, quick: bool) -> list[Case]:
    """All cells: which half is heavy, method and linear solver."""
    ways = [(name, "cholesky") for name in METHODS if "1 iteration" not in name]
    ways += [("Newmark, converged", solver) for solver in ("pcg-jacobi", "pcg-amg")]
    return [
        Case(
            sweep=f"{TITLE}, heavy {heavy}",
            row=name if solver == "cholesky" else f"{name}, {solver}",
            column=f"{contrast:.0e}",
            compute=partial(cell, name, heavy, contrast, solver),
        )
        for heavy in (("tip",) if quick else ("tip", "root"))
        for name, solver in (ways[::3] if quick else ways)
        for contrast in (_CONTRASTS[::3] if quick else _CONTRASTS)
    ]


@lru_cache(maxsize=4)
def column(heavy: str, contrast: float) -> fem.Solid:
    """A clamped column of two cubes, of St. Venant-Kirchhoff's law."""
    densities = np.array([1.0, contrast] if heavy == "tip" else [contrast, 1.0]) * DENSITY
    law = material("St. Venant-Kirchhoff", density=densities)
    return fem.Solid(box((1, 1, 2), (1.0, 1.0, 2.0)), law, fixed=["z<1e-6"])


@lru_cache(maxsize=8)
def vibrations(heavy: str, contrast: float, lumped: bool) -> Spectrum:
    """Of that column."""
    return spectrum(column(heavy, contrast), lumped=lumped)


def cell(name: str, heavy: str, contrast: float, solver: str) -> Measured:
    """A quarter period of the first mode, a hundredth of a period a step or what is stable."""
    method = METHODS[name]
    modes = vibrations(heavy, contrast, method.integrator.explicit)
    omega = modes.omega[0]
    step = 0.02 * np.pi / omega
    if method.integrator.explicit:
        step = min(step, 1.8 / modes.omega[-1])
    count = min(max(round(0.5 * np.pi / (omega * step)), 2), _MOST)
    velocity = _SMALL * omega * modes.shapes[0]
    path = free_motion(
        column(heavy, contrast),
        method,
        step=step,
        count=count,
        velocity=velocity,
        linear=solver,
        linear_tolerance=1e-8,
    )
    exact = _SMALL * np.sin(omega * path.times)[:, None, None] * modes.shapes[0]
    error = float(np.abs(path.displacement - exact).max()) / _SMALL
    return Measured(error=error, growth=path.growth, note=f"energy changes by {path.drift:.1e}")
