"""Materials from TOML tables: what is read, and what each mistake is answered."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo import energy
from fenics_defo.energy import material_from_table, read_materials
from fenics_defo.errors import MaterialError

MODULI = {"young": 2e5, "poisson": 0.25, "density": 1000}
INVERTIBLE = MODULI | {"invertible": True}
SPRINGS = {"law": "mass-spring", "young": 2e5, "density": 1000}
RUBBER = {"law": "mooney-rivlin", "c10": 1.0, "c01": 0.5, "bulk": 100, "density": 1.0}


@pytest.mark.parametrize(
    ("law", "kind"),
    [
        ("linear", energy.LinearElastic),
        ("corotational", energy.Corotational),
        ("st-venant-kirchhoff", energy.StVenantKirchhoff),
        ("neo-hookean", energy.NeoHookean),
    ],
)
def test_each_law_is_read(law, kind):
    region, material = material_from_table({"law": law, "region": "beam", **MODULI})
    assert (region, material) == ("beam", kind(young=2e5, poisson=0.25, density=1000.0))
    lame = {"law": law, "mu": 8e4, "lambda": 8e4, "density": 1000.0, "invertible": False}
    assert material_from_table(lame) == (None, kind.from_lame(mu=8e4, lmbda=8e4, density=1000.0))


def test_mooney_rivlin_a_numbered_region_and_the_default_law_are_read():
    assert material_from_table(RUBBER | {"region": 7}) == (
        "7",
        energy.MooneyRivlin(c10=1.0, c01=0.5, bulk=100.0, density=1.0),
    )
    assert isinstance(material_from_table(MODULI)[1], energy.StVenantKirchhoff)


@pytest.mark.parametrize("tangent", ["exact", "definite", "approximate"])
def test_corotational_takes_its_kind_of_tangent(tangent):
    _, material = material_from_table(MODULI | {"law": "corotational", "tangent": tangent})
    assert material.tangent == tangent


@pytest.mark.parametrize("table", [MODULI, MODULI | {"law": "neo-hookean"}, RUBBER])
def test_invertible_wraps_the_law_of_the_table(table):
    _, material = material_from_table(table | {"invertible": True})
    assert material == energy.Invertible(material_from_table(table)[1], threshold=0.1)
    more = {"invertible": True, "threshold": 0.3, "tangent": "exact"}
    _, other = material_from_table(table | more)
    assert other == energy.Invertible(material.material, threshold=0.3, tangent="exact")
    assert other != material


def test_corotational_stands_inversion_as_it_is():
    _, material = material_from_table(INVERTIBLE | {"law": "corotational", "threshold": 0.2})
    assert material == energy.Corotational(**MODULI, tangent="definite")


def test_springs_are_read_and_an_ineffective_poisson_is_logged(caplog):
    region, material = material_from_table(SPRINGS)
    assert (region, material) == (None, energy.MassSpring(young=2e5, density=1000.0))
    assert material_from_table(SPRINGS | {"poisson": 0.25})[1] == material
    assert not caplog.records
    assert material_from_table(SPRINGS | {"poisson": 0.3})[1] == material
    assert "poisson = 0.3 has no effect" in caplog.text


def without(table, key):
    return {k: v for k, v in table.items() if k != key}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (MODULI | {"law": "neohookean"}, r"got 'neohookean' \(did you mean \"neo-hookean\"\?\)"),
        (MODULI | {"law": 3}, "law must be one of .*got 3"),
        (MODULI | {"law": ["linear"]}, "law must be one of"),
        (MODULI | {"law": "corotational", "tangent": "warped"}, "tangent must be .*got 'warped'"),
        (MODULI | {"law": "corotational", "tangent": ["exact"]}, "tangent must be"),
        (MODULI | {"tangent": "exact"}, "'st-venant-kirchhoff' has no key 'tangent'"),
        (INVERTIBLE | {"tangent": "approximate"}, 'tangent must be "definite" or "exact"'),
        (MODULI | {"law": "linear", "invertible": True}, "'linear' has no invertible form"),
        (SPRINGS | {"invertible": True}, "'mass-spring' has no invertible form"),
        (SPRINGS | {"lambda": 1.0}, "'mass-spring' has no key 'lambda'"),
        (INVERTIBLE | {"threshold": 1.0}, "threshold must be a number between 0 and 1.*got 1.0"),
        (INVERTIBLE | {"threshold": math.nan}, "threshold must be a number between 0 and 1"),
        (INVERTIBLE | {"threshold": "0.1"}, "threshold must be a number, got '0.1'"),
        (
            INVERTIBLE | {"law": "corotational", "threshold": -1},
            "threshold must be a number between 0 and 1",
        ),
        (MODULI | {"invertible": 1}, "invertible must be true or false"),
        (MODULI | {"threshold": 0.1}, "threshold belongs to invertible"),
        (MODULI | {"yuong": 1.0}, r"no key 'yuong' \(did you mean \"young\"\?\)"),
        (MODULI | {"c10": 1.0}, "'st-venant-kirchhoff' has no key 'c10'.*its keys are"),
        (RUBBER | {"young": 1.0}, "'mooney-rivlin' has no key 'young'"),
        (MODULI | {"mu": 1.0}, "has mu beside young or poisson"),
        (without(MODULI, "young"), "needs the key young"),
        (without(MODULI, "density"), "needs the key density"),
        (without(RUBBER, "bulk"), "needs the key bulk"),
        ({"mu": 1.0, "density": 1.0}, "needs the key lambda"),
        (MODULI | {"young": "2e5"}, "young must be a number, got '2e5'"),
        (MODULI | {"young": True}, "young must be a number, got True"),
        (MODULI | {"young": 10**400}, "young is too large"),
        (MODULI | {"poisson": 0.5}, "poisson must lie strictly between"),
        (MODULI | {"density": math.nan}, "density must be positive"),
        (MODULI | {"region": True}, "region must be the name or the number"),
        (MODULI | {"region": " "}, "region must be the name or the number"),
        (["young"], "must be a table"),
    ],
)
def test_each_mistake_gets_one_sentence_that_names_it(table, said):
    with pytest.raises(MaterialError, match=said) as caught:
        material_from_table(table)
    assert "[[material]]" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_region_of_a_mistake_is_named():
    with pytest.raises(MaterialError, match=r"^\[\[material\]\] of region 'beam': young must"):
        material_from_table(MODULI | {"region": "beam", "young": -1})


JSON_LIKE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)
KEYS = st.sampled_from(
    ["region", "law", "young", "poisson", "density", "mu", "lambda", "c10", "invertible", "tangent"]
)


@settings(deadline=None, max_examples=60)
@given(table=st.dictionaries(KEYS | st.text(max_size=5), JSON_LIKE, max_size=6))
def test_no_table_ends_in_another_error(table):
    try:
        region, material = material_from_table(table)
    except MaterialError:
        return
    assert region is None or isinstance(region, str)
    assert isinstance(material, energy.Material | energy.PointLaw | energy.MassSpring)


def write(tmp_path, text):
    path = tmp_path / "materials.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_a_file_gives_its_materials_in_order(tmp_path):
    path = write(
        tmp_path,
        """
        [mesh]
        file = "beam.msh"
        [[material]]
        region = "core"
        law = "neo-hookean"
        young = 1e6
        poisson = 0.4
        density = 900
        [[material]]
        mu = 3.0
        lambda = 2.0
        density = 1.0
        """,
    )
    materials = read_materials(path)
    assert list(materials) == ["core", None]
    assert materials["core"] == energy.NeoHookean(young=1e6, poisson=0.4, density=900)
    assert materials[None] == energy.StVenantKirchhoff.from_lame(mu=3.0, lmbda=2.0, density=1.0)
    assert read_materials(str(path)) == materials


TABLE = "[[material]]\nyoung = 1.0\npoisson = 0.1\ndensity = 1.0\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no such table"),
        ("[material]\nyoung = 1.0", r"needs one \[\[material\]\] table .*has material = dict"),
        ("material = [1]", "must be a table"),
        ("[[material]]\nyoung = = 1\n", "not valid TOML: .*line 2"),
        ("a = " + "[" * 5000, "not valid TOML"),
        ("a = 2" + "0" * 5000, "not valid TOML"),
        (b"a = '\xff'", "not UTF-8"),
        (TABLE + TABLE, "two .* tables without region"),
        (TABLE + "region = 'a'\n" + TABLE + "region = 'a'", "two .* tables of region 'a'"),
        (TABLE + "region = 'a'\nyuong = 1", r"\[\[material\]\] of region 'a'.*did you mean"),
    ],
)
def test_each_mistake_of_a_file_names_the_file(tmp_path, text, said):
    path = write(tmp_path, text)
    with pytest.raises(MaterialError, match=said) as caught:
        read_materials(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(MaterialError, match=r"none\.toml: cannot be read \(No such file"):
        read_materials(tmp_path / "none.toml")
    with pytest.raises(MaterialError, match="cannot be read"):
        read_materials(tmp_path)
