"""Slender beams, and nearly incompressible ones: what bending asks of elements and solvers."""

from functools import lru_cache, partial

from fenics_defo import analysis, beams, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np
from scipy.sparse.linalg import eigsh

from workflows.stability_map.bodies import DENSITY, YOUNG, box, material
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, free_motion
from workflows.stability_map.outcomes import Measured

SLENDER_TITLE, LOCKING_TITLE = "Slenderness", "Poisson's ratio, bending"
_SLENDER = (5, 20, 50, 100, 200, 500)
_RATIOS = (0.0, 0.3, 0.45, 0.49, 0.499, 0.4999)
_ELEMENTS = {
    "tetrahedra of order 1": ("tetrahedron", 1),
    "tetrahedra of order 2": ("tetrahedron", 2),
    "hexahedra of order 1": ("hexahedron", 1),
    "hexahedra of order 2": ("hexahedron", 2),
}


def cases(*, quick: bool) -> list[Case]:
    """All cells of both sweeps."""
    slender = (20,) if quick else _SLENDER
    found = []
    for ratio in slender:
        for solver in ("cholesky", "pcg-jacobi", "pcg-amg"):
            compute = partial(deflection, ratio, solver)
            found.append(_case(f"linear statics, {solver}", ratio, compute))
        for model in ("St. Venant-Kirchhoff", "corotational", "neo-Hookean")[: 1 if quick else 3]:
            found.append(_case(f"elastica, {model}", ratio, partial(elastica, ratio, model)))
        found.append(_case("lowest frequency", ratio, partial(frequency, ratio)))
        found.append(_case("Newmark, first mode", ratio, partial(first_mode, ratio)))
    ratios = _RATIOS[::5] if quick else _RATIOS
    found += [
        Case(
            sweep=LOCKING_TITLE,
            row=element,
            column=f"{poisson:g}",
            compute=partial(locking, element, poisson),
        )
        for element in (list(_ELEMENTS)[2:3] if quick else _ELEMENTS)
        for poisson in ratios
    ]
    return found


def _case(row: str, ratio: int, compute: partial) -> Case:
    return Case(sweep=SLENDER_TITLE, row=row, column=f"1:{ratio}", compute=compute)


@lru_cache(maxsize=2)
def beam(ratio: int, model: str) -> fem.Solid:
    """A cantilever 1 m long of twenty quadratic hexahedra, of a square section."""
    thick = 1.0 / ratio
    law = material(model, poisson=0.0)
    mesh = box((20, 1, 1), (1.0, thick, thick))
    return fem.Solid(mesh, law, order=2, fixed=["x<1e-9"])


def _section(ratio: int) -> beams.RectangularSection:
    return beams.RectangularSection(width=1.0 / ratio, height=1.0 / ratio)


def _pull(ratio: int, force: float) -> analysis.Traction:
    return analysis.Traction("x>0.999999999", (0.0, 0.0, force * ratio**2))


def _tip(solid: fem.Solid, displacement: np.ndarray) -> np.ndarray:
    return displacement[solid.points[:, 0] > 1.0 - 1e-9].mean(axis=0)


def deflection(ratio: int, solver: str) -> Measured:
    """Small deflection against Timoshenko's; without Poisson's ratio the clamp disturbs nothing."""
    solid = beam(ratio, "linear")
    force = 1e-3 * YOUNG / (4.0 * ratio**4)
    # Conjugate gradients that fail at one part of the load fail at each: one half will do.
    found = analysis.static_equilibrium(solid, [_pull(ratio, force)], linear=solver, max_halvings=1)
    exact = beams.cantilever_tip(
        length=1.0, section=_section(ratio), young=YOUNG, poisson=0.0, force=force
    )
    return Measured(error=abs(_tip(solid, found.displacement)[2] / exact.deflection - 1.0))


def elastica(ratio: int, model: str) -> Measured:
    """A tip force that bends the beam by more than half its length, in eight parts."""
    solid = beam(ratio, model)
    force = 4.0 * YOUNG / (12.0 * ratio**4)
    found = analysis.static_equilibrium(solid, [_pull(ratio, force)], load_steps=8)
    exact = beams.elastica_end_force(length=1.0, section=_section(ratio), young=YOUNG, force=force)
    x, _, z = _tip(solid, found.displacement)
    return Measured(
        error=float(np.hypot(1.0 + x - exact.x, z - exact.y)),
        note=f"{found.iterations} iterations in {len(found.load_factors)} parts",
    )


def frequency(ratio: int) -> Measured:
    """The package's lowest mode against Euler and Bernoulli's."""
    found = analysis.linear_modes(beam(ratio, "St. Venant-Kirchhoff"), 2, verify=False)
    return Measured(error=abs(float(found.frequencies[0]) / _frequency(ratio) - 1.0))


def _frequency(ratio: int) -> float:
    return float(
        beams.cantilever_frequencies(
            length=1.0, section=_section(ratio), young=YOUNG, poisson=0.0, density=DENSITY, count=1
        )[0]
    )


def _shape(solid: fem.Solid) -> np.ndarray:
    """The lowest mode across z (n, 3), of unit size, by SciPy's Lanczos method."""
    free = np.flatnonzero(~solid.held.ravel())
    stiffness, mass = (m[free][:, free].tocsc() for m in (solid.tangent(), solid.mass()))
    start = np.ones(len(free))
    _, vectors = eigsh(stiffness, 2, mass, sigma=0.0, v0=start)
    shapes = np.zeros((2, solid.held.size))
    shapes[:, free] = vectors.T
    shapes = shapes.reshape(2, -1, 3)
    shape = np.einsum("k,kni->ni", shapes[:, :, 2].mean(axis=1), shapes)
    return np.asarray(shape / np.abs(shape).max())


def first_mode(ratio: int) -> Measured:
    """A quarter period of Euler and Bernoulli's first mode in 25 steps, given as a velocity."""
    solid = beam(ratio, "St. Venant-Kirchhoff")
    shape = 1e-4 / ratio * _shape(solid)
    omega = 2.0 * np.pi * _frequency(ratio)
    path = free_motion(
        solid,
        METHODS["Newmark, converged"],
        step=0.5 * np.pi / omega / 25,
        count=25,
        velocity=omega * shape,
    )
    exact = np.sin(omega * path.times)[:, None, None] * shape
    error = float(np.abs(path.displacement - exact).max() / np.abs(shape).max())
    return Measured(error=error, growth=path.growth)


def locking(element: str, poisson: float) -> Measured:
    """Tip of a stocky cantilever against quadratic hexahedra of half the size."""
    kind, order = _ELEMENTS[element]
    found = _sag(kind, order, poisson, (6, 2, 2))
    exact = _sag("hexahedron", 2, poisson, (12, 4, 4))
    return Measured(error=abs(found / exact - 1.0), note="against a finer mesh of order 2")


@lru_cache(maxsize=16)
def _sag(kind: str, order: int, poisson: float, cells: tuple[int, int, int]) -> float:
    solid = fem.Solid(
        box(cells, (3.0, 1.0, 1.0), kind=kind),
        material("linear", poisson=poisson),
        order=order,
        fixed=["x<1e-6"],
    )
    load = analysis.Traction("x>2.999999", (0.0, 0.0, 1e-4 * YOUNG))
    displacement = analysis.static_equilibrium(solid, [load]).displacement
    end = solid.points[:, 0] > 3.0 - 1e-6
    return float(displacement[end, 2].mean())
