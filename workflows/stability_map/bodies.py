"""Small bodies and the laws that are tried on them."""

from collections.abc import Callable, Mapping

from fenics_defo import energy, fem  # DOLFINx before anything of PETSc

# isort: split
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

YOUNG, POISSON, DENSITY = 1e5, 0.3, 1000.0

# Corners of a hexahedron in VTK's order, and six tetrahedra along its diagonal 0-6.
_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_TETRAHEDRA = (
    (0, 1, 2, 6),
    (0, 2, 3, 6),
    (0, 3, 7, 6),
    (0, 7, 4, 6),
    (0, 4, 5, 6),
    (0, 5, 1, 6),
)


def box(
    cells: tuple[int, int, int], size: tuple[float, float, float], *, kind: str = "hexahedron"
) -> fem.ImportedMesh:
    """A box from the origin, of hexahedra or of six tetrahedra each."""
    axes = [np.linspace(0.0, s, n + 1) for n, s in zip(cells, size, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([n + 1 for n in cells])
    nx, ny, nz = cells
    corners = [number[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in _CORNERS]
    hexahedra = np.column_stack(corners)
    if kind == "tetrahedron":
        return fem.build_mesh(points, hexahedra[:, np.array(_TETRAHEDRA)].reshape(-1, 4))
    return fem.build_mesh(points, hexahedra, kind=kind)


def lame(young: float, poisson: float) -> tuple[float, float]:
    """Lamé's constants mu and lambda [Pa]."""
    mu = young / (2.0 * (1.0 + poisson))
    return mu, 2.0 * mu * poisson / (1.0 - 2.0 * poisson)


def _mooney_rivlin(*, young: float, poisson: float, density: float) -> energy.MooneyRivlin:
    mu, lmbda = lame(young, poisson)
    return energy.MooneyRivlin(
        c10=0.3 * mu, c01=0.2 * mu, bulk=lmbda + 2.0 * mu / 3.0, density=density
    )


def _ciarlet(I1: object, I2: object, J: object, constants: Mapping[str, object]) -> object:
    """ψ = μ/2 (I1 − 3 − 2 ln J) + λ/4 (J² − 1 − 2 ln J), as a user writes it."""
    ln = energy.materials.ufl.ln(J)
    mu, lmbda = constants["mu"], constants["lmbda"]
    return mu / 2 * (I1 - 3 - 2 * ln) + lmbda / 4 * (J**2 - 1 - 2 * ln)


def _user(*, young: float, poisson: float, density: float) -> energy.IsotropicEnergy:
    mu, lmbda = lame(young, poisson)
    return energy.IsotropicEnergy(_ciarlet, {"mu": mu, "lmbda": lmbda}, density=density)


def _springs(*, young: float, poisson: float, density: float) -> energy.MassSpring:
    return energy.MassSpring(young=young, density=density)


def _approximate(**constants: float) -> energy.Corotational:
    return energy.Corotational(**constants, tangent="approximate")


def _invertible_stvk(**constants: float) -> energy.Invertible:
    return energy.Invertible(energy.StVenantKirchhoff(**constants))


def _invertible_nh(**constants: float) -> energy.Invertible:
    return energy.Invertible(energy.NeoHookean(**constants))


#: Name -> material of young, poisson and density.
MODELS: dict[str, Callable[..., energy.Material]] = {
    "linear": energy.LinearElastic,
    "corotational": energy.Corotational,
    "corotational, approximate": _approximate,
    "St. Venant-Kirchhoff": energy.StVenantKirchhoff,
    "neo-Hookean": energy.NeoHookean,
    "Mooney-Rivlin": _mooney_rivlin,
    "user's energy": _user,
    "invertible StVK": _invertible_stvk,
    "invertible neo-Hookean": _invertible_nh,
    "mass-spring": _springs,
}

#: Those of a quick map.
FEW = ("linear", "corotational", "St. Venant-Kirchhoff")


def material(
    model: str, *, young: float = YOUNG, poisson: float = POISSON, density: float = DENSITY
) -> energy.Material:
    """A law by name."""
    return MODELS[model](young=young, poisson=poisson, density=density)


def principal_energy(model: str, s: Array, *, young: float, poisson: float) -> complex:
    """ψ of principal stretches s (3,), written independently of the package; complex for slopes.

    Raises:
        KeyError: the model has no such energy.
    """
    mu, lmbda = lame(young, poisson)
    name = {
        "corotational, approximate": "corotational",
        "invertible StVK": "St. Venant-Kirchhoff",
        "invertible neo-Hookean": "neo-Hookean",
    }.get(model, model)
    I1, J = (s**2).sum(), s.prod()
    if name in ("linear", "corotational"):
        return mu * ((s - 1) ** 2).sum() + lmbda / 2 * (s - 1).sum() ** 2
    if name == "St. Venant-Kirchhoff":
        green = (s**2 - 1) / 2
        return mu * (green**2).sum() + lmbda / 2 * green.sum() ** 2
    if name == "neo-Hookean":
        return mu / 2 * (I1 - 3) - mu * np.log(J) + lmbda / 2 * np.log(J) ** 2
    if name == "user's energy":
        return mu / 2 * (I1 - 3 - 2 * np.log(J)) + lmbda / 4 * (J**2 - 1 - 2 * np.log(J))
    if name == "Mooney-Rivlin":
        I2 = (I1**2 - (s**4).sum()) / 2
        bulk = lmbda + 2 * mu / 3
        deviator = 0.3 * mu * (J ** (-2 / 3) * I1 - 3) + 0.2 * mu * (J ** (-4 / 3) * I2 - 3)
        return deviator + bulk / 2 * (J - 1) ** 2
    raise KeyError(model)


def principal_stress(model: str, s: Array, *, young: float, poisson: float) -> Array:
    """dψ/ds (3,) [Pa] by complex steps, exact to round-off."""
    steps = s + 1e-30j * np.eye(3)
    energies = [principal_energy(model, row, young=young, poisson=poisson) for row in steps]
    return np.imag(energies) / 1e-30
