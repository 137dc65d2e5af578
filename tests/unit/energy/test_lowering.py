"""Lists of operations give the energies, stresses and tangents that UFL's own derivatives give."""

import numpy as np
import pytest
import ufl
from energy_laws import ALL, ISOTROPIC, NEO_HOOKEAN, YEOH, deformations, name, piola, psi, tangents

from fenics_defo import energy
from fenics_defo.energy import evaluate
from fenics_defo.energy.lowering import lower_general, lower_isotropic, upper_pairs
from fenics_defo.energy.tape import Scalar, Tape
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.operations import Machine

COUNT = 1000


def run(lowered, material, *inputs):
    """Outputs (o, b) for the variables' values, (b,) each."""
    first = lowered.variables
    parameters = {first + k: material.parameters[n] for k, n in enumerate(lowered.names)}
    machine = Machine(lowered.listing, inputs[0].shape, parameters)
    machine.inputs[:] = inputs
    return machine.run()


def within(found, expected, tolerance=1e-12):
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("material", ALL, ids=name)
def test_a_general_law_runs_as_operations(material):
    F = deformations(COUNT)
    out = run(lower_general(material), material, *F.reshape(-1, 9).T)
    within(out[0], psi(material, F))
    within(out[1:10].T, piola(material, F).reshape(-1, 9))
    i, j = np.array(upper_pairs(9)).T
    within(out[10:].T, tangents(material, F).reshape(-1, 9, 9)[:, i, j])


@pytest.mark.parametrize("material", ISOTROPIC, ids=name)
def test_an_isotropic_law_runs_as_operations_of_its_invariants(material):
    I1, I2, J = (x * np.random.default_rng(3).uniform(0.8, 1.3, COUNT) for x in (3.0, 3.0, 1.0))
    out = run(lower_isotropic(material), material, I1, I2, J)
    symbols = [ufl.variable(ufl.as_ufl(1.0)) for _ in range(3)]
    psi_of = ufl.as_ufl(material.invariant_energy(*symbols, material.parameters))
    values = dict(zip(symbols, (I1, I2, J), strict=True))
    first = [ufl.diff(psi_of, x) for x in symbols]
    second = [ufl.diff(first[i], symbols[j]) for i, j in upper_pairs(3)]
    for found, expression in zip(out, [psi_of, *first, *second], strict=True):
        expected = evaluate(expression, values)
        assert np.abs(found - expected).max() <= 1e-12 * max(np.abs(expected).max(), 1e-9)


FUNCTIONS = {
    "quotient": lambda x, y: x / (1 + y**2) - 2 / x,
    "powers": lambda x, y: x**3.7 + y**-2 + x**0.5 + y**4 + x**y + 2**y,
    "logarithms": lambda x, y: ufl.ln(x) * ufl.exp(-y),
    "circle": lambda x, y: ufl.sin(x) * ufl.cos(y) + ufl.tan(x / 3) + ufl.atan2(y, x),
    "inverse": lambda x, y: ufl.asin(x / 4) + ufl.acos(y / 4) + ufl.atan(x * y),
    "hyperbola": lambda x, y: ufl.sinh(x) + ufl.cosh(y) * ufl.tanh(x),
    "choices": lambda x, y: (
        ufl.conditional(ufl.And(ufl.lt(x, y), ufl.Not(ufl.gt(x, 1.2))), x**2, ufl.sqrt(y))
        + ufl.max_value(x, y) * ufl.min_value(x, 1.1)
        + abs(x - y)
    ),
}


@pytest.mark.parametrize("label", FUNCTIONS)
def test_each_function_is_written_and_differentiated_as_by_ufl(label):
    law = energy.IsotropicEnergy(lambda I1, I2, J, c: FUNCTIONS[label](I1, J), {}, density=1.0)
    x, y = np.random.default_rng(1).uniform(0.6, 1.8, (2, 50))
    out = run(lower_isotropic(law), law, x, np.ones(50), y)
    X, Y = ufl.variable(ufl.as_ufl(1.0)), ufl.variable(ufl.as_ufl(1.0))
    f = FUNCTIONS[label](X, Y)
    expected = [f, ufl.diff(f, X), ufl.diff(f, Y)]
    expected += [ufl.diff(expected[1], X), ufl.diff(expected[1], Y), ufl.diff(expected[2], Y)]
    for row, expression in zip((0, 1, 3, 4, 6, 9), expected, strict=True):
        within(out[row], evaluate(expression, {X: x, Y: y}), 1e-12)


def test_what_a_stress_and_a_tangent_share_is_written_once():
    isotropic, general = lower_isotropic(NEO_HOOKEAN), lower_general(NEO_HOOKEAN)
    codes = isotropic.listing.codes.tolist()
    assert codes.count(11) == 1  # one logarithm for the energy and all its derivatives
    assert general.listing.codes.size < 600  # 55 outputs of nine inputs


def test_equal_operations_are_one_entry_whatever_the_order_of_a_sum():
    tape = Tape(2)
    x, y = tape.inputs
    first, again = x * y + 1.0, 1.0 + y * x
    assert isinstance(first, Scalar)
    assert isinstance(again, Scalar)
    assert first is again
    assert tape.listing([first]).codes.size == 2


def test_numbers_are_folded_and_idle_operations_left_out():
    tape = Tape(1)
    (x,) = tape.inputs
    assert x * 1.0 is x
    assert x + 0.0 is x
    assert x * 0.0 == 0.0
    assert x**1.0 is x
    assert tape.apply("exp", 0.0) == 1.0
    listing = tape.listing([x * (2.0 + 3.0)])
    assert listing.constants.tolist() == [5.0]
    assert listing.codes.size == 1


def test_a_derivative_by_an_input_that_does_not_occur_is_zero():
    tape = Tape(2)
    x, y = tape.inputs
    slopes = tape.gradient(x**2, [x, y])
    assert slopes[1] == 0.0
    assert tape.gradient(3.0, [x, y]) == [0.0, 0.0]


def test_an_energy_without_a_value_at_a_point_is_refused():
    strange = energy.HyperelasticEnergy(lambda F, c: ufl.bessel_J(0, F[0, 0]), {}, density=1.0)
    with pytest.raises(MaterialError, match="no value at one point"):
        lower_general(strange)


def test_parameters_stay_open():
    lowered = lower_isotropic(YEOH)
    assert lowered.names == ("c1", "c2", "c3", "bulk")
    softer = energy.IsotropicEnergy(
        YEOH.function, {n: 0.5 * c for n, c in YEOH.constants.items()}, density=1.0
    )
    at = [np.array([3.3]), np.array([3.2]), np.array([1.1])]
    np.testing.assert_allclose(run(lowered, YEOH, *at), 2.0 * run(lowered, softer, *at), rtol=1e-14)
