"""Inertia of a deforming, turning body against sums over its points."""

import numpy as np
import pytest
from mass_clouds import Array, Cloud, cloud

from fenics_defo.runtime.floating.inertia import Inertia

CLOUDS = {"mean axes": cloud(), "any shapes": cloud(tisserand=False, seed=4)}
each_cloud = pytest.mark.parametrize("body", CLOUDS.values(), ids=CLOUDS)


class Motion:
    """A random motion, its points about the centre of mass."""

    def __init__(self, body: Cloud, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.q, self.v, self.a = rng.normal(size=(3, body.shapes.shape[-1]))
        self.spin, self.turn = rng.normal(size=(2, 3))
        frame = body.frame
        self.shapes = body.shapes - frame.mean
        self.arms = body.points - frame.centre + self.shapes @ self.q
        self.masses = body.masses
        self.velocity = np.cross(self.spin, self.arms) + self.shapes @ self.v

    def by_shapes(self, forces: Array) -> Array:
        """Generalised forces of forces (p, 3) upon the points."""
        return np.einsum("pai,pa->i", self.shapes, forces)


@each_cloud
def test_energy_and_momenta(body: Cloud) -> None:
    motion, inertia = Motion(body), Inertia(body.frame)
    at, w, v = inertia.at(motion.q), motion.spin, motion.v
    carried = motion.masses[:, None] * motion.velocity
    energy = 0.5 * w @ at.inertia @ w + w @ at.coupling @ v + 0.5 * v @ inertia.mass @ v
    assert energy == pytest.approx(0.5 * (carried * motion.velocity).sum(), rel=1e-12)
    angular = np.cross(motion.arms, carried).sum(axis=0)
    assert at.inertia @ w + at.coupling @ v == pytest.approx(angular, rel=1e-12)
    momenta = motion.by_shapes(carried)
    assert inertia.mass @ v + w @ at.coupling == pytest.approx(momenta, rel=1e-11)
    # The frame stays in the centre of mass, whatever the shapes carry.
    assert motion.masses @ motion.arms == pytest.approx(0.0, abs=1e-12)


@each_cloud
def test_inertia_forces(body: Cloud) -> None:
    """M q'' + A^T w' - 2 G q' - c is U^T m times the accelerations of the points."""
    motion, inertia = Motion(body, seed=2), Inertia(body.frame)
    at, w = inertia.at(motion.q), motion.spin
    accelerations = (
        motion.shapes @ motion.a
        + np.cross(motion.turn, motion.arms)
        + 2.0 * np.cross(w, motion.shapes @ motion.v)
        + np.cross(w, np.cross(w, motion.arms))
    )
    expected = motion.by_shapes(motion.masses[:, None] * accelerations)
    gyro, softening = inertia.turning(w)
    coriolis = w @ inertia.gyroscopic_rows(motion.v)
    centrifugal = 0.5 * w @ at.inertia_slope(w)
    found = inertia.mass @ motion.a + motion.turn @ at.coupling - 2.0 * coriolis - centrifugal
    assert found == pytest.approx(expected, rel=1e-11)
    assert gyro @ motion.v == pytest.approx(coriolis, rel=1e-12)
    assert gyro == pytest.approx(-gyro.T, abs=1e-13)
    there = inertia.at(np.zeros_like(motion.q)).inertia_slope(w)
    assert softening @ motion.q == pytest.approx(centrifugal - 0.5 * w @ there, rel=1e-11)


@each_cloud
def test_slopes_of_the_angular_momentum(body: Cloud) -> None:
    """By q of I w and of A v: exact central differences, for they are polynomials of degree 2."""
    motion, inertia = Motion(body, seed=5), Inertia(body.frame)

    def terms(q: Array) -> tuple[Array, Array]:
        at = inertia.at(q)
        return at.inertia @ motion.spin, at.coupling @ motion.v

    moved = [(terms(motion.q + e), terms(motion.q - e)) for e in np.eye(len(motion.q))]
    by_inertia = np.stack([(a[0] - b[0]) / 2.0 for a, b in moved], axis=-1)
    by_coupling = np.stack([(a[1] - b[1]) / 2.0 for a, b in moved], axis=-1)
    slope = inertia.at(motion.q).inertia_slope(motion.spin)
    assert slope == pytest.approx(by_inertia, abs=1e-11)
    assert inertia.gyroscopic_rows(motion.v) == pytest.approx(by_coupling, abs=1e-11)


def test_without_coupling_the_body_turns_as_at_rest() -> None:
    body = cloud()
    motion, inertia = Motion(body), Inertia(body.frame, coupled=False)
    at = inertia.at(motion.q)
    assert at.inertia == pytest.approx(body.frame.inertia, rel=1e-14)
    assert not at.coupling.any()
    assert not at.inertia_slope(motion.spin).any()
    assert not np.any(inertia.turning(motion.spin))
    assert inertia.mass == pytest.approx(np.eye(4), abs=1e-13)


def test_batches_are_rows() -> None:
    body = cloud()
    inertia, rng = Inertia(body.frame), np.random.default_rng(8)
    q, spin = rng.normal(size=(5, 4)), rng.normal(size=(5, 3))
    every, turning = inertia.at(q), inertia.turning(spin)
    for i in range(5):
        one = inertia.at(q[i])
        assert every.inertia[i] == pytest.approx(one.inertia, rel=1e-13)
        assert every.coupling[i] == pytest.approx(one.coupling, rel=1e-12, abs=1e-13)
        slope = one.inertia_slope(spin[i])
        assert every.inertia_slope(spin)[i] == pytest.approx(slope, rel=1e-12, abs=1e-13)
        for of_all, of_one in zip(turning, inertia.turning(spin[i]), strict=True):
            assert of_all[i] == pytest.approx(of_one, rel=1e-12, abs=1e-13)
