"""What the records accept, store and refuse."""

import math

import numpy as np
import pytest
from energy_laws import yeoh_energy
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo import energy
from fenics_defo.errors import MaterialError

GOOD = {"young": 1e6, "poisson": 0.3, "density": 1e3}
RUBBER = {"c10": 1e5, "c01": 1e4, "bulk": 1e7, "density": 1e3}
TWO_MODULI = [energy.LinearElastic, energy.StVenantKirchhoff, energy.NeoHookean]
ANY_FLOAT = st.floats(allow_nan=True, allow_infinity=True)


@settings(deadline=None, max_examples=100)
@given(young=ANY_FLOAT, poisson=ANY_FLOAT, density=ANY_FLOAT)
def test_a_record_exists_exactly_for_constants_in_their_ranges(young, poisson, density):
    good = 0 < young < math.inf and -1 < poisson < 0.5 and 0 < density < math.inf
    constants = {"young": young, "poisson": poisson, "density": density}
    if good:
        assert energy.NeoHookean(**constants).linearised() == (young, poisson)
    else:
        with pytest.raises(MaterialError):
            energy.NeoHookean(**constants)


@settings(deadline=None, max_examples=100)
@given(values=st.lists(ANY_FLOAT, min_size=1, max_size=8))
def test_a_field_is_checked_in_every_cell_and_its_worst_value_named(values):
    outside = [v for v in values if not 0 < v < math.inf]
    if not outside:
        assert energy.StVenantKirchhoff(**GOOD | {"density": np.array(values)}).density.size
        return
    with pytest.raises(MaterialError, match=r"^density must be positive") as caught:
        energy.StVenantKirchhoff(**GOOD | {"density": np.array(values)})
    row = int(str(caught.value).split("[")[2].split("]")[0])
    if all(map(math.isfinite, outside)):
        assert values[row] == min(values)
    else:
        assert not math.isfinite(values[row])
    assert f"the worst of {len(outside)} such" in str(caught.value)


@pytest.mark.parametrize("law", TWO_MODULI)
@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("young", -1.0, r"young must be positive and finite \[Pa\], got -1.0"),
        ("young", math.nan, "got nan"),
        ("poisson", 0.5, "strictly between -1 and 0.5"),
        ("poisson", [0.3, 0.7, 0.6], r"poisson\[1\] = 0.7, the worst of 2 such among 3 values"),
        ("density", True, "one real number"),
        ("density", "steel", "'steel'"),
        ("density", 1 + 2j, "one real number"),
        ("density", [], "one real number"),
        ("density", [[1.0]], "one real number"),
        ("density", [[1.0], [2.0, 3.0]], "one real number"),
        ("young", None, "None"),
        ("young", 10**400, "one real number"),
    ],
)
def test_a_wrong_constant_is_named(law, key, value, said):
    with pytest.raises(MaterialError, match=said) as caught:
        law(**GOOD | {key: value})
    assert key in str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"c10": -1e5}, r"c10 \+ c01 must be positive"),
        ({"c01": math.inf}, "c01 must be finite"),
        ({"bulk": 0.0}, "bulk must be positive"),
        ({"c10": np.array([1e5, -2e4, 1e5])}, r"c10 \+ c01\[1\] = -10000.0"),
    ],
)
def test_wrong_constants_of_mooney_rivlin(change, said):
    with pytest.raises(MaterialError, match=said):
        energy.MooneyRivlin(**RUBBER | change)


def test_fields_of_different_lengths_are_refused():
    with pytest.raises(MaterialError, match="young has 2, density has 3 values"):
        energy.NeoHookean(young=np.ones(2), poisson=0.3, density=np.ones(3))
    with pytest.raises(MaterialError, match="equal lengths"):
        energy.NeoHookean.from_lame(mu=np.ones(2), lmbda=np.ones(3), density=1.0)
    with pytest.raises(MaterialError, match="equal lengths"):
        energy.IsotropicEnergy(yeoh_energy, {"c1": np.ones(2)}, density=np.ones(3))


@pytest.mark.parametrize(
    ("mu", "lmbda", "said"),
    [(-1.0, 1.0, "mu must"), (1.0, -0.7, "bulk modulus"), (1.0, math.nan, "lmbda must")],
)
def test_wrong_lame_constants(mu, lmbda, said):
    with pytest.raises(MaterialError, match=said):
        energy.StVenantKirchhoff.from_lame(mu=mu, lmbda=lmbda, density=1.0)


def test_a_stored_field_is_a_read_only_copy():
    young = np.array([1.0, 2.0])
    material = energy.LinearElastic(young=young, poisson=0.0, density=1)
    young[0] = -5.0
    assert material.young[0] == 1.0
    assert isinstance(material.density, float)
    with pytest.raises(ValueError, match="read-only"):
        material.young[0] = 3.0


def test_records_compare_and_hash_by_value():
    one = energy.NeoHookean(young=[1.0, 2.0], poisson=0.0, density=1)
    same = energy.NeoHookean(young=np.array([1, 2]), poisson=-0.0, density=1.0)
    assert one == same
    assert hash(one) == hash(same)
    assert one != energy.NeoHookean(young=[1.0, 2.5], poisson=0.0, density=1.0)
    assert one != energy.StVenantKirchhoff(young=[1.0, 2.0], poisson=0.0, density=1.0)
    assert energy.MooneyRivlin(**RUBBER) == energy.MooneyRivlin(**RUBBER)


def test_records_are_frozen():
    with pytest.raises(AttributeError):
        energy.NeoHookean(**GOOD).young = 2.0
    with pytest.raises(TypeError):
        energy.IsotropicEnergy(yeoh_energy, {"c1": 1.0}, density=1.0).constants["c1"] = 2.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((1.0, {}), "must be a function"),
        ((yeoh_energy, [1.0]), "must map names to numbers"),
        ((yeoh_energy, {1: 1.0}), "must map names to numbers"),
        ((yeoh_energy, {"c1": math.nan}), "c1 must be finite"),
    ],
)
@pytest.mark.parametrize("kind", [energy.IsotropicEnergy, energy.HyperelasticEnergy])
def test_wrong_arguments_of_a_users_energy(kind, arguments, said):
    with pytest.raises(MaterialError, match=said):
        kind(*arguments, density=1.0)
