"""Materials and random deformations shared by the tests of the energies."""

from collections.abc import Callable

import numpy as np
import ufl
from numpy.typing import NDArray

from fenics_defo import energy
from fenics_defo.energy import evaluate

type Array = NDArray[np.float64]

YOUNG, POISSON, DENSITY = 2.0, 0.3, 5.0
MU, LMBDA = YOUNG / 2.6, YOUNG * 0.3 / (1.3 * 0.4)


def fibre_energy(F, constants):
    """A neo-Hookean solid with a fibre along x: objective, not isotropic."""
    C = F.T * F
    J = ufl.det(F)
    mu = constants["mu"]
    matrix = mu / 2 * (ufl.tr(C) - 3) - mu * ufl.ln(J) + mu * ufl.ln(J) ** 2
    return matrix + constants["fibre"] / 4 * (C[0, 0] - 1) ** 2


def yeoh_energy(I1, I2, J, constants):
    """Yeoh's cubic in the first modified invariant, with a volumetric penalty."""
    x = J ** (-2.0 / 3.0) * I1 - 3
    return (constants["c1"] * x + constants["c2"] * x**2 + constants["c3"] * x**3) + constants[
        "bulk"
    ] / 2 * ufl.ln(J) ** 2


LINEAR = energy.LinearElastic(young=YOUNG, poisson=POISSON, density=DENSITY)
STVK = energy.StVenantKirchhoff(young=YOUNG, poisson=POISSON, density=DENSITY)
NEO_HOOKEAN = energy.NeoHookean(young=YOUNG, poisson=POISSON, density=DENSITY)
# The same two moduli at rest: mu = 2 (c10 + c01) and bulk = lmbda + 2/3 mu.
MOONEY_RIVLIN = energy.MooneyRivlin(
    c10=0.3 * MU, c01=0.2 * MU, bulk=LMBDA + 2 / 3 * MU, density=DENSITY
)
YEOH = energy.IsotropicEnergy(
    yeoh_energy,
    {"c1": 0.5 * MU, "c2": 0.1, "c3": 0.02, "bulk": LMBDA + 2 / 3 * MU},
    density=DENSITY,
)
FIBRE = energy.HyperelasticEnergy(fibre_energy, {"mu": 1.5, "fibre": 2.5}, density=DENSITY)

ISOTROPIC = [STVK, NEO_HOOKEAN, MOONEY_RIVLIN, YEOH]
OBJECTIVE = [*ISOTROPIC, FIBRE]
ALL = [LINEAR, *OBJECTIVE]


def name(material: object) -> str:
    if isinstance(material, energy.IsotropicEnergy | energy.HyperelasticEnergy):
        return material.function.__name__
    return type(material).__name__


def _evaluate(build: Callable, material, F: Array) -> Array:
    gradient = ufl.variable(ufl.Identity(3))
    symbols = {key: ufl.variable(ufl.as_ufl(0.0)) for key in material.parameters}
    values = {symbols[key]: value for key, value in material.parameters.items()}
    return evaluate(build(gradient, symbols), {gradient: F, **values})


def psi(material, F: Array) -> Array:
    """Strain energies at the deformation gradients F (b, 3, 3)."""
    return _evaluate(material.strain_energy, material, F)


def piola(material, F: Array) -> Array:
    """First Piola-Kirchhoff stresses (b, 3, 3)."""
    return _evaluate(lambda G, p: energy.first_piola(material, G, parameters=p), material, F)


def tangents(material, F: Array) -> Array:
    """Elasticity tensors (b, 3, 3, 3, 3)."""
    return _evaluate(lambda G, p: energy.tangent(material, G, parameters=p), material, F)


def deformations(count: int, seed: int = 0, size: float = 0.25) -> Array:
    """Random F (count, 3, 3), none inverted."""
    F = np.eye(3) + size * np.random.default_rng(seed).uniform(-1, 1, (count, 3, 3))
    assert np.linalg.det(F).min() > 0.1
    return F


def rotations(count: int, seed: int = 1) -> Array:
    """Random proper rotations (count, 3, 3)."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(count, 3, 3)))
    return Q * np.sign(np.linalg.det(Q))[:, None, None]
