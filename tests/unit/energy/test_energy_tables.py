"""Materials from TOML tables: what is read, and what each mistake is answered."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo import energy
from fenics_defo.energy import material_from_table, read_materials
from fenics_defo.errors import MaterialError

MODULI = {"young": 2e5, "poisson": 0.25, "density": 1000}
RUBBER = {"law": "mooney-rivlin", "c10": 1.0, "c01": 0.5, "bulk": 100, "density": 1.0}


@pytest.mark.parametrize(
    ("law", "kind"),
    [
        ("linear", energy.LinearElastic),
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


def without(table, key):
    return {k: v for k, v in table.items() if k != key}


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (MODULI | {"law": "neohookean"}, r"got 'neohookean' \(did you mean \"neo-hookean\"\?\)"),
        (MODULI | {"law": 3}, "law must be one of .*got 3"),
        (MODULI | {"law": ["linear"]}, "law must be one of"),
        (MODULI | {"law": "corotational"}, "'corotational' is not computed by this version"),
        ({"law": "mass-spring"}, "'mass-spring' is not computed by this version"),
        (MODULI | {"invertible": True}, "invertible = true is not computed by this version"),
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
    ["region", "law", "young", "poisson", "density", "mu", "lambda", "c10", "invertible"]
)


@settings(deadline=None, max_examples=60)
@given(table=st.dictionaries(KEYS | st.text(max_size=5), JSON_LIKE, max_size=6))
def test_no_table_ends_in_another_error(table):
    try:
        region, material = material_from_table(table)
    except MaterialError:
        return
    assert region is None or isinstance(region, str)
    assert isinstance(material, energy.Material)


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
