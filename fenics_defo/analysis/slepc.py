"""Lowest eigenpairs by SLEPc's Krylov-Schur iteration with MUMPS's factors."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.compat import PETSc  # must come first: MPI loads before SLEPc

# isort: split
from slepc4py import SLEPc

from fenics_defo.analysis.deflation import Deflation
from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.phases import Phases
from fenics_defo.errors import EigenSolveError, SolverError
from fenics_defo.fem.linalg import OPTIONS_PREFIX

Array = NDArray[np.float64]


def krylov_schur(deflation: Deflation, count: int, *, tolerance: float, phases: Phases) -> Pairs:
    """Pairs by SLEPc's Krylov-Schur iteration, shift-and-invert, factors by MUMPS.

    Args:
        deflation: the problem and what is left out of it.
        count: number of pairs.
        tolerance: SLEPc's tolerance of the shifted and inverted problem.
        phases: stopwatch.

    Returns:
        at least ``count`` pairs.

    Raises:
        SolverError: the matrix could not be factorised.
        EigenSolveError: fewer converged.
    """
    problem, space = deflation.problem, deflation.remaining
    vectors, momenta = deflation.known
    with _operators(deflation) as (stiffness, mass), _solver(problem) as eps:
        stiffness.setOption(PETSc.Mat.Option.SPD, problem.definite)
        eps.setOperators(stiffness, mass)
        eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
        # SLEPc wants a basis larger than what is asked for, even where that is the whole space.
        eps.setDimensions(count, max(min(max(2 * count, count + 15), space), count + 1))
        eps.setTolerances(tolerance, 200)
        eps.setTarget(problem.shift)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
        _set_transform(eps, problem.shift)
        if vectors.shape[1]:
            with _handles(problem, vectors) as handles:
                eps.setDeflationSpace(handles)
        with phases("factorise"):
            try:
                eps.setUp()
            except (PETSc.Error, SystemError) as error:
                raise SolverError(
                    f"SLEPc could not prepare {count} of {space} modes ({error}); use "
                    "the direct solver (--solver davidson, solver='davidson')"
                ) from error
        with phases("solve"):
            eps.solve()
            found = _vectors(problem, eps, count)
    found -= vectors @ problem.products(momenta, found)
    return problem.ritz(found, converged=found.shape[1])


def _set_transform(eps: SLEPc.EPS, shift: float) -> None:
    transform = eps.getST()
    transform.setType(SLEPc.ST.Type.SINVERT)
    transform.setShift(shift)
    transform.setMatStructure(PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    linear = transform.getKSP()
    linear.setType(PETSc.KSP.Type.PREONLY)
    factors = linear.getPC()
    factors.setType(PETSc.PC.Type.CHOLESKY)
    factors.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)


@contextmanager
def _operators(deflation: Deflation) -> Iterator[tuple[PETSc.Mat, PETSc.Mat]]:
    """K + S and M in the scalar format that SLEPc can add."""
    with ExitStack() as stack:
        stiffness = stack.enter_context(deflation.supported(0.0)).convert("aij", PETSc.Mat())
        stack.callback(stiffness.destroy)
        blocks = deflation.problem.mass.matrix()
        stack.callback(blocks.destroy)
        mass = blocks.convert("aij", PETSc.Mat())
        stack.callback(mass.destroy)
        yield stiffness, mass


@contextmanager
def _handles(problem: EigenProblem, columns: Array) -> Iterator[list[PETSc.Vec]]:
    vectors = [problem.stiffness.createVecRight() for _ in range(columns.shape[1])]
    try:
        for vector, column in zip(vectors, columns.T, strict=True):
            vector.array[:] = column
        yield vectors
    finally:
        for vector in vectors:
            vector.destroy()


@contextmanager
def _solver(problem: EigenProblem) -> Iterator[SLEPc.EPS]:
    eps = SLEPc.EPS().create(problem.comm)
    eps.setOptionsPrefix(OPTIONS_PREFIX)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    try:
        yield eps
    finally:
        eps.destroy()


def _vectors(problem: EigenProblem, eps: SLEPc.EPS, count: int) -> Array:
    found = eps.getConverged()
    if found < count:
        raise EigenSolveError(
            f"SLEPc found {found} of {count} modes in {eps.getIterationNumber()} iterations; "
            "ask for fewer modes, or use the direct solver (--solver davidson, solver='davidson')"
        )
    vectors = np.empty((len(problem.free), found), order="F")
    vector = problem.stiffness.createVecRight()
    for place in range(found):
        eps.getEigenvector(place, vector)
        vectors[:, place] = vector.array
    vector.destroy()
    vectors[~problem.free] = 0.0
    return vectors
