"""Materials and regions of .veg files."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.keyword_text import Section
from fenics_defo.fem.sources.source_mesh import RegionMaterial

Integers = NDArray[np.int64]
Law = tuple[str, dict[str, float]]
WORDS = ("VERTICES", "ELEMENTS", "SET", "MATERIAL", "REGION")


def keyword(section: Section) -> tuple[str, str]:
    """Keyword in capitals and the rest; Vega writes ``*SET name`` and ``*SETname`` alike."""
    head = section.head
    for word in WORDS:
        if head.upper().startswith(word):
            return word, head[len(word) :].strip().strip(",").strip()
    return head.upper(), ""


def assign_materials(
    sections: list[Section], members: dict[str, Integers], *, cells: int, label: str
) -> list[RegionMaterial]:
    """The regions' materials in the file's order; empty if the file has no region.

    Args:
        sections: of the whole file.
        members: rows of the cells of each set.
        cells: number of cells.
        label: to begin a sentence with.

    Raises:
        MeshError: a material or set is unknown, or a cell has no material.
    """
    laws = {
        keyword(section)[1]: _law(section)
        for section in sections
        if keyword(section)[0] == "MATERIAL"
    }
    covered = np.zeros(cells, dtype=bool)
    materials = []
    for section in sections:
        if keyword(section)[0] != "REGION":
            continue
        words = [word.strip() for word in " ".join(section.lines).split(",")]
        if len(words) != 2:
            raise MeshError(f"{section.where} must hold SET, MATERIAL; it holds {words!r}")
        region, material = words
        _require(region, members, section, "set")
        _require(material, laws, section, "material")
        covered[members[region]] = True
        law, constants = laws[material]
        name = None if region == "allElements" else region
        materials.append(RegionMaterial(region=name, law=law, constants=constants))
    if materials and not covered.all():
        first = int(np.flatnonzero(~covered)[0])
        raise MeshError(
            f"{label}: {np.count_nonzero(~covered)} of {cells} cells are in no *REGION and have "
            f"no material, first cell {first + 1}; add a *REGION, or `allElements` before others"
        )
    return materials


def _require(name: str, known: dict, section: Section, thing: str) -> None:
    if name not in known:
        listed = ", ".join(map(repr, known)) or "none"
        raise MeshError(
            f"{section.where} names the {thing} {name!r}, which the file does not define; "
            f"it defines {listed}"
        )


def _law(section: Section) -> Law:
    """Law and constants of a *MATERIAL section.

    ENU is E and ν of the isotropic solid. MOONEYRIVLIN is, in Vega's energy,
    mu10 (J^(-2/3) I1 - 3) + mu01 (J^(-4/3) I2 - 3) + v1 (J - 1)², so bulk = 2 v1.
    """
    kind, _, rest = ",".join(section.lines).partition(",")
    kind = kind.strip().upper()
    if kind not in ("ENU", "MOONEYRIVLIN"):
        raise MeshError(
            f"{section.where}: material {keyword(section)[1]!r} is of type {kind!r}; "
            "ENU and MOONEYRIVLIN are read, give another one or remove the section"
        )
    values = section.numbers([rest])
    needed = ("density, E, nu", 3) if kind == "ENU" else ("density, mu01, mu10, v1", 4)
    if len(values) != needed[1] or not np.all(np.isfinite(values)):
        raise MeshError(
            f"{section.where}: {kind} needs {needed[0]}; the file gives {rest.strip()!r}"
        )
    if kind == "ENU":
        density, young, poisson = values.tolist()
        return "st-venant-kirchhoff", {"young": young, "poisson": poisson, "density": density}
    density, c01, c10, v1 = values.tolist()
    return "mooney-rivlin", {"c10": c10, "c01": c01, "bulk": 2.0 * v1, "density": density}
