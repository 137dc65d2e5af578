"""The numbers inside PETSc's matrices of 3x3 blocks, which petsc4py does not show."""

import ctypes
from functools import cache

from petsc4py import PETSc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import dolfinx  # noqa: F401  (PETSc's wheel wants DOLFINx's order of loading)

Array = NDArray[np.float64]


@cache
def _petsc() -> ctypes.CDLL:
    # petsc4py's extension module is linked to the very library that made the matrices.
    return ctypes.CDLL(PETSc.__file__)


def block_values(matrix: PETSc.Mat, counts: tuple[int, int]) -> tuple[Array, Array]:
    """Values of this rank's rows, without a copy: blocks (k, 9), each stored column by column.

    They stay valid while the matrix lives. Whoever changes them calls `mark_changed`.

    Args:
        matrix: assembled, in blocks of 3.
        counts: how many blocks lie in this rank's columns, and how many in others'.

    Returns:
        both, by rows.
    """
    handle = ctypes.c_void_p(matrix.handle)
    if matrix.getComm().size == 1:
        return _sequential(handle, counts[0]), np.empty((0, 9))
    own, other, columns = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
    places = (ctypes.byref(own), ctypes.byref(other), ctypes.byref(columns))
    _check(_petsc().MatMPIBAIJGetSeqBAIJ(handle, *places))
    return _sequential(own, counts[0]), _sequential(other, counts[1])


def _sequential(handle: ctypes.c_void_p, count: int) -> Array:
    if count == 0:
        return np.empty((0, 9))
    array = ctypes.POINTER(ctypes.c_double)()
    _check(_petsc().MatSeqBAIJGetArray(handle, ctypes.byref(array)))
    values = np.ctypeslib.as_array(array, shape=(count, 9))
    _check(_petsc().MatSeqBAIJRestoreArray(handle, ctypes.byref(array)))
    return values


def mark_changed(matrix: PETSc.Mat) -> None:
    """Tell PETSc, and through it solvers and preconditioners, that the values have changed."""
    matrix.stateIncrease()


def _check(error: int) -> None:
    if error:
        raise PETSc.Error(error)
