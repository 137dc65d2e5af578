"""Words and names for modes in pictures and files."""

import math
from collections.abc import Sequence

from fenics_defo.runtime import Modes


def frequency_text(frequency: float) -> str:
    """Write a frequency [Hz] with four significant digits and no exponent: ``440.2``, ``0.0123``.

    Below 1 uHz, round-off for any solid, it is ``0``.
    """
    if frequency < 1e-6:
        return "0"
    return f"{frequency:.{max(0, 3 - math.floor(math.log10(frequency)))}f}"


def caption(modes: Modes, index: int, motion: str = "") -> str:
    """Return for instance ``1 · 440.2 Hz · bending`` for the mode ``index`` (zero-based)."""
    parts = [str(index + 1), f"{frequency_text(modes.frequencies[index])} Hz", motion]
    return " · ".join(part for part in parts if part)


def field_names(modes: Modes) -> Sequence[str]:
    """Return a name for each mode that is unique and sorts in order: ``mode_01_440.2Hz``."""
    width = max(2, len(str(modes.size)))
    return [
        f"mode_{index + 1:0{width}d}_"
        + ("rigid" if index < modes.rigid_modes else f"{frequency_text(frequency)}Hz")
        for index, frequency in enumerate(modes.frequencies)
    ]
