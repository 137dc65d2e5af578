"""Cubature: a weighted sum over points whose force is the gradient of its energy."""

import numpy as np
import pytest
import ufl

from fenics_defo import energy
from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.archive import read_archive, write_archive
from fenics_defo.runtime.forces import CubatureForce

R = 5
HOOKE = {"young": 2.0, "poisson": 0.3, "density": 1.0}


def fibre(F, c):
    C = F.T * F
    return c["mu"] / 2 * (ufl.tr(C) - 3 - 2 * ufl.ln(ufl.det(F))) + c["k"] * (C[0, 0] - 1) ** 2


LAWS = {
    "linear": energy.LinearElastic(**HOOKE),
    "st-venant-kirchhoff": energy.StVenantKirchhoff(**HOOKE),
    "neo-hookean": energy.NeoHookean(**HOOKE),
    "mooney-rivlin": energy.MooneyRivlin(c10=0.3, c01=0.2, bulk=3.0, density=1.0),
    "fibre": energy.HyperelasticEnergy(fibre, {"mu": 1.0, "k": 0.5}, density=1.0),
    "corotational": energy.Corotational(**HOOKE),
    "invertible": energy.Invertible(energy.NeoHookean(**HOOKE), threshold=0.3, tangent="exact"),
}


def force_law(*names, points=8, seed=0, correction=None):
    rng = np.random.default_rng(seed)
    laws, parameters, counts = [], [], []
    for name in names:
        material = LAWS[name]
        law = energy.material_law(material)
        laws.append(law)
        counts.append(points)
        values = [material.parameters[n] * rng.uniform(0.5, 2.0, points) for n in law.names]
        parameters.append(np.array(values).reshape(len(law.names), points))
    total = points * len(names)
    gradients = 0.5 * rng.standard_normal((total, 9, R))
    weights = rng.uniform(0.1, 2.0, total)
    return CubatureForce(
        weights, gradients, tuple(laws), tuple(counts), tuple(parameters), correction
    )


def coordinates(*shape, seed=1):
    return 0.05 * np.random.default_rng(seed).standard_normal((*shape, R))


MIXES = [*((name,) for name in LAWS), ("neo-hookean", "corotational", "fibre")]


@pytest.mark.parametrize("names", MIXES, ids="+".join)
def test_the_force_is_the_gradient_of_the_energy_and_the_stiffness_of_the_force(names):
    law = force_law(*names)
    q, d = coordinates(), coordinates(seed=2)
    errors = []
    for h in (4e-2, 2e-2):
        slope = (law.energy(q + h * d) - law.energy(q - h * d)) / (2 * h)
        bend = (law.force(q + h * d) - law.force(q - h * d)) / (2 * h)
        errors.append((abs(slope - law.force(q) @ d), np.abs(bend - law.stiffness(q) @ d).max()))
    scale = abs(law.force(q) @ d), np.abs(law.stiffness(q) @ d).max()
    for coarse, fine, size in zip(*errors, scale, strict=True):
        assert coarse <= 1e-2 * size
        assert fine <= 0.3 * coarse or fine <= 1e-10 * size  # second order


@pytest.mark.parametrize("names", MIXES, ids="+".join)
def test_many_bodies_at_once_are_the_same_as_one_after_the_other(names):
    law, q = force_law(*names), coordinates(2, 3)
    for function in (law.force, law.stiffness, law.energy, law.strains):
        single = np.array([[function(one) for one in row] for row in q])
        np.testing.assert_allclose(function(q), single, rtol=1e-12, atol=1e-13)


def test_batches_of_more_bodies_than_fit_the_buffers_are_the_same(monkeypatch):
    law, q = force_law("neo-hookean", "fibre"), coordinates(7)
    expected = law.force(q), law.stiffness(q)
    monkeypatch.setattr("fenics_defo.runtime.forces.cubature._BUFFER", 3 * law.gradients.size)
    f, K = law.evaluator(q.shape).force_and_stiffness(q)
    np.testing.assert_allclose(f, expected[0], rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(K, expected[1], rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("names", MIXES, ids="+".join)
def test_the_stiffness_is_symmetric_to_the_last_digit(names):
    law = force_law(*names)
    K = law.stiffness(coordinates())
    np.testing.assert_array_equal(K, K.T)
    K = law.stiffness(coordinates(3))
    np.testing.assert_allclose(K, K.transpose(0, 2, 1), rtol=0, atol=1e-15 * np.abs(K).max())


def test_rest_has_no_energy_and_weights_scale_everything():
    law = force_law("neo-hookean")
    twice = CubatureForce(2 * law.weights, law.gradients, law.laws, law.counts, law.parameters)
    q = coordinates()
    assert law.energy(np.zeros(R)) == 0.0
    np.testing.assert_allclose(law.force(np.zeros(R)), 0.0, atol=1e-14)
    np.testing.assert_allclose(twice.force(q), 2 * law.force(q), rtol=1e-14)


def test_a_correction_adds_a_linear_force_and_its_energy():
    E = np.diag(np.arange(1.0, R + 1))
    plain, bent = force_law("fibre"), force_law("fibre", correction=E)
    q = coordinates()
    np.testing.assert_allclose(bent.force(q) - plain.force(q), E @ q, atol=1e-14)
    np.testing.assert_allclose(bent.stiffness(q) - plain.stiffness(q), E, atol=1e-13)
    np.testing.assert_allclose(bent.energy(q) - plain.energy(q), q @ E @ q / 2, atol=1e-14)
    many = coordinates(3)
    np.testing.assert_allclose(bent.force(many) - plain.force(many), many @ E, atol=1e-14)


def test_strains_are_those_of_the_deformed_points():
    law, q = force_law("neo-hookean"), coordinates()
    F = law.deformations(q)
    E = (F.transpose(0, 2, 1) @ F - np.eye(3)) / 2
    np.testing.assert_allclose(law.strains(q), np.linalg.norm(E, axis=(1, 2)), rtol=1e-13)
    assert law.strains(np.zeros(R)).max() == 0.0


@pytest.mark.parametrize("names", MIXES, ids="+".join)
def test_a_law_goes_through_a_file_bit_by_bit(names, tmp_path):
    law, path = force_law(*names, correction=np.eye(R)), tmp_path / "law.npz"
    write_archive(path, law.arrays(), kind="force", version=1, units={})
    again = CubatureForce.from_arrays(
        read_archive(path, kind="force", version=1, required=CubatureForce.ARRAYS)
    )
    q = coordinates()
    np.testing.assert_array_equal(again.force(q), law.force(q))
    np.testing.assert_array_equal(again.stiffness(q), law.stiffness(q))


@pytest.mark.parametrize(
    "change",
    [
        {"weights": lambda x: -x},
        {"weights": lambda x: x[1:]},
        {"gradients": lambda x: x[:, :8]},
        {"correction": lambda x: np.triu(np.ones((R, R)))},
        {"law_points": lambda x: x + 1},
        {"law_points": lambda x: -x},
        {"law_parameters": lambda x: x[1:]},
        {"law_lengths": lambda x: x + 1},
        {"law_lengths": lambda x: x[:, 1:]},
        {"law_codes": lambda x: x + 1000},
        {"law_operands": lambda x: x + 1000},
        {"law_kinds": lambda x: np.array(["x"] * len(x))},
        {"law_inputs": lambda x: x[1:]},
    ],
    ids=lambda change: next(iter(change)),
)
def test_arrays_that_do_not_fit_together_are_refused(change):
    arrays = force_law("neo-hookean", "fibre").arrays()
    name, damage = next(iter(change.items()))
    with pytest.raises((ValueError, FileFormatError)):
        CubatureForce.from_arrays(arrays | {name: damage(arrays[name])})


def test_what_is_not_finite_shows_in_the_force_without_a_warning():
    law = force_law("neo-hookean")
    assert not np.isfinite(law.force(np.full(R, 1e3))).all()
