"""The count of the inertia catches a solver that loses pairs."""

import gc
from dataclasses import replace
from typing import Any

from petsc4py import PETSc

import numpy as np
import pytest
from modal_bodies import box

from fenics_defo.analysis import deflation, linear_modes
from fenics_defo.analysis.davidson import RitzVectors
from fenics_defo.analysis.eigenpairs import EigenProblem
from fenics_defo.errors import DefoError, EigenSolveError


def sabotage(monkeypatch: Any, *, lost: int, times: int) -> list[int]:
    """Make the first searches lose a pair; returns what grows with each search."""
    honest, searches = deflation.block_davidson, []

    def forgetful(*arguments: Any, **options: Any) -> RitzVectors:
        found = honest(*arguments, **options)
        searches.append(found.vectors.shape[1])
        if len(searches) > times:
            return found
        kept = np.arange(found.vectors.shape[1]) != lost
        return replace(
            found,
            vectors=np.asfortranarray(found.vectors[:, kept]),
            converged=found.converged - 1,
        )

    monkeypatch.setattr(deflation, "block_davidson", forgetful)
    return searches


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
@pytest.mark.parametrize("lost", [0, 2])
def test_a_lost_pair_is_searched_for_and_found(monkeypatch: Any, lost: int, fixed: Any) -> None:
    solid = box((5, 2, 2), fixed=fixed)
    expected = linear_modes(solid, 10)
    searches = sabotage(monkeypatch, lost=lost, times=1)
    modes = linear_modes(solid, 10)
    assert len(searches) >= 2
    assert modes.complete
    assert modes.frequencies == pytest.approx(expected.frequencies, rel=1e-9)


def test_a_solver_that_always_loses_a_pair_is_not_believed(monkeypatch: Any) -> None:
    solid = box((5, 2, 2), fixed=["x==0"])
    sabotage(monkeypatch, lost=0, times=1000)
    monkeypatch.setattr(deflation.Deflation, "locking", lambda self, pairs: self)
    with pytest.raises(EigenSolveError, match=r"9 modes were found where the inertia .* counts 10"):
        linear_modes(solid, 9)


def test_without_the_count_nothing_is_claimed(monkeypatch: Any) -> None:
    solid = box((5, 2, 2), fixed=["x==0"])
    whole = linear_modes(solid, 5)
    sabotage(monkeypatch, lost=0, times=1000)
    modes = linear_modes(solid, 5, verify=False)
    assert not modes.complete
    assert modes.frequencies[:4] == pytest.approx(whole.frequencies[1:], rel=1e-9)


def test_the_inertia_counts_what_lies_below() -> None:
    solid = box((3, 2, 2), fixed=["x==0"])
    modes = linear_modes(solid, 12)
    assembly = solid.assembly
    stiffness = assembly.stiffness_matrix()
    problem = EigenProblem(
        stiffness=stiffness,
        mass=assembly.mass,
        pencil=assembly.pencil(stiffness),
        shift=0.0,
        definite=True,
        independent=int((~solid.held).sum()),
        free=~assembly.held.ravel(),
    )
    for place in (0, 3, 11):
        value = float(modes.omega[place] ** 2)
        assert problem.below(value * (1.0 + 1e-6)) == place + 1
        assert problem.below(value * (1.0 - 1e-6)) == place
    problem.stiffness.destroy()


@pytest.mark.parametrize("failure", [DefoError, KeyboardInterrupt])
def test_matrices_are_freed_whatever_happens(monkeypatch: Any, failure: Any) -> None:
    created: list[PETSc.Mat] = []
    solid = box((3, 1, 1), fixed=["x==0"])
    honest = solid.assembly.stiffness_matrix

    def kept(self: Any, *arguments: Any, **options: Any) -> PETSc.Mat:
        created.append(honest(*arguments, **options))
        return created[-1]

    monkeypatch.setattr(type(solid.assembly), "stiffness_matrix", kept)

    def fails(*_: Any, **__: Any) -> None:
        raise failure("stop")

    monkeypatch.setattr(deflation, "block_davidson", fails)
    with pytest.raises(failure):
        linear_modes(solid, 3)
    gc.collect()
    assert len(created) == 1
    assert all(not matrix.handle for matrix in created)
