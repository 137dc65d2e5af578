"""One TOML table, its keys read one by one, each with its type, its range and its sentence."""

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fenics_defo.errors import SceneError

Vector = tuple[float, float, float]

AXES = "xyz"

_NODE_FILE = "nodes:"


@dataclass(frozen=True, slots=True)
class Table:
    """A table of a scene file.

    Args:
        path: the scene file, for messages.
        name: what the table is called in messages, ``[time]`` or ``[[load]] 2``.
        values: its keys and values, as `tomllib` gives them.
    """

    path: Path
    name: str
    values: Mapping[str, Any]

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def error(self, sentence: str) -> SceneError:
        """An error that names the file and the table before the sentence."""
        return SceneError(f"{self.path}: {self.name}: {sentence}")

    def only(self, allowed: Sequence[str], *, of: str = "this table") -> None:
        """Refuse keys that are not in ``allowed``.

        Args:
            allowed: the keys that are read.
            of: whose keys they are, in words.

        Raises:
            SceneError: an unknown key, with the nearest known one.
        """
        for key in self.values:
            if key not in allowed:
                raise self.error(
                    f"unknown key {key!r}{did_you_mean(key, allowed)}; "
                    f"the keys of {of} are {', '.join(allowed)}"
                )

    def need(self, key: str, example: str) -> Any:
        """The value of a key that must be there."""
        if key not in self.values:
            raise self.error(f"needs the key {key}; write for instance {key} = {example}")
        return self.values[key]

    def number(
        self,
        key: str,
        *,
        default: float | None = None,
        above: float = -math.inf,
        least: float = -math.inf,
        most: float = math.inf,
        unit: str = "",
        example: str = "1.0",
    ) -> float:
        """A finite number in a range.

        Args:
            key: its name.
            default: what it is where the key is missing; the key is required if not given.
            above: the number must be larger.
            least: the number must be this or larger.
            most: the number must be this or smaller.
            unit: of the number, for messages.
            example: a value, for messages.
        """
        if key not in self.values and default is not None:
            return default
        value = self.need(key, example)
        number = finite(value)
        if number is None or not (number > above and least <= number <= most):
            limits = _limits(above, least, most)
            raise self.error(
                f"{key} must be a number{limits}{f' [{unit}]' if unit else ''}, got {value!r}; "
                f"write for instance {key} = {example}"
            )
        return number

    def count(self, key: str, *, default: int | None = None, least: int = 1, example: str) -> int:
        """A whole number from ``least``."""
        if key not in self.values and default is not None:
            return default
        value = self.need(key, example)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self.error(
                f"{key} must be a whole number from {least}, got {value!r}; "
                f"write for instance {key} = {example}"
            )
        return value

    def flag(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            raise self.error(f"{key} must be true or false, got {value!r}; write {key} = true")
        return value

    def text(self, key: str, *, example: str) -> str:
        """A text that is not empty."""
        value = self.need(key, f'"{example}"')
        if not isinstance(value, str) or not value.strip():
            raise self.error(
                f'{key} must be a text in quotes, got {value!r}; write for instance {key} = "'
                f'{example}"'
            )
        return value

    def choice(self, key: str, options: Sequence[str], *, default: str | None = None) -> str:
        """One of several words."""
        if key not in self.values and default is not None:
            return default
        words = ", ".join(f'"{option}"' for option in options)
        if key not in self.values:
            raise self.error(f"needs the key {key}, one of {words}")
        value = self.values[key]
        if not isinstance(value, str) or value not in options:
            raise self.error(
                f"{key} must be one of {words}, got {value!r}{did_you_mean(value, options)}"
            )
        return value

    def selection(self, key: str = "region") -> str | int:
        """A selection of the mesh: a group's name or number, a comparison, ``nodes:FILE``.

        A relative FILE counts from the folder of the scene file.
        """
        value = self.need(key, "\"a group's name\" or 'x<1e-6'")
        if isinstance(value, bool) or not (
            isinstance(value, int) or (isinstance(value, str) and value.strip())
        ):
            raise self.error(
                f"{key} must be a selection (a group's name or number, a comparison such as "
                f"'x<1e-6', or 'nodes:FILE'), got {value!r}"
            )
        if isinstance(value, str) and value.startswith(_NODE_FILE):
            return f"{_NODE_FILE}{self.path.parent / value.removeprefix(_NODE_FILE).strip()}"
        return value

    def vector(self, key: str, *, unit: str, example: str, default: Vector | None = None) -> Vector:
        """Three finite numbers."""
        if key not in self.values and default is not None:
            return default
        value = self.need(key, example)
        numbers = [finite(item) for item in value] if isinstance(value, list) else []
        if len(numbers) != 3 or None in numbers:
            raise self.error(
                f"{key} must be three numbers [{unit}], got {value!r}; "
                f"write for instance {key} = {example}"
            )
        x, y, z = (float(n) for n in numbers if n is not None)
        return x, y, z

    def table(self, key: str) -> "Table":
        """A table within this one."""
        value = self.values[key]
        if not isinstance(value, Mapping):
            raise self.error(
                f"{key} must be a table in braces, got {value!r}; "
                f'write for instance {key} = {{ kind = "ramp", duration = 1.0 }}'
            )
        return Table(self.path, f"{self.name} {key}", value)


def finite(value: object) -> float | None:
    """The value as a float if it is a finite number, which truth values are not; else None."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:  # an integer of more than 308 digits
        return None
    return number if math.isfinite(number) else None


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """The known word nearest to one that is unknown, as part of a sentence; often empty."""
    near = difflib.get_close_matches(str(word).lower(), list(known), n=1, cutoff=0.6)
    return f' (did you mean "{near[0]}"?)' if near else ""


def _limits(above: float, least: float, most: float) -> str:
    parts = []
    if math.isfinite(above):
        parts.append(f"above {above:g}")
    if math.isfinite(least):
        parts.append(f"from {least:g}")
    if math.isfinite(most):
        parts.append(f"up to {most:g}")
    return f" {' '.join(parts)}" if parts else ""
