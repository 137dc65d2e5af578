"""A small bent body of any law, and shapes to reduce it by."""

import numpy as np
import ufl

from fenics_defo import energy
from fenics_defo.fem import Solid
from tests.unit.fem.fem_bodies import bent, mesh_of, source

HOOKE = {"young": 1.0e5, "poisson": 0.3, "density": 1.0e3}


def fibre(F, c):
    """A neo-Hookean solid with fibres along x."""
    C, J = F.T * F, ufl.det(F)
    matrix = c["mu"] / 2 * (ufl.tr(C) - 3) - c["mu"] * ufl.ln(J) + c["mu"] * ufl.ln(J) ** 2
    return matrix + c["fibre"] / 4 * (C[0, 0] - 1) ** 2


def yeoh(I1, I2, J, c):
    """Yeoh's law in the first modified invariant."""
    x = J ** (-2.0 / 3.0) * I1 - 3
    return c["c1"] * x + c["c2"] * x**2 + c["c3"] * x**3 + c["bulk"] / 2 * ufl.ln(J) ** 2


LAWS = {
    "linear": energy.LinearElastic(**HOOKE),
    "st-venant-kirchhoff": energy.StVenantKirchhoff(**HOOKE),
    "neo-hookean": energy.NeoHookean(**HOOKE),
    "mooney-rivlin": energy.MooneyRivlin(c10=1.5e4, c01=5e3, bulk=9e4, density=1.0e3),
    "yeoh": energy.IsotropicEnergy(
        yeoh, {"c1": 2e4, "c2": 2e3, "c3": 5e2, "bulk": 9e4}, density=1e3
    ),
    "fibre": energy.HyperelasticEnergy(fibre, {"mu": 4e4, "fibre": 6e4}, density=1.0e3),
    "corotational": energy.Corotational(**HOOKE),
    "invertible": energy.Invertible(energy.NeoHookean(**HOOKE), tangent="exact"),
}
TWO = {None: LAWS["neo-hookean"], "x>0.6": energy.Corotational(young=1e6, poisson=0.4, density=2e3)}


def body(law="neo-hookean", *, kind="tetrahedron", order=1, cells=(5, 2, 2), **options):
    """A sector of a ring, held at one end."""
    mesh = mesh_of(source(kind, cells=cells, order=1, mapping=bent))
    material = LAWS[law] if isinstance(law, str) else law
    return Solid(mesh, material, order=order, fixed=["x<1e-9"], **options)


def shapes_of(solid, count):
    """Smooth shapes (count, n, 3), zero at the support."""
    x, y, z = solid.points.T
    fields = []
    for number in range(count):
        wave = np.sin((number // 3 + 1) * x) * x * (1.0 + y - 0.5 * z)
        fields.append(np.outer(wave, np.roll([1.0, -0.3, 0.2], number)))
    fields = np.array(fields)
    return fields / np.abs(fields).max(axis=(1, 2), keepdims=True)
