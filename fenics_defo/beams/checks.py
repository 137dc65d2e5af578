"""Checks of what the user passes to the beam and sphere formulas.

Every comparison is written so that NaN fails it too.
"""

from collections.abc import Iterable
from math import inf
from numbers import Integral, Real

from fenics_defo.errors import DefoError, MaterialError


class BeamError(DefoError, ValueError):
    """A length, a section, a support or a count is outside what the closed formula allows."""


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_integer(value: object) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


def require_positive(name: str, value: float, *, unit: str) -> float:
    """Return ``value`` as a float if it is positive and finite.

    Raises:
        BeamError: it is not a number, or not in (0, inf).
    """
    if not _is_number(value) or not 0.0 < value < inf:
        raise BeamError(
            f"{name} must be a positive finite number [{unit}], got {value!r}; give it in SI units"
        )
    return float(value)


def require_finite(name: str, value: float, *, unit: str) -> float:
    """Return ``value`` as a float if it is a finite number of either sign.

    Raises:
        BeamError: it is not a number, or not finite.
    """
    if not _is_number(value) or not -inf < value < inf:
        raise BeamError(
            f"{name} must be a finite number [{unit}], got {value!r}; give 0 to leave it out"
        )
    return float(value)


def require_modulus(name: str, value: float, *, unit: str) -> float:
    """Return a material constant (modulus, density) as a float if it is positive and finite.

    Raises:
        MaterialError: it is not a number, or not in (0, inf).
    """
    if not _is_number(value) or not 0.0 < value < inf:
        raise MaterialError(
            f"{name} must be a positive finite number [{unit}], got {value!r}; give it in SI units"
        )
    return float(value)


def require_poisson(value: float) -> float:
    """Return Poisson's ratio as a float if it lies in (-1, 0.5).

    Raises:
        MaterialError: it is not a number, or outside that interval.
    """
    if not _is_number(value) or not -1.0 < value < 0.5:
        raise MaterialError(
            f"poisson must lie in (-1, 0.5), got {value!r}; "
            "for a nearly incompressible solid use 0.49"
        )
    return float(value)


def require_count(value: int) -> int:
    """Return the number of frequencies wanted, if it is an integer of at least one.

    Raises:
        BeamError: it is not an integer, or less than 1.
    """
    if not _is_integer(value) or value < 1:
        raise BeamError(f"count must be an integer of at least 1, got {value!r}; ask for count=1")
    return int(value)


def require_choice(name: str, value: str, allowed: Iterable[str]) -> str:
    """Return ``value`` if it is one of the ``allowed`` words.

    Raises:
        BeamError: it is none of them.
    """
    words = tuple(allowed)
    if not isinstance(value, str) or value not in words:
        raise BeamError(f"{name} must be one of {', '.join(words)}; got {value!r}")
    return value


def shear_modulus(young: float, poisson: float) -> float:
    """G = E / (2 (1 + nu)) [Pa] of an isotropic solid, from checked constants.

    Raises:
        MaterialError: a constant is out of range.
    """
    checked_young = require_modulus("young", young, unit="Pa")
    return 0.5 * checked_young / (1.0 + require_poisson(poisson))
