"""Plain values that travel with a model as JSON: where it comes from, what it is good for."""

import json
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any


def plain_mapping(name: str, values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a read-only copy of ``values`` as its JSON text comes back: keys sorted, lists only.

    Raises:
        ValueError: a value is not a number, text, true, false, none, a list or a mapping of them;
            or a number is not finite.
    """
    try:
        text = json_text(values)
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(
            f"{name} must hold plain values that JSON can write, which these are not: {error}"
        ) from error
    return parse_mapping(name, text)


def json_text(values: Mapping[str, Any]) -> str:
    """Return the one JSON text of ``values``: the same whatever the order of the keys."""
    return json.dumps(dict(values), sort_keys=True, ensure_ascii=False, allow_nan=False)


def parse_mapping(name: str, text: str) -> Mapping[str, Any]:
    """Return what `json_text` wrote, read-only.

    Raises:
        ValueError: the text is not JSON, not of a mapping, or holds a number that is not finite.
    """
    try:
        text.encode()  # half a surrogate pair could be neither printed nor written again
        found = json.loads(text, parse_constant=_refuse, parse_float=_finite)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name} is not the JSON text of plain values: {error}") from error
    if not isinstance(found, dict):
        raise ValueError(f"{name} must be a JSON object, not a {type(found).__name__}")
    return MappingProxyType(found)


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is not a finite number")


def _finite(digits: str) -> float:
    value = float(digits)
    if not math.isfinite(value):
        raise ValueError(f"{digits} is not a finite number")
    return value
