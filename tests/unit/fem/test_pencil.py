"""K and M times a block in one pass, against the products of PETSc and SciPy."""

from collections.abc import Iterator

import numpy as np
import pytest
from fem_bodies import CELLS, NEO, bend, mesh_of, source, tapered
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.fem.assembly import Assembly
from fenics_defo.fem.compat import PETSc
from fenics_defo.fem.linalg import multiply

Array = NDArray[np.float64]
Body = tuple[Assembly, PETSc.Mat]


@pytest.fixture(params=CELLS, ids=str)
def body(request: pytest.FixtureRequest) -> Iterator[Body]:
    """A deformed body, held on one side and sliding at one edge, and its stiffness."""
    kind, order, _ = request.param
    mesh = source(kind, mapping=tapered, cells=(4, 2, 2))
    solid = fem.Solid(mesh_of(mesh), NEO, order=order, fixed=["x<1e-6", fem.Fixed("x>1.99", "yz")])
    stiffness = solid.assembly.stiffness_matrix(solid.nodes.scatter(bend(solid)))
    yield solid.assembly, stiffness
    stiffness.destroy()


def block_of(assembly: Assembly, width: int) -> Array:
    held = assembly.held[: assembly.owned].ravel()
    block = np.random.default_rng(width).standard_normal((len(held), width))
    block[held] = 0.0
    return np.asfortranarray(block)


@pytest.mark.parametrize("width", [1, 3, 4, 8, 12, 13, 26])
def test_products_with_both_matrices(body: Body, width: int) -> None:
    assembly, stiffness = body
    block, pencil = block_of(assembly, width), assembly.pencil(stiffness)
    images, momenta = multiply(stiffness, block), assembly.mass.multiply(block)
    both = pencil.multiply(block)
    assert both.flags.f_contiguous
    np.testing.assert_allclose(both[:, :width], images, rtol=1e-13, atol=1e-13 * images.max())
    np.testing.assert_allclose(both[:, width:], momenta, rtol=1e-13, atol=1e-13 * momenta.max())
    shift = -float(images.max() / momenta.max())
    shifted = pencil.multiply(block, shift=shift)[:, :width]
    np.testing.assert_allclose(shifted, images - shift * momenta, atol=1e-13 * images.max())
    values = shift * np.arange(width)
    residuals = pencil.residuals(block, values)
    np.testing.assert_allclose(
        residuals, images - momenta * values, atol=1e-13 * width * images.max()
    )


def test_held_components_stay_zero(body: Body) -> None:
    assembly, stiffness = body
    block = block_of(assembly, 5)
    held = assembly.held[: assembly.owned].ravel()
    assert held.any()
    assert not assembly.pencil(stiffness).multiply(block, shift=3.0)[held].any()
