"""The same bodies on any number of ranks: ``python bodies_on_ranks.py FILE.npz`` keeps numbers."""

import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.energy import (
    Corotational,
    HyperelasticEnergy,
    Invertible,
    MassSpring,
    NeoHookean,
    StVenantKirchhoff,
)
from fenics_defo.fem.compat import MPI, dolfinx
from fenics_defo.fem.imported import MeshData, mesh_record
from fenics_defo.fem.linalg import combine, multiply
from fenics_defo.fem.linear_solvers import linear_solver
from fenics_defo.fem.ranks import on_first_rank
from fenics_defo.fem.surface_loads import PressureForm, surface_weights
from tests.unit.fem.fem_bodies import (
    CELLS,
    KINDS,
    MODULI,
    NEO,
    SVK,
    bend,
    box,
    mesh_of,
    source,
    tapered,
    usual_groups,
)

Array = NDArray[Any]
COMM = MPI.COMM_WORLD


def on_all_ranks(values: Any) -> Array:
    """The values, which must be the same on each rank."""
    array = np.asarray(values)
    for other in COMM.allgather(array):
        np.testing.assert_array_equal(other, array)
    return array


def numbers(solid: fem.Solid) -> dict[str, Array]:
    """Everything a body gives, at a bent displacement."""
    u = bend(solid)
    held = solid.nodes.scatter(solid.held)
    K, M = solid.assembly.stiffness_matrix(diagonal=5.0), solid.assembly.mass.matrix()
    norms = [K.norm(), M.norm(), K.getDiagonal().norm(), M.getDiagonal().norm()]
    check_pencil(solid, K)
    K.destroy()
    M.destroy()
    assert solid.assembly.owned == solid.nodes.owned <= len(held)
    found = {
        **{"points": solid.points, "cells": solid.cells, "held": solid.held},
        **{"energy": solid.energy(u), "force": solid.internal_force(u), "norms": norms},
        **{"tangent": solid.tangent(u).toarray(), "rest": solid.tangent().toarray()},
        **{"mass": solid.mass().toarray(), "lumped": solid.lumped_mass()},
        "total": solid.total_mass(),
        "back": solid.nodes.gather(solid.nodes.scatter(u))[solid.nodes.carried],
    }
    np.testing.assert_array_equal(found["back"], u[solid.nodes.carried])
    return {name: on_all_ranks(value) for name, value in found.items()}


def check_pencil(solid: fem.Solid, K: Any) -> None:
    """Both products in one pass are those of PETSc and SciPy, on any number of ranks."""
    held = solid.assembly.held[: solid.assembly.owned].ravel()
    block = np.random.default_rng(COMM.rank).standard_normal((len(held), 14))
    block[held] = 0.0
    block = np.asfortranarray(block)
    images, momenta = multiply(K, block), solid.assembly.mass.multiply(block)
    both = solid.assembly.pencil(K).multiply(block)
    for found, expected in zip(np.hsplit(both, 2), (images, momenta), strict=True):
        size = COMM.allreduce(float(np.abs(expected).max(initial=0.0)), op=MPI.MAX)
        np.testing.assert_allclose(found, expected, atol=1e-13 * size)


def bodies() -> dict[str, dict[str, Array]]:
    """Each kind of cell and order; regions, fields, held components, groups of all dimensions."""
    found = {}
    fixed = ["root", fem.Fixed("9", "y"), fem.Fixed("x>1.99", "yz"), fem.Fixed("pins", "x")]
    for kind, order, mesh_order in [*CELLS, ("tetrahedron", 1, 2)]:
        mesh = source(kind, order=mesh_order, mapping=tapered, groups=usual_groups(kind))
        young = 1e5 + np.arange(len(mesh.cells))
        material = {"right": NEO, None: NeoHookean(**(MODULI | {"young": young}))}
        found[f"{kind}-{order}-{mesh_order}"] = numbers(
            fem.Solid(mesh_of(mesh), material, order=order, fixed=fixed)
        )
    mesh = source("tetrahedron", groups=usual_groups("tetrahedron"))
    found["two-laws"] = numbers(fem.Solid(mesh_of(mesh), {"left": NEO, "right": SVK}))
    return found


def parts() -> dict[str, dict[str, Array]]:
    """Laws at points, springs and UFL in one body; pressure; solvers; matrices filled in place."""
    found = {}
    for kind in KINDS:
        mesh = source(kind, mapping=tapered, groups=usual_groups(kind))
        young = 1e5 + np.arange(len(mesh.cells))
        corotational = Corotational(**(MODULI | {"young": young}))
        springs = MassSpring(young=1e5, density=1.2e3)
        material = {"left": NEO, None: corotational, "middle": springs}
        solid = fem.Solid(mesh_of(mesh), material, fixed=["root", fem.Fixed("9", "y")])
        found[f"mixed-{kind}"] = numbers(solid) | loaded(solid)
    mesh = source("tetrahedron", mapping=tapered, cells=(6, 3, 2))
    solid = fem.Solid(mesh_of(mesh), Invertible(NEO), order=2, fixed=["x<1e-9"])
    found["invertible"] = numbers(solid) | loaded(solid)
    return found


def loaded(solid: fem.Solid) -> dict[str, Array]:
    """Forces and tangents of pressure, and solutions of each linear solver."""
    local = solid.nodes.scatter(bend(solid))
    form, assembly = PressureForm(solid, "z<0.2"), solid.assembly
    K, M, total = assembly.empty_matrix(), assembly.mass.matrix(), assembly.empty_matrix()
    force = assembly.linearise(K, local)
    form.add_tangent(K, local, -50.0)
    pressure = form.force(local, 50.0)
    combine(total, K, 1.0, M, 1e4)
    free = ~assembly.held
    right = ((pressure - force) * free)[: assembly.owned].ravel()
    found = {
        "pressure": solid.nodes.gather_own(pressure),
        "linearised": solid.nodes.gather_own(force),
        "area": solid.nodes.gather_own(surface_weights(solid, "z<0.2")),
        "combined": total.norm(),
    }
    for kind in ("cholesky", "pcg-jacobi", "pcg-amg"):
        with closing(linear_solver(kind, assembly, tolerance=1e-13)) as solver:
            for scale in (0.5, 1.0):  # the second time nothing is new but the numbers
                combine(total, K, scale, M, 1e4)
                solver.prepare(total)
                solution = solver.solve(right).reshape(-1, 3)
        found[f"solution-{kind}"] = solid.nodes.gather_own(solution)
    for matrix in (K, M, total):
        matrix.destroy()
    return {name: on_all_ranks(value) for name, value in found.items()}


def entities() -> dict[str, Array]:
    """Sorted midpoints of what selections mean, counted once."""
    mesh_data = mesh_of(source("tetrahedron", groups=usual_groups("tetrahedron")))
    foreign = MeshData(*mesh_data)  # its record is made from the tags
    found = {}
    for name, dimension in [("left", 3), ("x<1", 3), ("root", 2), ("z<1e-9", 2), ("9", 1)]:
        for data in (mesh_data, foreign):
            chosen = fem.select_entities(data, name, dimension=dimension)
            middles = dolfinx.mesh.compute_midpoints(data.mesh, dimension, chosen)
            every = np.unique(np.round(np.vstack(COMM.allgather(middles)), 9), axis=0)
            found[f"{name}-{dimension}-{data is foreign}"] = every
    for data in (mesh_data, foreign):
        counts = [group.size for group in mesh_record(data).groups]
        found[f"{data is foreign}-sizes"] = on_all_ranks(counts)
    return found


def one_cell() -> dict[str, Array]:
    """Fewer cells than ranks."""
    mesh_data = fem.build_mesh(*box("hexahedron", cells=(1, 1, 1)), kind="hexahedron")
    return numbers(fem.Solid(mesh_data, NEO, fixed=["x==0"]))


def node_file_of_rank_0() -> dict[str, Array]:
    """The other ranks are given a file that is not there."""
    with TemporaryDirectory() as folder:
        path = Path(folder if COMM.rank == 0 else "/nowhere") / "nodes.bou"
        if COMM.rank == 0:
            path.write_text("1, 5, 7")
        solid = fem.Solid(mesh_of(source("tetrahedron")), SVK, fixed=[f"nodes:{path}"])
    return {"held": on_all_ranks(solid.held)}


def failing() -> dict[str, Callable[[], object]]:
    """Users' mistakes; some of them show on one rank only."""
    mesh = source("tetrahedron", groups=usual_groups("tetrahedron"))
    mesh_data = mesh_of(mesh)

    def body(material: Any = SVK, **options: Any) -> fem.Solid:
        return fem.Solid(mesh_data, material, **options)

    def rank_0_breaks() -> object:
        return on_first_rank(COMM, lambda: {}["missing"])

    short = StVenantKirchhoff(**(MODULI | {"young": np.ones(4)}))
    vector = HyperelasticEnergy(lambda F, c: F, {}, density=1.0)
    return {
        "missing file": lambda: fem.read_mesh("/nowhere/body.msh"),
        "flat cell": lambda: fem.build_mesh(np.zeros((4, 3)), np.arange(4)[None]),
        "no group": lambda: body(fixed=["wall"]),
        "no node": lambda: body(fixed=["x>7"]),
        "bad comparison": lambda: body(fixed=["x<"]),
        "no node file": lambda: body(fixed=["nodes:/nowhere/a.bou"]),
        "no region": lambda: body({"steel": SVK}),
        "uncovered": lambda: body({"left": SVK}),
        "short field": lambda: body({None: SVK, "left": short}),
        "no scalar": lambda: body(vector),
        "order": lambda: body(order=3),
        "shape": lambda: body().energy(np.zeros((2, 3))),
        "no facet": lambda: fem.select_entities(mesh_data, "x>7", dimension=2),
        "rank 0 breaks": rank_0_breaks,
    }


def failures() -> dict[str, dict[str, Array]]:
    """What each rank is told."""
    found = {}
    for name, act in failing().items():
        try:
            act()
        except Exception as error:
            message = f"{type(error).__name__}: {error}"
        else:
            message = "no error"
        found[name] = {"messages": np.array(COMM.allgather(message))}
    return found


def everything() -> dict[str, Array]:
    """All of the above by flat names."""
    groups = {"entities": entities(), "one-cell": one_cell(), "file": node_file_of_rank_0()}
    groups |= bodies() | parts() | failures()
    return {f"{a}/{b}": value for a, values in groups.items() for b, value in values.items()}


if __name__ == "__main__":
    kept = everything()
    if COMM.rank == 0:
        np.savez(sys.argv[1], **kept)
