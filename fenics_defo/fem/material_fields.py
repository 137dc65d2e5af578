"""The user's materials laid over the cells of a mesh as cell-wise constant functions."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.energy import MassSpring, Material, PointLaw, formula
from fenics_defo.errors import MaterialError
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.imported import MeshData, mesh_record
from fenics_defo.fem.input_order import cell_rows
from fenics_defo.fem.regions import describe_groups, select_entities

type Law = Material | PointLaw | MassSpring
type Materials = Law | Mapping[str | int | None, Law]
_LAWS = (Material, PointLaw, MassSpring)


@dataclass(frozen=True, slots=True)
class LawRegion:
    """The cells that share one law, with its constants as functions.

    Args:
        material: any of the law's materials: what is asked of it is the form of its energy, or
            what it answers at points.
        cells: (k,) this rank's cells, ghosts included.
        parameters: cell-wise constant function of each of the law's parameters.
        rest_moduli: cell-wise (λ, μ) [Pa] of small strains about rest; None where the law is not
            isotropic and free of stress there.
    """

    material: Law
    cells: NDArray[np.int32]
    parameters: "Mapping[str, dolfinx.fem.Function]"
    rest_moduli: "tuple[dolfinx.fem.Function, dolfinx.fem.Function] | None"


@dataclass(frozen=True, slots=True)
class MaterialFields:
    """All laws of a body and its density.

    Args:
        regions: one entry a law; their cells do not overlap and cover the mesh.
        density: cell-wise constant ρ [kg/m³].
    """

    regions: tuple[LawRegion, ...]
    density: "dolfinx.fem.Function"


def lay_materials(mesh_data: MeshData, materials: Materials) -> MaterialFields:
    """Lay one material, or one a region, over a mesh.

    Collective. Where regions overlap the later one of the mapping holds; the key None, wherever
    it stands, means all cells that no region has.

    Args:
        mesh_data: mesh.
        materials: a material, or a mapping of selections to materials.

    Returns:
        the fields.

    Raises:
        MaterialError: cells without material, or a cell field of the wrong length.
        SelectionError: a region that the mesh does not have.
    """
    mesh, by_region = mesh_data.mesh, _by_region(materials)
    index_map = mesh.topology.index_map(3)
    count = index_map.size_local + index_map.num_ghosts
    choice = np.full(count, -1)
    for place, region in enumerate(by_region):
        cells = slice(None) if region is None else select_entities(mesh_data, region, dimension=3)
        choice[cells] = place
    uncovered = mesh.comm.allreduce(int((choice[: index_map.size_local] < 0).sum()))
    if uncovered:
        raise MaterialError(
            f"{uncovered} of {index_map.size_global} cells have no material; the mesh has "
            f"{describe_groups(mesh_record(mesh_data).groups)}. Name the missing regions, or give "
            "a material for all other cells (in a file: a [[material]] without region; in Python: "
            "the key None)"
        )
    return _fields(mesh, list(by_region.values()), choice)


def _by_region(materials: Materials) -> dict[str | int | None, Law]:
    """The checked mapping, with the material of all other cells in front."""
    if isinstance(materials, _LAWS):
        return {None: materials}
    if not isinstance(materials, Mapping) or not materials:
        raise MaterialError(
            "a body needs a material such as NeoHookean(young=..., poisson=..., density=...), or a "
            f"mapping of regions to materials, got {materials!r}"
        )
    for region, material in materials.items():
        if not isinstance(material, _LAWS):
            raise MaterialError(
                f"the material of region {region!r} must be a material such as "
                f"NeoHookean(young=..., poisson=..., density=...), got {material!r}"
            )
    return dict(sorted(materials.items(), key=lambda item: item[0] is not None))


def _fields(
    mesh: "dolfinx.mesh.Mesh", materials: list[Law], choice: NDArray[np.int64]
) -> MaterialFields:
    space = dolfinx.fem.functionspace(mesh, ("DG", 0))
    laws: dict[Hashable, list[int]] = {}
    for place, material in enumerate(materials):
        laws.setdefault(_formula(material), []).append(place)
    regions = []
    for places in laws.values():
        cells = np.flatnonzero(np.isin(choice, places)).astype(np.int32)
        if mesh.comm.allreduce(cells.size) == 0:
            continue  # a later material covers it altogether
        moduli = {place: _lame(materials[place]) for place in places}
        regions.append(
            LawRegion(
                material=materials[places[0]],
                cells=cells,
                parameters={
                    name: _field(space, choice, {p: materials[p].parameters[name] for p in places})
                    for name in materials[places[0]].parameters
                },
                rest_moduli=None
                if any(pair is None for pair in moduli.values())
                else (
                    _field(space, choice, {p: pair[0] for p, pair in moduli.items() if pair}),
                    _field(space, choice, {p: pair[1] for p, pair in moduli.items() if pair}),
                ),
            )
        )
    density = _field(space, choice, {p: m.density for p, m in enumerate(materials)})
    return MaterialFields(tuple(regions), density)


def _formula(law: Law) -> Hashable:
    """What two laws share when only the numbers in them differ."""
    if isinstance(law, Material):
        return formula(law)
    return law.formula if isinstance(law, PointLaw) else "springs"


def _lame(material: Law) -> tuple[float | NDArray, float | NDArray] | None:
    if isinstance(material, MassSpring):
        return None  # of no direction only on the average
    try:
        young, poisson = material.linearised()
    except MaterialError:
        return None  # anisotropic or stressed at rest: its own tangent serves
    young, poisson = np.asarray(young), np.asarray(poisson)
    lmbda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    return lmbda, young / (2.0 * (1.0 + poisson))


def _field(
    space: "dolfinx.fem.FunctionSpace",
    choice: NDArray[np.int64],
    values: Mapping[int, float | NDArray[np.float64]],
) -> "dolfinx.fem.Function":
    """Cell-wise constant function that has in the cells of each choice that choice's value."""
    field = dolfinx.fem.Function(space)
    rows = cell_rows(space.mesh)
    count = space.mesh.topology.index_map(3).size_global
    dofs = space.dofmap.list[:, 0]
    for place, value in values.items():
        cells = np.flatnonzero(choice == place)
        if np.ndim(value) == 0:
            field.x.array[dofs[cells]] = value
            continue
        numbers = np.asarray(value)
        if len(numbers) != count:
            raise MaterialError(
                f"a material's cell field has {len(numbers)} values, and the mesh has {count} "
                "cells; give one value a cell of the whole mesh, in the order of the mesh file"
            )
        field.x.array[dofs[cells]] = numbers[rows[cells]]
    return field
