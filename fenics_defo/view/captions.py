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
    frequency = f"{frequency_text(modes.frequencies[index])} Hz"
    parts = [str(index + 1), "" if index < modes.rigid_modes else frequency, motion]
    return " · ".join(part for part in parts if part)


def omissions(rigid: int, higher: int) -> str:
    """Say what a picture leaves out: ``6 rigid modes and 1 higher mode not shown``."""
    counts = {"rigid": rigid, "higher": higher}
    parts = [f"{n} {kind} mode{'s' * (n > 1)}" for kind, n in counts.items() if n]
    return f"{' and '.join(parts)} not shown" if parts else ""


def field_names(modes: Modes) -> Sequence[str]:
    """Return a name for each mode that is unique and sorts in order: ``mode_01_440.2Hz``."""
    width = max(2, len(str(modes.size)))
    return [
        f"mode_{index + 1:0{width}d}_"
        + ("rigid" if index < modes.rigid_modes else f"{frequency_text(frequency)}Hz")
        for index, frequency in enumerate(modes.frequencies)
    ]
