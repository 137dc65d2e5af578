"""The loops over cells of ``native/cells.c``: arrays in, arrays added to."""

import ctypes

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.loops import loops

Array = NDArray[np.float64]
Integers = NDArray[np.int32]


def _library() -> ctypes.CDLL:
    return loops("cells")


def _pointer(array: NDArray, kind: type) -> ctypes.c_void_p:
    assert array.dtype == kind, (array.dtype, kind)
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def _doubles(array: Array) -> ctypes.c_void_p:
    return _pointer(array, np.float64)


def _int32(array: Integers) -> ctypes.c_void_p:
    return _pointer(array, np.int32)


_long, _int = ctypes.c_int64, ctypes.c_int


def block_positions(
    nodes: Integers, first: NDArray[np.int64], columns: Integers
) -> NDArray[np.int32]:
    """Numbers (c, n, n) of the blocks of each cell's pairs of nodes.

    Args:
        nodes: (c, n) nodes of the cells.
        first: (rows + 1,) where each row begins in ``columns``.
        columns: sorted in each row.
    """
    cells, n = nodes.shape
    positions = np.empty((cells, n, n), np.int32)
    count = _library().fenics_defo_positions
    count.restype = _long
    missing = count(
        _long(cells),
        _int(n),
        _int32(nodes),
        _pointer(first, np.int64),
        _int32(columns),
        _int32(positions),
    )
    assert missing == 0, f"{missing} blocks are not in the pattern"
    return positions


def add_kernel(
    address: int,
    entities: tuple[Integers, Integers | None],
    packed: tuple[Array, Array],
    geometry: tuple[Array, Integers],
    positions: NDArray[np.int32],
    values: Array,
) -> None:
    """Add the blocks of a kernel that FFCx has compiled.

    Args:
        address: of the kernel.
        entities: cells (k,), and their facets (k,) if the integral is over facets.
        packed: coefficients (k, w) and constants, as DOLFINx packs them.
        geometry: points (p, 3) [m] and the cells' (c, v) rows of it.
        positions: (c, n, n) of all cells.
        values: (blocks, 3, 3), added to.
    """
    (cells, facets), (coefficients, constants) = entities, packed
    assert len(coefficients) == len(cells) or coefficients.size == 0
    x, corners = geometry
    _library().fenics_defo_add_kernel(
        ctypes.c_void_p(address),
        _long(len(cells)),
        _int32(cells),
        None if facets is None else _int32(facets),
        _doubles(coefficients),
        _long(coefficients.shape[1]),
        _doubles(constants),
        _doubles(x),
        _int32(corners),
        _int(corners.shape[1]),
        _int32(positions),
        _int(positions.shape[1]),
        _doubles(values),
    )


def add_blocks(positions: NDArray[np.int32], blocks: Array, values: Array) -> None:
    """Add blocks (k, 3, 3) at positions (k,) to values (blocks, 3, 3)."""
    _library().fenics_defo_add_blocks(
        _long(len(positions)), _int32(positions), _doubles(blocks), _doubles(values)
    )


def inverse_blocks(blocks: Array) -> Array:
    """Inverses (k, 3, 3) of blocks; not finite where there is none.

    Ten times faster than NumPy's, which calls LAPACK for each.
    """
    inverses = np.empty_like(blocks)
    _library().fenics_defo_invert_blocks(_long(len(blocks)), _doubles(blocks), _doubles(inverses))
    return inverses


def write_blocks(chosen: NDArray[np.int32], values: Array, target: Array, *, add: bool) -> None:
    """Copy the chosen blocks, or add them, to PETSc's (k, 9), which are stored column by column."""
    _library().fenics_defo_write_blocks(
        _long(len(chosen)), _int32(chosen), _doubles(values), _int(add), _doubles(target)
    )


class PointLoops:
    """Loops over some cells' quadrature points.

    Args:
        reference: gradients (q, n, 3) of the element's functions on the reference cell.
        inverse: J⁻¹ (c, q, 3, 3) of the cells' maps at the points.
        weights: (c, q) of the quadrature, |det J| included [m³].
        nodes: (c, n) this rank's nodes of the cells.
    """

    def __init__(self, reference: Array, inverse: Array, weights: Array, nodes: Integers) -> None:
        self._reference = np.ascontiguousarray(reference)
        self._inverse, self._weights, self._nodes = inverse, weights, nodes
        self._shape = (_int(reference.shape[0]), _int(reference.shape[1]))

    def gradients(self, some: slice, u: Array, out: Array) -> None:
        """F (k q, 3, 3) at the points of some cells, of a displacement (d, 3)."""
        nodes = self._nodes[some]
        _library().fenics_defo_gradients(
            _long(len(nodes)),
            *self._shape,
            _doubles(self._reference),
            _doubles(self._inverse[some]),
            _int32(nodes),
            _doubles(u),
            _doubles(out),
        )

    def add_forces(self, some: slice, stress: Array, force: Array) -> None:
        """Add the forces of P (k q, 3, 3) in some cells to (d, 3)."""
        nodes = self._nodes[some]
        _library().fenics_defo_add_forces(
            _long(len(nodes)),
            *self._shape,
            _doubles(self._reference),
            _doubles(self._inverse[some]),
            _doubles(self._weights[some]),
            _int32(nodes),
            _doubles(stress),
            _doubles(force),
        )

    def add_tangents(
        self, some: slice, tangent: Array, positions: NDArray[np.int32], values: Array
    ) -> None:
        """Add the stiffness of A (k q, 3, 3, 3, 3) in some cells to blocks (b, 3, 3)."""
        nodes = self._nodes[some]
        _library().fenics_defo_add_tangents(
            _long(len(nodes)),
            *self._shape,
            _doubles(self._reference),
            _doubles(self._inverse[some]),
            _doubles(self._weights[some]),
            _int32(positions[some]),
            _doubles(tangent),
            _doubles(values),
        )
