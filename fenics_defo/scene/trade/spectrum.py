"""The strongest frequency of a recorded motion."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_PERIODS = 2.0  # fewest that tell a frequency
_FINER = 16  # lines of the spectrum for each that the record's length resolves


def strongest_frequency(values: Array, interval: float) -> float | None:
    """Frequency [Hz] of the largest line in the spectrum of a record.

    A Hann window, zeros appended, and a parabola through the logarithms of the highest three
    lines. None where the record is too short, too coarse or does not swing.

    Args:
        values: (m,) at equal intervals.
        interval: time between two values [s].
    """
    count = len(values)
    if count < 8 or not np.ptp(values) > 0.0:
        return None
    swing = (values - values.mean()) * np.hanning(count)
    lines = np.abs(np.fft.rfft(swing, _FINER * count))
    first = int(_PERIODS * _FINER)
    if first + 2 >= len(lines):
        return None
    peak = int(lines.argmax())
    if not first <= peak < len(lines) - 1:
        return None
    below, at, above = np.log(np.maximum(lines[peak - 1 : peak + 2], 1e-300))
    curve = below - 2.0 * at + above
    shift = 0.5 * (below - above) / curve if curve < 0.0 else 0.0
    return float((peak + shift) / (_FINER * count * interval))
