"""Materials over the cells of a mesh."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
import ufl
from numpy.typing import NDArray

from fenics_defo.energy import (
    HyperelasticEnergy,
    LinearElastic,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.errors import MaterialError, SelectionError
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.material_fields import Materials, lay_materials
from tests.unit.fem.fem_bodies import SIDES, mesh_of, source, usual_groups

Array = NDArray[np.float64]

BASE = {"young": 1e6, "poisson": 0.3, "density": 1e3}
MESH = source("tetrahedron", groups=usual_groups("tetrahedron"))
MIDDLES = MESH.points[MESH.cells].mean(axis=1)[:, 0]


def neo(**changes: object) -> NeoHookean:
    return NeoHookean(**(BASE | changes))


def by_cell(function: "dolfinx.fem.Function") -> Array:
    """Values of a cell-wise function in the order of the file."""
    space = function.function_space
    values = np.empty(len(MESH.cells))
    original = space.mesh.topology.original_cell_index
    values[original] = function.x.array[space.dofmap.list[:, 0]]
    return values


def density(materials: Materials) -> Array:
    return by_cell(lay_materials(mesh_of(MESH), materials).density)


def test_one_material_covers_all() -> None:
    fields = lay_materials(mesh_of(MESH), neo())
    (region,) = fields.regions
    np.testing.assert_array_equal(by_cell(fields.density), 1e3)
    for name, value in neo().parameters.items():
        np.testing.assert_array_equal(by_cell(region.parameters[name]), value)


LEFT, RIGHT = SIDES[0] / 3.0 > MIDDLES, SIDES[0] / 3.0 < MIDDLES
MIDDLE = RIGHT & (2.0 * SIDES[0] / 3.0 > MIDDLES)


@pytest.mark.parametrize(("left", "right"), [("left", "right"), (1, 2), ("1", "x>=2/3"), (1, None)])
def test_regions_by_name_number_and_comparison(left: str | int, right: str | int | None) -> None:
    found = density({left: neo(density=1.0), right: neo(density=2.0)})
    np.testing.assert_array_equal(found, np.where(LEFT, 1.0, 2.0))


def test_of_overlapping_regions_the_later_holds() -> None:
    right, middle = {"right": neo(density=2.0)}, {"middle": neo(density=3.0)}
    left = {"left": neo(density=1.0)}
    found = density(left | right | middle)
    np.testing.assert_array_equal(found, np.select([LEFT, MIDDLE], [1.0, 3.0], 2.0))
    np.testing.assert_array_equal(density(left | middle | right), np.where(LEFT, 1.0, 2.0))


@pytest.mark.parametrize("order", [1, -1])
def test_the_material_of_all_others_may_stand_anywhere(order: int) -> None:
    items = [("left", neo(density=1.0)), (None, neo(density=9.0))][::order]
    np.testing.assert_array_equal(density(dict(items)), np.where(LEFT, 1.0, 9.0))


def test_a_cell_field_follows_the_files_cells() -> None:
    young = 1e6 + np.arange(len(MESH.cells))
    material = neo(young=young, density=young / 1e3)
    fields = lay_materials(mesh_of(MESH), {None: neo(), "left": material})
    np.testing.assert_array_equal(by_cell(fields.density), np.where(LEFT, young / 1e3, 1e3))
    mu = by_cell(fields.regions[0].parameters["mu"])
    np.testing.assert_allclose(mu, np.where(LEFT, young, 1e6) / 2.6, rtol=1e-14)


def test_one_law_is_one_region_and_two_are_two() -> None:
    """Different numbers share a form; different functions do not."""
    same = lay_materials(mesh_of(MESH), {"left": neo(), "right": neo(young=2e6)})
    assert len(same.regions) == 1
    fields = lay_materials(mesh_of(MESH), {"left": neo(), "right": StVenantKirchhoff(**BASE)})
    assert len(fields.regions) == 2
    cells = np.sort(np.concatenate([region.cells for region in fields.regions]))
    np.testing.assert_array_equal(cells, np.arange(len(MESH.cells)))


def test_a_law_covered_by_another_is_dropped() -> None:
    materials = {None: StVenantKirchhoff(**BASE), "left": neo(), "right": neo()}
    (region,) = lay_materials(mesh_of(MESH), materials).regions
    assert region.material == neo()


@dataclass(frozen=True)
class Fibres:
    """A user's own record: its direction is no parameter."""

    direction: tuple[float, float, float]
    density: float = 1.0

    @property
    def parameters(self) -> dict[str, float]:
        return {"stiffness": 1e6}

    def strain_energy(self, F: ufl.core.expr.Expr, parameters: dict) -> ufl.core.expr.Expr:
        stretch = F * ufl.as_vector(self.direction)
        return parameters["stiffness"] * (ufl.dot(stretch, stretch) - 1) ** 2

    def linearised(self) -> tuple[float, float]:
        raise MaterialError("fibres are not isotropic")


def test_a_users_records_of_one_class_may_differ_in_their_law() -> None:
    x, y = Fibres((1.0, 0.0, 0.0)), Fibres((0.0, 1.0, 0.0))
    fields = lay_materials(mesh_of(MESH), {"left": x, "right": y})
    assert len(fields.regions) == 2
    assert all(region.rest_moduli is None for region in fields.regions)
    alike = lay_materials(mesh_of(MESH), {"left": x, "right": Fibres((1.0, 0.0, 0.0))})
    assert len(alike.regions) == 1


def user_energy(factor: float) -> HyperelasticEnergy:
    def stored(F: ufl.core.expr.Expr, constants: dict) -> ufl.core.expr.Expr:
        E = (F.T * F - ufl.Identity(3)) / 2
        return factor * constants["mu"] * ufl.inner(E, E)

    return HyperelasticEnergy(stored, {"mu": 1e5}, density=1.0)


def test_numbers_inside_a_users_function_are_part_of_the_law() -> None:
    laws = {"left": user_energy(1.0), "right": user_energy(2.0), "middle": user_energy(1.0)}
    assert len(lay_materials(mesh_of(MESH), laws).regions) == 2


@pytest.mark.parametrize(
    "material",
    [
        *(LinearElastic(**BASE), StVenantKirchhoff(**BASE), neo(poisson=-0.4)),
        MooneyRivlin(c10=1e5, c01=3e4, bulk=2e6, density=1e3),
    ],
)
def test_rest_moduli_are_those_of_small_strains(material: object) -> None:
    fields = lay_materials(mesh_of(MESH), material)
    moduli = fields.regions[0].rest_moduli
    assert moduli is not None
    lmbda, mu = (by_cell(f)[0] for f in moduli)
    young, poisson = material.linearised()
    assert mu == pytest.approx(young / (2 * (1 + poisson)), rel=1e-13)
    assert lmbda + 2 / 3 * mu == pytest.approx(young / (3 * (1 - 2 * poisson)), rel=1e-13)


@pytest.mark.parametrize("given", [{}, "rubber", None, 3.0, {"left": "rubber"}, {None: 1e6}])
def test_what_is_no_material_is_refused(given: object) -> None:
    with pytest.raises(MaterialError, match="material"):
        lay_materials(mesh_of(MESH), given)


def test_cells_without_material_are_counted() -> None:
    missing = int(RIGHT.sum())
    with pytest.raises(MaterialError, match=rf"{missing} of 36 cells .*'right' \(2, 24 volumes\)"):
        lay_materials(mesh_of(MESH), {"left": neo()})


def test_a_cell_field_of_another_mesh_is_refused() -> None:
    with pytest.raises(MaterialError, match=r"5 values.*36 cells"):
        lay_materials(mesh_of(MESH), neo(young=np.full(5, 1e6)))


@pytest.mark.parametrize("region", ["steel", 77, "root", "x>9"])
def test_a_region_that_is_not_there_is_refused(region: str | int) -> None:
    with pytest.raises(SelectionError, match=rf"{region}.*'left' \(1, 12 volumes\)"):
        lay_materials(mesh_of(MESH), {None: neo(), region: neo()})


def test_layers_of_many_regions_keep_their_order() -> None:
    bounds = np.linspace(0.0, SIDES[0], 6)
    layers = {f"x > {low}": neo(density=1.0 + i) for i, (low, _) in enumerate(pairwise(bounds))}
    wanted = 1.0 + np.searchsorted(bounds[1:-1], MIDDLES)
    np.testing.assert_array_equal(density(layers), wanted)
