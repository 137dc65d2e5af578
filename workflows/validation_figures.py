"""What the figures of ``validation.py`` have in common."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt


@contextmanager
def drawn(path: Path, columns: int = 1, *, size: tuple[float, float] = (4.6, 3.6)) -> Iterator[Any]:
    """Axes, or ``columns`` of them side by side, saved to ``path`` at the end."""
    width, height = size
    figure, axes = plt.subplots(1, columns, figsize=(width * columns, height), layout="constrained")
    try:
        yield axes
        for axis in figure.axes:
            axis.grid(visible=True, alpha=0.3)
            if axis.get_legend_handles_labels()[0]:
                axis.legend(fontsize=8)
        figure.savefig(path, dpi=120)
    finally:
        plt.close(figure)
