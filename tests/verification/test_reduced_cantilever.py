"""A cantilever bent by its end load into large rotation: what each basis and force can follow."""

from functools import cache

import numpy as np
import pytest
from bodies import Array, box
from motions import INTEGRATORS, states

from fenics_defo.analysis import Traction, linear_modes
from fenics_defo.energy import StVenantKirchhoff
from fenics_defo.fem import Solid
from fenics_defo.reduction import (
    Basis,
    linear_basis,
    modal_derivative_basis,
    reduce,
    snapshot_basis,
)
from fenics_defo.runtime.integrators import ImplicitNewmark

LENGTH, WIDTH, HEIGHT = 1.0, 0.1, 0.06
RUBBER = StVenantKirchhoff(young=1.0e7, poisson=0.3, density=1000.0)
# F L² / (E I) = 1: the static tip would stand at 0.30 L, the sudden load takes it to 0.54 L.
FORCE = 1.0e7 * (WIDTH * HEIGHT**3 / 12.0) / LENGTH**2
LOAD = Traction("x==1", (0.0, 0.0, FORCE / (WIDTH * HEIGHT)))
STEP, COUNT = 1.0 / 60.0, 60


@cache
def cantilever() -> Solid:
    mesh = box("hexahedron", (8, 1, 1), (LENGTH, WIDTH, HEIGHT))
    return Solid(mesh, RUBBER, order=2, fixed=["x==0"])


@cache
def full_motion() -> Array:
    """Displacements (steps + 1, n, 3)."""
    solid = cantilever()
    found = states(solid, INTEGRATORS["newmark"], step=STEP, count=COUNT, loads=[LOAD], newton=2)
    return np.array([state.displacement for state in found])


def reduced_motion(basis: Basis, force: str) -> Array:
    model = reduce(cantilever(), basis, force, loads={"end": LOAD}, range_tolerance=None)
    load = model.load("end")
    stepper = ImplicitNewmark(model, step=STEP, newton=2, load=load)
    motion = [model.displacement(stepper.q)]
    for _ in range(COUNT):
        stepper.advance(load)
        motion.append(model.displacement(stepper.q))
    return np.array(motion)


def largest_error(motion: Array) -> float:
    """Of any time, by the largest displacement of the full simulation."""
    full = full_motion()
    sizes = np.linalg.norm(full, axis=(1, 2))
    return float((np.linalg.norm(motion - full, axis=(1, 2)) / sizes.max()).max())


def tip(motion: Array) -> Array:
    """Displacements (steps + 1, 3) of the middle of the end."""
    points = cantilever().points
    end = np.argmin(np.linalg.norm(points - (LENGTH, WIDTH / 2, HEIGHT / 2), axis=1))
    return motion[:, end]


def test_the_motion_is_a_large_rotation() -> None:
    along, _, up = tip(full_motion()).T
    assert up.max() > 0.5 * LENGTH
    assert along.min() < -0.15 * LENGTH


def test_linear_modes_fail() -> None:
    """With the exact force they lock: none of their span bends without stretching the beam."""
    basis = linear_basis(cantilever(), linear_modes(cantilever(), 20), 20)
    exact, linear = (reduced_motion(basis, force) for force in ("cubic", "linear"))
    assert largest_error(exact) > 0.5
    assert tip(exact)[:, 2].max() < 0.25 * tip(full_motion())[:, 2].max()
    # With the linear force the tip goes straight up, and so the beam grows.
    assert largest_error(linear) > 0.2
    assert np.abs(tip(linear)[:, 0]).max() < 1e-6 * LENGTH


@pytest.mark.parametrize(("modes", "size"), [(3, 9), (4, 12), (6, 20)])
def test_modal_derivatives_work(modes: int, size: int) -> None:
    solid = cantilever()
    basis = modal_derivative_basis(solid, linear_modes(solid, modes), size=size)
    motion = reduced_motion(basis, "cubic")
    assert largest_error(motion) < 0.03
    assert tip(motion)[:, 0].min() == pytest.approx(tip(full_motion())[:, 0].min(), rel=0.03)


def test_a_basis_of_the_motion_itself_is_best() -> None:
    solid = cantilever()
    basis = snapshot_basis(solid, full_motion()[1:], size=12)
    assert largest_error(reduced_motion(basis, "cubic")) < 0.003


def test_direct_and_cubic_are_the_same_motion() -> None:
    solid = cantilever()
    basis = modal_derivative_basis(solid, linear_modes(solid, 3), size=9)
    cubic, direct = (reduced_motion(basis, force) for force in ("cubic", "direct"))
    np.testing.assert_allclose(cubic, direct, rtol=0.0, atol=1e-10 * LENGTH)
