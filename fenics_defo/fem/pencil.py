"""K and M times blocks of vectors, both in one pass (``native/pencil.c``)."""

import ctypes
import subprocess
from functools import cache

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MissingDependencyError
from fenics_defo.fem.block_matrix import BlockMatrix
from fenics_defo.fem.compat import dolfinx
from fenics_defo.fem.jit import architecture
from fenics_defo.fem.mass import ConsistentMass
from fenics_defo.fem.native_library import SOURCES, build_library, cache_folder

Array = NDArray[np.float64]

_FLAGS = ("-O3", "-std=c17", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast")
# Vectors that the loops take at once.
_WIDE = 8


@cache
def _library() -> ctypes.CDLL:
    flags = (*_FLAGS, *architecture())
    try:
        path = build_library(SOURCES / "pencil.c", flags=flags, folder=cache_folder())
        return ctypes.CDLL(str(path))
    except (OSError, subprocess.CalledProcessError) as error:
        raise MissingDependencyError(
            f"the products of matrices cannot be compiled ({error}): install a C compiler (gcc), "
            "which DOLFINx needs too, and check that its cache, ~/.cache/fenics, can be written"
        ) from error


def _at(array: NDArray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class Pencil:
    """K - a M and M, by this rank's rows.

    The index, the vector's entries and M ride along with the blocks of K: both products cost what
    K's alone does, and a third of what two products by PETSc and SciPy cost.

    Args:
        blocks: the pattern of both.
        stiffness: K, from ``blocks``; kept, and to be destroyed later than this object's last use.
        mass: M on the same nodes.
    """

    def __init__(self, blocks: BlockMatrix, stiffness: PETSc.Mat, mass: ConsistentMass) -> None:
        self._first, self._columns, self._blocks = blocks.local_rows(stiffness)
        self._mass = mass.on_pattern(self._first, self._columns, blocks.columns)
        self._held_rows = mass.held_rows
        self._stiffness = stiffness
        self._nodes = blocks.owned
        self._packed = dolfinx.la.vector(blocks.columns, 3 * _WIDE)

    def multiply(self, block: Array, *, shift: float = 0.0) -> Array:
        """K X - shift M X and M X, side by side; collective.

        Args:
            block: X (owned dofs, b) in Fortran order, zero at held components.
            shift: [rad²/s²].

        Returns:
            (owned dofs, 2 b) in Fortran order, zero at held components.
        """
        rows, width = block.shape
        both = np.empty((rows, 2 * width), order="F")
        images, momenta = both[:, :width], both[:, width:]
        self._multiply(block, np.full(width, shift), images, momenta)
        return both

    def residuals(self, block: Array, values: Array) -> Array:
        """K X - M X diag(values), as `multiply` gives it; collective."""
        images = np.empty(block.shape, order="F")
        self._multiply(block, values, images, None)
        return images

    def _multiply(self, block: Array, values: Array, images: Array, momenta: Array | None) -> None:
        assert block.flags.f_contiguous
        for begin in range(0, block.shape[1], _WIDE):
            some = slice(begin, begin + _WIDE)
            shifts = np.zeros(_WIDE)
            shifts[: len(values[some])] = values[some]
            self._some(
                block[:, some],
                shifts,
                images[:, some],
                None if momenta is None else momenta[:, some],
            )
        for product in (images, momenta):
            if product is not None:
                product[self._held_rows] = 0.0

    def _some(self, block: Array, shifts: Array, images: Array, momenta: Array | None) -> None:
        """At most eight columns."""
        library, width = _library(), ctypes.c_int(block.shape[1])
        packed = self._packed.array
        rows = ctypes.c_int64(len(block))
        library.fenics_defo_pack(rows, width, _at(block), _at(packed))
        self._packed.scatter_forward()
        library.fenics_defo_pencil(
            ctypes.c_int64(self._nodes),
            _at(self._first),
            _at(self._columns),
            _at(self._blocks),
            _at(self._mass),
            _at(packed),
            _at(shifts),
            width,
            _at(images),
            None if momenta is None else _at(momenta),
        )
