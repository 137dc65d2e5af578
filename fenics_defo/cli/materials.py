"""Which material the body has, and how to say so: nothing is assumed in silence."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fenics_defo.cli.number_text import constants_text
from fenics_defo.energy import Invertible, Law, StVenantKirchhoff, read_materials

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7850.0}

_LAWS = {
    "LinearElastic": "linear",
    "Corotational": "corotational",
    "StVenantKirchhoff": "st-venant-kirchhoff",
    "NeoHookean": "neo-hookean",
    "MooneyRivlin": "mooney-rivlin",
    "MassSpring": "mass-spring",
}


@dataclass(frozen=True, slots=True)
class ChosenMaterials:
    """The materials of a body and where they come from.

    Args:
        by_region: region (None: everywhere) -> material.
        source: in a few words, ``steel (default)`` for instance.
        assumed: names of the constants that nobody gave, where others were given.
        notes: what the user should know about the choice.
    """

    by_region: Mapping[str | None, Law]
    source: str
    assumed: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """One line for each region: its constants with units."""
        return [
            f"{'' if region is None else f'{region}: '}"
            + constants_text(constants_of(material), assumed=self.assumed)
            for region, material in self.by_region.items()
        ]

    def records(self) -> list[dict[str, Any]]:
        """One JSON object for each region: law, constants, region, source."""
        return [
            {
                "region": region,
                "law": law_of(material),
                **constants_of(material),
                **({"invertible": True} if isinstance(material, Invertible) else {}),
                "source": self.source,
            }
            for region, material in self.by_region.items()
        ]


def given_materials(
    *, file: str | None, constants: Mapping[str, float | None]
) -> ChosenMaterials | None:
    """Return the materials of the command line, checked; None where it names none.

    Args:
        file: TOML file of ``[[material]]`` tables.
        constants: young [Pa], poisson [-], density [kg/m3], those given.

    Raises:
        MaterialError: a constant out of range, or a file at fault.
    """
    if file is not None:
        return ChosenMaterials(read_materials(file), f"from {file}")
    given = {name: value for name, value in constants.items() if value is not None}
    if not given:
        return None
    material = StVenantKirchhoff(**{**STEEL, **given})
    source = f"from {', '.join(f'--{name}' for name in given)}"
    return ChosenMaterials({None: material}, source, assumed=frozenset(STEEL.keys() - given))


def settled_materials(
    given: ChosenMaterials | None, of_mesh: Mapping[str | None, Law]
) -> ChosenMaterials:
    """Return what holds: the command line before the mesh file, and that before steel."""
    if given is not None and of_mesh:
        note = f"the material of the mesh file is replaced by that {given.source}"
        if given.assumed:
            assumed = {name: STEEL[name] for name in STEEL if name in given.assumed}
            note += f", with {constants_text(assumed)} of steel"
        return dataclasses.replace(given, notes=(note,))
    if given is not None:
        return given
    if of_mesh:
        return ChosenMaterials(of_mesh, "from the mesh file")
    return ChosenMaterials({None: StVenantKirchhoff(**STEEL)}, "steel (default)")


def constants_of(material: Any) -> dict[str, float]:
    """Return the numbers that define a material, by name."""
    values = {f.name: getattr(material, f.name) for f in dataclasses.fields(material) if f.init}
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}
    if isinstance(material, Invertible):
        return constants_of(material.material) | numbers
    return numbers


def law_of(material: Any) -> str:
    """Return the name that material tables give the law."""
    if isinstance(material, Invertible):
        return law_of(material.material)
    return _LAWS.get(type(material).__name__, type(material).__name__)
