"""States about which there are no modes, or few, are told by what is wrong with them."""

import numpy as np
import pytest
import ufl

from fenics_defo.analysis import linear_modes
from fenics_defo.energy import HyperelasticEnergy, StVenantKirchhoff
from fenics_defo.errors import DefoError, EigenSolveError, MeshError
from fenics_defo.fem import Solid, build_mesh

CORNERS = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
SOFT = StVenantKirchhoff(young=1e6, poisson=0.3, density=1000.0)


def cube(material: object = SOFT, **options: object) -> Solid:
    """One hexahedron."""
    return Solid(
        build_mesh(CORNERS, [[0, 1, 3, 2, 4, 5, 7, 6]], kind="hexahedron"), material, **options
    )


def own_energy(scale: float, *, balanced: bool) -> HyperelasticEnergy:
    """μ/2 (I1 - 3 - 2 ln J), without its last term if not balanced."""

    def energy(F: ufl.core.expr.Expr, constants: object) -> ufl.core.expr.Expr:
        strained = ufl.tr(F.T * F) - 3
        return 0.5 * scale * (strained - 2 * ufl.ln(ufl.det(F)) if balanced else strained)

    return HyperelasticEnergy(energy, {}, density=1.0)


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
def test_an_energy_stressed_at_rest_is_refused(fixed: list[str]) -> None:
    with pytest.raises(EigenSolveError, match=r"not an equilibrium.*add a term"):
        linear_modes(cube(own_energy(1e6, balanced=False), fixed=fixed), 3)


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
def test_an_energy_unstable_at_rest_is_refused(fixed: list[str]) -> None:
    with pytest.raises(EigenSolveError, match="not a stable state"):
        linear_modes(cube(own_energy(-1e6, balanced=True), fixed=fixed), 3)


def test_an_own_energy_has_its_modes() -> None:
    modes = linear_modes(cube(own_energy(1e6, balanced=True)), 7)
    assert modes.rigid_modes == 6
    assert modes.frequencies[6] > 0.0


@pytest.mark.parametrize("count", [17, 18, 19, 22, 23, 24])
def test_nearly_all_modes_of_one_cell(count: int) -> None:
    """A cube's eigenvalues are multiple: the space is exhausted before the tolerance is met."""
    modes = linear_modes(cube(), count)
    assert count <= modes.size <= 24
    assert modes.complete


def test_nothing_left_to_move() -> None:
    with pytest.raises(DefoError, match="nothing is left free to move"):
        linear_modes(cube(fixed=["x<2"]), 1)


def test_a_path_is_no_mesh() -> None:
    with pytest.raises(MeshError, match="read_mesh"):
        Solid("beam.msh", SOFT)  # type: ignore[arg-type]
