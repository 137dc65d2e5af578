"""A block under uniaxial tension: one homogeneous strain, whose closed form each law has.

Young's modulus, the body's size, Poisson's ratio and bad cells change nothing of it but round-off.
"""

from functools import partial

from fenics_defo import analysis, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np
from scipy.optimize import root

from workflows.stability_map.bodies import (
    DENSITY,
    FEW,
    MODELS,
    POISSON,
    YOUNG,
    Array,
    box,
    material,
    principal_stress,
)
from workflows.stability_map.cases import Case
from workflows.stability_map.methods import METHODS, free_motion
from workflows.stability_map.outcomes import Measured
from workflows.stability_map.references import spectrum

# Traction in units of Young's modulus.
_LOAD = 0.05
_SOLVERS = ("cholesky", "pcg-jacobi", "pcg-amg")
_MODULI = tuple(10.0**power for power in range(14))
_SIZES = tuple(10.0**power for power in range(-6, 5))
_RATIOS = (0.0, 0.3, 0.45, 0.49, 0.499, 0.4999, 0.5)
#: Heights of the flattest cells, of a cube of 1 m.
SLIVERS = (1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)

YOUNG_TITLE, SIZE_TITLE = "Young's modulus [Pa]", "Size of the body [m]"
POISSON_TITLE, SLIVER_TITLE = "Poisson's ratio, uniaxial tension", "Height of slivers"


def cases(*, quick: bool) -> list[Case]:
    """All cells of the four sweeps."""
    models = FEW if quick else tuple(MODELS)
    thin = slice(None, None, 6 if quick else 1)
    found = []
    for young in _MODULI[thin]:
        found += _rows(models, YOUNG_TITLE, f"{young:.0e}", quick, young=young)
    for size in _SIZES[thin]:
        found += _rows(models, SIZE_TITLE, f"{size:.0e}", quick, size=size)
    for poisson in _RATIOS[thin]:
        found += [
            _case(POISSON_TITLE, model, f"{poisson:g}", partial(tension, model, poisson=poisson))
            for model in models
            # Springs have no Poisson's ratio to choose, and these two laws take a bulk modulus
            # or the user's own constants instead, which are infinite there.
            if model != "mass-spring"
            and not (poisson == 0.5 and model in ("Mooney-Rivlin", "user's energy"))
        ]
    for height in SLIVERS[thin]:
        found += [
            _case(SLIVER_TITLE, model, f"{height:.0e}", partial(tension, model, sliver=height))
            for model in models
        ]
        for name in ("Newmark, converged", "central differences"):
            compute = partial(vibration, "St. Venant-Kirchhoff", name, sliver=height)
            found.append(_case(SLIVER_TITLE, f"{name}, fixed step", f"{height:.0e}", compute))
    return found


def _rows(
    models: tuple[str, ...], title: str, column: str, quick: bool, **changed: float
) -> list[Case]:
    found = [_case(title, model, column, partial(tension, model, **changed)) for model in models]
    for solver in _SOLVERS[1:] if not quick else ():
        compute = partial(tension, "neo-Hookean", solver=solver, **changed)
        found.append(_case(title, f"neo-Hookean, {solver}", column, compute))
    for name in ("Newmark, converged", "central differences")[1 if quick else 0 :]:
        compute = partial(vibration, "St. Venant-Kirchhoff", name, **changed)
        found.append(_case(title, f"{name}, step in periods", column, compute))
    return found


def _case(sweep: str, row: str, column: str, compute: partial) -> Case:
    return Case(sweep=sweep, row=row, column=column, compute=compute)


def block(size: float, sliver: float | None) -> fem.ImportedMesh:
    """A cube of hexahedra, or of twelve tetrahedra about an inner node that lies near a face."""
    if sliver is None:
        return box((2, 1, 1), (size, size, size))
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    centre = np.array([[0.45, 0.55, sliver]])
    squares = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    triangles = [(a, b, c) for a, b, c, _ in squares] + [(a, c, d) for a, _, c, d in squares]
    cells = np.array([(a, c, b, 8) for a, b, c in triangles])
    return fem.build_mesh(size * np.concatenate([corners, centre]), cells)


def body(
    model: str, *, young: float, size: float, poisson: float, sliver: float | None
) -> fem.Solid:
    """That cube between three planes of symmetry."""
    tiny = 1e-6 * size
    planes = [fem.Fixed(f"{axis}<{tiny!r}", axis) for axis in "xyz"]
    law = material(model, young=young, poisson=poisson)
    return fem.Solid(block(size, sliver), law, fixed=planes)


def stretches(model: str, load: float, *, young: float, poisson: float) -> Array:
    """Stretches (along, across) in uniaxial stress ``load`` [Pa], by the laws' closed forms."""

    def imbalance(pair: Array) -> Array:
        s = np.array([pair[0], pair[1], pair[1]])
        stress = principal_stress(model, s, young=young, poisson=poisson)
        return np.array([stress[0] - load, stress[1]]) / young

    found = root(imbalance, [1.0 + load / young, 1.0 - poisson * load / young], tol=1e-14)
    assert np.abs(imbalance(found.x)).max() < 1e-12, found.message
    return np.asarray(found.x)


def tension(
    model: str,
    *,
    young: float = YOUNG,
    size: float = 1.0,
    poisson: float = POISSON,
    sliver: float | None = None,
    solver: str = "cholesky",
) -> Measured:
    """Statics: largest error of the displacement over its largest."""
    solid = body(model, young=young, size=size, poisson=poisson, sliver=sliver)
    far = f"x>{(1 - 1e-6) * size!r}"
    load = analysis.Traction(far, (_LOAD * young, 0.0, 0.0))
    found = analysis.static_equilibrium(solid, [load], linear=solver).displacement
    if model == "mass-spring":
        exact = _springs(size, sliver)
    else:
        along, across = stretches(model, _LOAD * young, young=young, poisson=poisson)
        exact = solid.points * (np.array([along, across, across]) - 1.0)
    return exactly(found, exact)


def _springs(size: float, sliver: float | None) -> Array:
    """A network has no closed form here: the same body of 1 m and E = 1 Pa, by SciPy's root."""
    solid = body("mass-spring", young=1.0, size=1.0, poisson=POISSON, sliver=sliver)
    free = ~solid.held
    pulled = np.zeros_like(solid.points)
    # Of a unit square of one hexahedron, or of two triangles, whose diagonal is 1-7.
    far = np.flatnonzero(solid.points[:, 0] > 1.0 - 1e-6)
    share = 0.25 if sliver is None else None
    for node in far:
        on_diagonal = np.isclose(solid.points[node, 1], solid.points[node, 2])
        pulled[node, 0] = _LOAD * (share or (1.0 / 3.0 if on_diagonal else 1.0 / 6.0))

    def imbalance(values: Array) -> Array:
        u = np.zeros_like(solid.points)
        u[free] = values
        return (solid.internal_force(u) - pulled)[free]

    found = root(imbalance, np.zeros(int(free.sum())), tol=1e-13)
    assert np.abs(imbalance(found.x)).max() < 1e-10, found.message
    exact = np.zeros_like(solid.points)
    exact[free] = found.x
    return size * exact


def exactly(found: Array, exact: Array) -> Measured:
    """A result that only round-off may keep from its reference."""
    error = float(np.abs(found - exact).max() / np.abs(exact).max())
    return Measured(error=error, theory=0.0 if error <= 1e-4 else error)


def vibration(
    model: str,
    name: str,
    *,
    young: float = YOUNG,
    size: float = 1.0,
    poisson: float = POISSON,
    sliver: float | None = None,
) -> Measured:
    """Dynamics: a quarter period of the first mode, small, against the body's exact motion.

    The step is a hundredth of the period, or with slivers that of the cube without them, which
    explicit methods must refuse where the slivers do not stand it.
    """
    method = METHODS[name]
    solid = body(model, young=young, size=size, poisson=poisson, sliver=sliver)
    modes = spectrum(solid, lumped=method.integrator.explicit)
    omega, amplitude = modes.omega[0], 1e-4 * size
    step = 0.02 * np.pi / omega
    if sliver is not None:
        step = 0.1 * size * np.sqrt(DENSITY / young)
    count = max(round(0.5 * np.pi / (omega * step)), 2)
    path = free_motion(
        solid, method, step=step, count=count, velocity=amplitude * omega * modes.shapes[0]
    )
    exact = amplitude * np.sin(omega * path.times)[:, None, None] * modes.shapes[0]
    error = float(np.abs(path.displacement - exact).max()) / amplitude
    return Measured(error=error, growth=path.growth, note=f"energy changes by {path.drift:.1e}")
