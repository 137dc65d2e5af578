"""How numbers are written for people: enough digits, units, no noise."""

import math
from collections.abc import Container, Mapping

_TIMES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))
_CONSTANTS = {"poisson": "", "threshold": "", "density": " kg/m3"}  # all others are pressures


def constants_text(constants: Mapping[str, float], *, assumed: Container[str] = frozenset()) -> str:
    """Write constants with units: ``young 2.1e11 Pa, poisson 0.3, density 7850 kg/m3``.

    Args:
        constants: name -> value.
        assumed: names of those to mark as defaults.
    """
    return ", ".join(
        f"{name} {short_number(value)}{_CONSTANTS.get(name, ' Pa')}"
        + (" (default)" if name in assumed else "")
        for name, value in constants.items()
    )


def short_number(value: float) -> str:
    """Write a number with up to six digits: ``2.1e11``, ``7850``, ``0.3``."""
    mantissa, _, exponent = f"{value:.6g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa


def six_digits(value: float) -> str:
    """Write a number with six significant digits: ``440.236``, ``0.0123457``, ``12345.7``."""
    if value == 0.0:
        return "0"
    return _with_digits(value, 6) if 1e-4 <= value < 1e7 else f"{value:.5e}"


def period_text(seconds: float) -> str:
    """Write a time with four significant digits in a unit that suits it: ``2.271 ms``."""
    if not math.isfinite(seconds):
        return "-"
    scale, unit = next((u for u in _TIMES if seconds >= 0.99995 * u[0]), _TIMES[-1])
    value = seconds / scale
    return f"{_with_digits(value, 4) if 1e-3 <= value < 1e5 else f'{value:.3e}'} {unit}"


def _with_digits(value: float, digits: int) -> str:
    """Write a positive number without exponent, with so many significant digits."""
    rounded = float(f"{value:.{digits - 1}e}")  # 999.9996 has one digit more once it is rounded
    return f"{value:.{max(0, digits - 1 - math.floor(math.log10(rounded)))}f}"
