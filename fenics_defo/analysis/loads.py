"""Loads on a body, as records: what acts, where, and how it varies in time."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_defo.analysis.histories import History, Step
from fenics_defo.errors import LoadError

type Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Gravity:
    """A uniform acceleration field that acts on the whole mass.

    Args:
        vector: acceleration [m/s²].
        history: factor over time.

    Raises:
        LoadError: ``vector`` is not three finite numbers.
    """

    vector: Sequence[float] = (0.0, 0.0, -9.81)
    history: History = field(default_factory=Step)

    def __post_init__(self) -> None:
        object.__setattr__(self, "vector", checked_vector("Gravity", self.vector))
        _check_history("Gravity", self.history)


@dataclass(frozen=True, slots=True)
class Traction:
    """A force per area at rest that keeps its direction (dead load).

    Args:
        region: selection of boundary facets.
        vector: [Pa].
        history: factor over time.

    Raises:
        LoadError: ``vector`` is not three finite numbers.
    """

    region: str | int
    vector: Sequence[float]
    history: History = field(default_factory=Step)

    def __post_init__(self) -> None:
        object.__setattr__(self, "vector", checked_vector("Traction", self.vector))
        _check_history("Traction", self.history)


@dataclass(frozen=True, slots=True)
class Pressure:
    """A pressure that follows the deformed surface: -p J F⁻ᵀ N per area at rest.

    Args:
        region: selection of boundary facets.
        value: p [Pa], positive pushes into the body.
        history: factor over time.

    Raises:
        LoadError: ``value`` is not a finite number.
    """

    region: str | int
    value: float
    history: History = field(default_factory=Step)

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", _checked_number("value of Pressure", self.value))
        _check_history("Pressure", self.history)


@dataclass(frozen=True, slots=True, kw_only=True)
class PointLoad:
    """A force at one point of the body, or at one node.

    Args:
        point: coordinates at rest [m]; the force goes to the nodes of the cell there by its shape
            functions.
        node: instead of ``point``, row of ``solid.points`` (from 0).
        vector: [N].
        history: factor over time.

    Raises:
        LoadError: not exactly one of ``point`` and ``node`` given, or numbers that are not finite.
    """

    point: Sequence[float] | None = None
    node: int | None = None
    vector: Sequence[float]
    history: History = field(default_factory=Step)

    def __post_init__(self) -> None:
        given = [name for name in ("point", "node") if getattr(self, name) is not None]
        _check_place("PointLoad", given, "'point' and 'node'")
        object.__setattr__(self, "vector", checked_vector("PointLoad", self.vector))
        if self.point is not None:
            object.__setattr__(self, "point", checked_vector("PointLoad", self.point, "point"))
        _check_history("PointLoad", self.history)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impulse:
    """A momentum that is handed to the body at one moment: M Δv = J.

    Args:
        region: selection of nodes over which the momentum is spread evenly by their mass.
        point: instead, coordinates at rest [m].
        node: instead, row of ``solid.points`` (from 0).
        vector: the whole momentum J [N s].
        time: [s], from 0; it acts at the start of the step within which it falls.

    Raises:
        LoadError: not exactly one place given, numbers that are not finite, ``time`` negative.
    """

    region: str | int | None = None
    point: Sequence[float] | None = None
    node: int | None = None
    vector: Sequence[float]
    time: float = 0.0

    def __post_init__(self) -> None:
        given = [name for name in ("region", "point", "node") if getattr(self, name) is not None]
        _check_place("Impulse", given, "'region', 'point' and 'node'")
        object.__setattr__(self, "vector", checked_vector("Impulse", self.vector))
        if self.point is not None:
            object.__setattr__(self, "point", checked_vector("Impulse", self.point, "point"))
        object.__setattr__(self, "time", _checked_number("time of Impulse", self.time))
        if not self.time >= 0.0:
            raise LoadError(f"time of Impulse must be 0 or later [s], got {self.time!r}")


type Load = Gravity | Traction | Pressure | PointLoad | Impulse


def checked_vector(record: str, values: object, name: str = "vector") -> Vector:
    """Three finite numbers as a tuple.

    Raises:
        LoadError: they are not.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise LoadError(f"{name} of {record} must be three finite numbers, got {values!r}")
    x, y, z = map(float, array)
    return x, y, z


def _checked_number(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not np.isfinite(number):
        raise LoadError(f"{name} must be a finite number, got {value!r}")
    return number


def _check_place(record: str, given: list[str], allowed: str) -> None:
    if len(given) != 1:
        got = " and ".join(given) or "none"
        raise LoadError(f"a {record} needs exactly one of {allowed}, got {got}")


def _check_history(record: str, history: History) -> None:
    if not callable(history):
        raise LoadError(
            f"history of {record} must be Step, Ramp, Sine, Pulse, Table or a function of time, "
            f"got {history!r}"
        )
