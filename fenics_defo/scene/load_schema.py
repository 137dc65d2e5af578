"""How ``[[fixed]]`` and ``[[load]]`` tables become their records, with their histories."""

import itertools

from fenics_defo.scene.records import FixedTable, HistoryTable, LoadTable
from fenics_defo.scene.table import AXES, Table, finite

EARTH = (0.0, 0.0, -9.81)
"""Acceleration of a gravity load that gives none [m/s²]."""

_LOAD_KEYS = {
    "gravity": ("vector", "history"),
    "traction": ("region", "vector", "history"),
    "pressure": ("region", "value", "history"),
    "point": ("point", "node", "vector", "history"),
    "impulse": ("region", "point", "node", "vector", "time"),
}
_LOAD_UNITS = {"gravity": "m/s2", "traction": "Pa", "point": "N", "impulse": "N s"}


def read_fixed(table: Table) -> FixedTable:
    """``[[fixed]]``."""
    table.only(("region", "components", "displacement", "history"))
    region = table.selection()
    components = _components(table)
    displacement = None
    if "displacement" in table:
        given = table.values["displacement"]
        numbers = [finite(item) for item in given] if isinstance(given, list) else []
        if len(numbers) != len(components) or None in numbers:
            raise table.error(
                f"displacement must be {len(components)} numbers [m], one for each of the "
                f"components {', '.join(components)}, got {given!r}"
            )
        displacement = tuple(n for n in numbers if n is not None)
    elif "history" in table:
        raise table.error(
            "history belongs to displacement = [...], how far the nodes are moved; "
            "add it, or leave history out"
        )
    return FixedTable(
        region=region,
        components=components,
        displacement=displacement,
        history=_history(table),
    )


def read_load(table: Table) -> LoadTable:
    """``[[load]]``."""
    kind = table.choice("kind", tuple(_LOAD_KEYS))
    keys = _LOAD_KEYS[kind]
    table.only(("kind", *keys), of=f'a load of the kind "{kind}"')
    place = _place(table, kind)
    vector, value = (0.0, 0.0, 0.0), 0.0
    if kind == "pressure":
        value = table.number("value", unit="Pa", example="1e5")
    else:
        default = EARTH if kind == "gravity" else None
        example = "[0.0, 0.0, -9.81]"
        vector = table.vector("vector", unit=_LOAD_UNITS[kind], example=example, default=default)
    return LoadTable(
        kind=kind,
        **place,  # type: ignore[arg-type]
        vector=vector,
        value=value,
        time=table.number("time", default=0.0, least=0.0, unit="s", example="0.1"),
        history=_history(table),
    )


def _place(table: Table, kind: str) -> dict[str, object]:
    """Region, point or node that a load acts on; exactly one, where its kind has any."""
    allowed = [key for key in ("region", "point", "node") if key in _LOAD_KEYS[kind]]
    given = [key for key in allowed if key in table]
    if allowed and len(given) != 1:
        wanted = allowed[0] if len(allowed) == 1 else f"one of {', '.join(allowed)}"
        found = f"has {' and '.join(given)}" if given else "has none"
        raise table.error(f'a load of the kind "{kind}" needs {wanted}, {found}')
    if not given:
        return {}
    match given[0]:
        case "region":
            return {"region": table.selection()}
        case "point":
            return {"point": table.vector("point", unit="m", example="[1.0, 0.0, 0.0]")}
    return {"node": table.count("node", least=0, example="12")}


def _components(table: Table) -> str:
    given = table.values.get("components", list(AXES))
    letters = list(given) if isinstance(given, str | list) else []
    if (
        not letters
        or any(not isinstance(c, str) or c not in AXES or len(c) != 1 for c in letters)
        or len(set(letters)) < len(letters)
    ):
        raise table.error(
            f'components must be some of "x", "y", "z", each once, got {given!r}; '
            'write for instance components = ["x", "y"]'
        )
    return "".join(letters)


_HISTORY_KEYS = {
    "step": ("start",),
    "ramp": ("start", "duration"),
    "sine": ("frequency", "phase"),
    "pulse": ("start", "duration"),
    "table": ("times", "values"),
}


def _history(owner: Table) -> HistoryTable | None:
    if "history" not in owner:
        return None
    table = owner.table("history")
    kind = table.choice("kind", tuple(_HISTORY_KEYS))
    table.only(("kind", *_HISTORY_KEYS[kind]), of=f'a history of the kind "{kind}"')
    start = table.number("start", default=0.0, unit="s", example="0.1")
    match kind:
        case "ramp" | "pulse":
            duration = table.number("duration", above=0.0, unit="s", example="0.1")
            return HistoryTable(kind=kind, start=start, duration=duration)
        case "sine":
            frequency = table.number("frequency", above=0.0, unit="Hz", example="2.0")
            phase = table.number("phase", default=0.0, unit="rad", example="1.57")
            return HistoryTable(kind=kind, frequency=frequency, phase=phase)
        case "table":
            times, values = _numbers(table, "times"), _numbers(table, "values")
            if len(times) != len(values) or any(not b > a for a, b in itertools.pairwise(times)):
                raise table.error(
                    "times must ascend, and have one of the values each; write for instance "
                    "times = [0.0, 1.0, 2.0], values = [0.0, 1.0, 0.0]"
                )
            return HistoryTable(kind=kind, times=times, values=values)
    return HistoryTable(kind=kind, start=start)


def _numbers(table: Table, key: str) -> tuple[float, ...]:
    given = table.need(key, "[0.0, 1.0]")
    numbers = [finite(item) for item in given] if isinstance(given, list) else []
    if not numbers or None in numbers:
        raise table.error(
            f"{key} must be a list of numbers, got {given!r}; write for instance {key} = [0.0, 1.0]"
        )
    return tuple(n for n in numbers if n is not None)
