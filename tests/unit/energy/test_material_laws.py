"""A law that a file holds answers, with NumPy alone, what UFL and the point laws answer."""

import numpy as np
import pytest
from energy_laws import (
    ALL,
    FIBRE,
    ISOTROPIC,
    LINEAR,
    MOONEY_RIVLIN,
    NEO_HOOKEAN,
    YEOH,
    deformations,
    name,
    piola,
    psi,
    tangents,
)

from fenics_defo import energy
from fenics_defo.errors import FileFormatError, MaterialError
from fenics_defo.runtime.archive import read_archive, write_archive
from fenics_defo.runtime.laws import MaterialLaw

COROTATIONAL = energy.Corotational(young=2.0, poisson=0.3, density=1.0)
INVERTIBLE = [energy.Invertible(law, threshold=0.3, tangent="exact") for law in ISOTROPIC]
POINT_LAWS = [COROTATIONAL, *INVERTIBLE, energy.Invertible(NEO_HOOKEAN)]


def kind(material):
    """A name that is the same in each process, as a user's function in a law's text is not."""
    return type(material).__name__


def kernel(material, count):
    law = energy.material_law(material)
    return law.kernel([material.parameters[n] for n in law.names], count)


def within(found, expected, tolerance=1e-12):
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("material", ALL, ids=name)
def test_stress_and_tangent_are_those_of_ufl_at_a_thousand_gradients(material):
    F = deformations(1000)
    own = kernel(material, len(F))
    own.gradients[:] = F.reshape(-1, 9).T
    within(own.energy(), psi(material, F))
    within(own.stress().T, piola(material, F).reshape(-1, 9))
    stress, tangent = own.stress_and_tangent()
    within(stress.T, piola(material, F).reshape(-1, 9))
    within(tangent, tangents(material, F).reshape(-1, 9, 9))


@pytest.mark.parametrize("material", POINT_LAWS, ids=kind)
def test_point_laws_are_those_of_the_full_simulator_inside_out_too(material):
    F = np.eye(3) + np.random.default_rng(4).uniform(-0.7, 0.7, (300, 3, 3))
    assert (np.linalg.det(F) < 0).any()
    own = kernel(material, len(F))
    own.gradients[:] = F.reshape(-1, 9).T
    expected = material.respond(F, material.parameters)
    within(own.energy(), expected.energy)
    within(own.stress().T, expected.stress.reshape(-1, 9))
    # The continuation's third derivatives are differences, which round-off enters.
    within(own.stress_and_tangent()[1], expected.tangent.reshape(-1, 9, 9), 1e-9)


@pytest.mark.parametrize("material", [*ISOTROPIC, FIBRE, LINEAR], ids=name)
def test_a_kernel_answers_again_at_other_gradients(material):
    first, second = deformations(20, seed=1), deformations(20, seed=2)
    own = kernel(material, 20)
    answers = []
    for F in (first, second, first):
        own.gradients[:] = F.reshape(-1, 9).T
        answers.append([x.copy() for x in own.stress_and_tangent()])
    for again, once in zip(answers[2], answers[0], strict=True):
        np.testing.assert_array_equal(again, once)
    assert not np.allclose(answers[0][0], answers[1][0])


def test_parameters_may_differ_from_point_to_point():
    F, law = deformations(6), energy.material_law(NEO_HOOKEAN)
    factors = np.linspace(1.0, 2.0, 6)
    own = law.kernel([NEO_HOOKEAN.parameters[n] * factors for n in law.names], 6)
    own.gradients[:] = F.reshape(-1, 9).T
    within(own.energy(), factors * psi(NEO_HOOKEAN, F))
    within(own.stress(), factors * piola(NEO_HOOKEAN, F).reshape(-1, 9).T)


@pytest.mark.parametrize("material", [MOONEY_RIVLIN, YEOH, FIBRE, *POINT_LAWS[:2]], ids=kind)
def test_a_law_goes_through_a_file(material, tmp_path):
    law = energy.material_law(material)
    path = tmp_path / "law.npz"
    write_archive(path, law.arrays(), kind="law", version=1, units={})
    arrays = read_archive(path, kind="law", version=1, required=MaterialLaw.SPECS)
    again = MaterialLaw.from_arrays(arrays)
    parameters, F = [material.parameters[n] for n in law.names], deformations(9)
    kernels = [one.kernel(parameters, 9) for one in (law, again)]
    for one in kernels:
        one.gradients[:] = F.reshape(-1, 9).T
    np.testing.assert_array_equal(kernels[0].stress(), kernels[1].stress())


def test_a_law_that_does_not_fit_together_is_refused():
    good = energy.material_law(NEO_HOOKEAN)
    arrays = good.arrays()
    with pytest.raises(FileFormatError, match="'plastic'"):
        MaterialLaw.from_arrays(arrays | {"kind": np.array("plastic")})
    with pytest.raises(FileFormatError, match="lacks"):
        MaterialLaw.from_arrays(arrays | {"kind": np.array("general")})
    with pytest.raises(FileFormatError, match="lacks"):
        MaterialLaw.from_arrays(arrays | {"names": np.array(["mu"])})
    with pytest.raises(FileFormatError, match="threshold"):
        MaterialLaw.from_arrays(arrays | {"threshold": np.array(0.5)})


def test_springs_have_no_energy_at_a_point():
    with pytest.raises(MaterialError, match="MassSpring"):
        energy.material_law(energy.MassSpring(young=1.0, density=1.0))
