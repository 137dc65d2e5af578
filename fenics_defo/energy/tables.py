"""Materials from the ``[[material]]`` tables of a TOML file."""

import difflib
import logging
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from fenics_defo.energy.corotational import Corotational
from fenics_defo.energy.invertible import THRESHOLD, Invertible, check_threshold
from fenics_defo.energy.law import Law
from fenics_defo.energy.mass_spring import POISSON, MassSpring
from fenics_defo.energy.material import IsotropicMaterial
from fenics_defo.energy.materials import LinearElastic, MooneyRivlin, NeoHookean, StVenantKirchhoff
from fenics_defo.errors import MaterialError

#: The law of a table that names none: it takes Young's modulus and Poisson's ratio, stands any
#: rotation, and has the same modes about the rest shape as every other law.
DEFAULT_LAW = "st-venant-kirchhoff"

_TWO_MODULI: dict[str, type[LinearElastic | Corotational | StVenantKirchhoff | NeoHookean]] = {
    "linear": LinearElastic,
    "corotational": Corotational,
    "st-venant-kirchhoff": StVenantKirchhoff,
    "neo-hookean": NeoHookean,
}
_LAWS = (*_TWO_MODULI, "mooney-rivlin", "mass-spring")
_COMMON_KEYS = ("region", "law", "density", "invertible", "threshold")
_OWN_KEYS: dict[str, tuple[str, ...]] = {
    "mooney-rivlin": ("c10", "c01", "bulk"),
    "mass-spring": ("young", "poisson"),
    "corotational": ("young", "poisson", "mu", "lambda", "tangent"),
}
_OF_TWO_MODULI = ("young", "poisson", "mu", "lambda")

_log = logging.getLogger(__name__)


def material_from_table(table: Mapping[str, object]) -> tuple[str | None, Law]:
    """Region and material of one ``[[material]]`` table.

    Keys: ``region`` (name or number of a cell group; left out for all cells), ``law`` ("linear",
    "corotational", "st-venant-kirchhoff", which is the default, "neo-hookean", "mooney-rivlin" or
    "mass-spring"), ``density`` [kg/m³], and ``young`` [Pa] with ``poisson`` [-], or ``mu`` with
    ``lambda`` [Pa]; for "mooney-rivlin" ``c10``, ``c01`` and ``bulk`` [Pa]; for "mass-spring"
    ``young`` (a ``poisson`` beside it is logged as having no effect).

    ``invertible = true`` gives the form of St. Venant-Kirchhoff, neo-Hookean and Mooney-Rivlin that
    stands inversion, with ``threshold`` [-]; "corotational" stands it as it is, and then has the
    definite tangent. ``tangent`` chooses among those of `Corotational` and of `Invertible`.

    Args:
        table: the table, as `tomllib` gives it.

    Returns:
        The region, a number as its digits, or None for all cells; and the material.

    Raises:
        MaterialError: a key is unknown, missing, of the wrong type or out of range, or asks for
            what this version does not compute.
    """
    region = _region(table)
    try:
        return region, _material(table)
    except MaterialError as error:
        place = "for all cells" if region is None else f"of region {region!r}"
        raise MaterialError(f"[[material]] {place}: {error}") from error


def read_materials(path: str | Path) -> dict[str | None, Law]:
    """Materials of the ``[[material]]`` tables of a TOML file, by region.

    Args:
        path: a TOML file; its other tables are left alone.

    Returns:
        Region to material, in the file's order. The key None, if there, is the table without a
        region: all cells that no other table names.

    Raises:
        MaterialError: the file cannot be read, is not TOML, has no ``[[material]]`` table or two
            for one region, or a table is at fault (see `material_from_table`).
    """
    tables = _load(Path(path)).get("material")
    if not isinstance(tables, list) or not tables:
        found = "no such table" if tables is None else f"material = {type(tables).__name__}"
        raise MaterialError(
            f"{path}: needs one [[material]] table (two brackets) for each region, has {found}"
        )
    return materials_from_tables(path, tables)


def materials_from_tables(
    path: str | Path, tables: Sequence[Mapping[str, object]]
) -> dict[str | None, Law]:
    """Materials of ``[[material]]`` tables that have been read, by region.

    Args:
        path: the file they are from, for what is said of them.
        tables: the tables, in the file's order.

    Returns:
        as `read_materials`.

    Raises:
        MaterialError: two tables for one region, or a table is at fault.
    """
    materials: dict[str | None, Law] = {}
    for table in tables:
        try:
            region, material = material_from_table(table)
        except MaterialError as error:
            raise MaterialError(f"{path}: {error}") from error
        if region in materials:
            name = "without region" if region is None else f"of region {region!r}"
            raise MaterialError(f"{path}: has two [[material]] tables {name}; keep one")
        materials[region] = material
    return materials


def _load(path: Path) -> dict[str, object]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise MaterialError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise MaterialError(f"{path}: is not UTF-8 text ({error.reason})") from error
    except ValueError as error:  # TOMLDecodeError, which names the line, or an impossible number
        raise MaterialError(f"{path}: is not valid TOML: {error}") from error
    except RecursionError:
        raise MaterialError(f"{path}: is not valid TOML: nested too deeply") from None


def _region(table: Mapping[str, object]) -> str | None:
    if not isinstance(table, Mapping):
        raise MaterialError(f"a [[material]] must be a table of keys and values, got {table!r}")
    region = table.get("region")
    if region is None:
        return None
    if isinstance(region, int) and not isinstance(region, bool):
        return str(region)
    if not isinstance(region, str) or not region.strip():
        raise MaterialError(
            f"[[material]]: region must be the name or the number of a cell group, got {region!r}; "
            "leave it out for all cells"
        )
    return region


def _material(table: Mapping[str, object]) -> Law:
    law = _law(table)
    invertible = _invertible(table, law)
    _check_keys(table, law, ("tangent",) if invertible else ())
    if law == "mass-spring":
        return _mass_spring(table)
    if law == "corotational":
        _threshold(table)  # checked, and without effect: the law is linear in the stretches
        tangent = table.get("tangent", "definite" if invertible else "exact")
        return _two_moduli(table, law, tangent=tangent)
    if law == "mooney-rivlin":
        c10, c01, bulk = (_number(table, key) for key in ("c10", "c01", "bulk"))
        material: Law = MooneyRivlin(c10=c10, c01=c01, bulk=bulk, density=_number(table, "density"))
    else:
        material = _two_moduli(table, law)
    if not invertible:
        return material
    assert isinstance(material, IsotropicMaterial)
    tangent = table.get("tangent", "definite")
    return Invertible(material, threshold=_threshold(table), tangent=tangent)  # type: ignore[arg-type]


def _two_moduli(table: Mapping[str, object], law: str, **options: object) -> Law:
    density = _number(table, "density")
    lame = [key for key in ("mu", "lambda") if key in table]
    if lame and ("young" in table or "poisson" in table):
        raise MaterialError(
            f"has {lame[0]} beside young or poisson; give young and poisson, or mu and lambda"
        )
    kind = _TWO_MODULI[law]
    if lame:
        mu, lmbda = _number(table, "mu"), _number(table, "lambda")
        return kind.from_lame(mu=mu, lmbda=lmbda, density=density, **options)
    young, poisson = _number(table, "young"), _number(table, "poisson")
    return kind(young=young, poisson=poisson, density=density, **options)  # type: ignore[arg-type]


def _mass_spring(table: Mapping[str, object]) -> MassSpring:
    material = MassSpring(young=_number(table, "young"), density=_number(table, "density"))
    if "poisson" in table and _number(table, "poisson") != POISSON:
        _log.warning(
            "law 'mass-spring' has Poisson's ratio %g by itself; poisson = %g has no effect",
            POISSON,
            _number(table, "poisson"),
        )
    return material


def _law(table: Mapping[str, object]) -> str:
    law = table.get("law", DEFAULT_LAW)
    if law not in _LAWS:
        raise MaterialError(f"law must be one of {_list(_LAWS)}, got {law!r}{_nearest(law, _LAWS)}")
    return str(law)


def _check_keys(table: Mapping[str, object], law: str, more: tuple[str, ...]) -> None:
    allowed = (*_COMMON_KEYS, *_OWN_KEYS.get(law, _OF_TWO_MODULI), *more)
    for key in table:
        if key not in allowed:
            raise MaterialError(
                f"law {law!r} has no key {key!r}{_nearest(key, allowed)}; "
                f"its keys are {', '.join(dict.fromkeys(allowed))}"
            )


def _invertible(table: Mapping[str, object], law: str) -> bool:
    invertible = table.get("invertible", False)
    if not isinstance(invertible, bool):
        raise MaterialError(f"invertible must be true or false, got {invertible!r}")
    if invertible and law in ("linear", "mass-spring"):
        raise MaterialError(
            f"law {law!r} has no invertible form; leave invertible out, or choose another law"
        )
    if "threshold" in table and not invertible:
        raise MaterialError("threshold belongs to invertible = true; leave it out")
    return invertible


def _threshold(table: Mapping[str, object]) -> float:
    return check_threshold(_number(table, "threshold")) if "threshold" in table else THRESHOLD


def _number(table: Mapping[str, object], key: str) -> float:
    """The number under ``key``; its range is the material's affair."""
    if key not in table:
        raise MaterialError(f"needs the key {key}")
    value = table[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise MaterialError(f"{key} must be a number, got {value!r}")
    try:
        return float(value)
    except OverflowError:
        raise MaterialError(f"{key} is too large a number") from None


def _list(names: tuple[str, ...]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _nearest(word: object, known: tuple[str, ...]) -> str:
    near = difflib.get_close_matches(str(word).lower(), known, n=1, cutoff=0.6)
    return f' (did you mean "{near[0]}"?)' if near else ""
