"""Lowest eigenpairs by SLEPc's Krylov-Schur iteration with MUMPS's factors."""

from collections.abc import Iterator
from contextlib import contextmanager

from petsc4py import PETSc
from slepc4py import SLEPc

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.eigenpairs import EigenProblem, Pairs
from fenics_defo.analysis.phases import Phases
from fenics_defo.errors import EigenSolveError
from fenics_defo.fem.linalg import OPTIONS_PREFIX

Array = NDArray[np.float64]


def krylov_schur(problem: EigenProblem, count: int, *, tolerance: float, phases: Phases) -> Pairs:
    """Pairs by SLEPc's Krylov-Schur iteration, shift-and-invert, factors by MUMPS.

    Args:
        problem: matrices and shift.
        count: number of pairs.
        tolerance: SLEPc's tolerance of the shifted and inverted problem.
        phases: stopwatch.

    Returns:
        at least ``count`` pairs.

    Raises:
        EigenSolveError: fewer converged.
    """
    with _scalar(problem) as (stiffness, mass), _solver(problem) as eps:
        stiffness.setOption(PETSc.Mat.Option.SPD, problem.definite)
        eps.setOperators(stiffness, mass)
        eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
        basis = min(max(2 * count, count + 15), problem.independent)
        eps.setDimensions(count, basis)
        eps.setTolerances(tolerance, 200)
        eps.setTarget(problem.shift)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
        transform = eps.getST()
        transform.setType(SLEPc.ST.Type.SINVERT)
        transform.setShift(problem.shift)
        transform.setMatStructure(PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        linear = transform.getKSP()
        linear.setType(PETSc.KSP.Type.PREONLY)
        factors = linear.getPC()
        factors.setType(PETSc.PC.Type.CHOLESKY)
        factors.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        with phases("factorise"):
            eps.setUp()
        with phases("solve"):
            eps.solve()
        return _pairs(problem, eps, count)


@contextmanager
def _scalar(problem: EigenProblem) -> Iterator[tuple[PETSc.Mat, PETSc.Mat]]:
    halves = [m.convert("aij", PETSc.Mat()) for m in (problem.stiffness, problem.mass)]
    try:
        yield halves[0], halves[1]
    finally:
        for matrix in halves:
            matrix.destroy()


@contextmanager
def _solver(problem: EigenProblem) -> Iterator[SLEPc.EPS]:
    eps = SLEPc.EPS().create(problem.comm)
    eps.setOptionsPrefix(OPTIONS_PREFIX)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    try:
        yield eps
    finally:
        eps.destroy()


def _pairs(problem: EigenProblem, eps: SLEPc.EPS, count: int) -> Pairs:
    found = eps.getConverged()
    if found < count:
        raise EigenSolveError(
            f"SLEPc found {found} of {count} modes in {eps.getIterationNumber()} iterations; "
            "ask for fewer modes, or use the direct solver (--solver lanczos, solver='lanczos')"
        )
    values = np.array([eps.getEigenvalue(i).real for i in range(found)])
    order = np.argsort(values)
    vectors = np.empty((len(problem.free), found), order="F")
    vector = problem.stiffness.createVecRight()
    for place, index in enumerate(order):
        eps.getEigenvector(int(index), vector)
        vectors[:, place] = vector.array
    vector.destroy()
    return problem.ritz(vectors, converged=found)
