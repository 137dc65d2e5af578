"""A picture of the mode shapes, one panel each."""

import os
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis.motion import describe_motion
from fenics_defo.errors import DefoError
from fenics_defo.runtime import Modes, atomic_path
from fenics_defo.view.camera import good_view
from fenics_defo.view.captions import caption, omissions
from fenics_defo.view.offscreen import require_rendering
from fenics_defo.view.panels import draw_panels, panel_size
from fenics_defo.view.paths import check_picture_path
from fenics_defo.view.sheet import compose
from fenics_defo.view.surface import Skin, largest_scale, skin

Array = NDArray[np.float64]

_MOST_PANELS = 12
_AMPLITUDE = 0.12  # of the body's diagonal: plain to see, and still a small motion
_ROTATION = 0.45  # radians
_DPI = 220


def mode_picture(
    modes: Modes,
    path: str | os.PathLike[str],
    *,
    count: int | None = None,
    columns: int | None = None,
    scale: float | None = None,
) -> None:
    """Draw the shapes of the modes beside each other, without a display.

    Each panel shows the body displaced by one mode, coloured by the size of the displacement
    relative to its largest one, over the sharp edges of the body at rest, all from one side.
    Rigid motions are left out unless there is nothing else.

    Args:
        modes: what to draw.
        path: ``.png`` file to create or to replace.
        count: how many modes, from the first that is not rigid; at most 12 by default.
        columns: panels beside each other; chosen for a landscape picture by default.
        scale: largest displacement as a fraction of the diagonal of the body. By default 0.12,
            less where sections would have to turn by more than half a radian.

    Raises:
        DefoError: ``path`` does not end in .png or cannot be written, or a number is not positive.
        MissingDependencyError: nothing can be drawn here, see the message.
    """
    check_picture_path(path)
    for name, value in {"count": count, "columns": columns, "scale": scale}.items():
        if value is not None and not 0.0 < value < np.inf:
            raise DefoError(f"{name} must be positive, got {value!r}.")
    require_rendering()
    first = modes.rigid_modes if modes.rigid_modes < modes.size else 0
    chosen = range(first, min(modes.size, first + (count or _MOST_PANELS)))
    shown = modes.select(chosen)
    words = describe_motion(shown)
    titles = [caption(modes, i, word) for i, word in zip(chosen, words, strict=True)]
    body = skin(_to_unit_size(shown))
    factors = np.array([_factor(body, move, scale) for move in body.surface_moves])
    moved = body.surface.points + factors[:, None, None] * body.surface_moves
    view = good_view(np.asarray(body.surface.points), moved)
    drawings = draw_panels(body, factors, view, panel_size(view.width, view.height))
    note = omissions(first, modes.size - chosen.stop)
    sheet = compose(drawings, titles, note=note, columns=columns)
    with atomic_path(path) as temporary:
        sheet.save(temporary, dpi=(_DPI, _DPI), compress_level=4)


def _to_unit_size(modes: Modes) -> Modes:
    """Return the body with a diagonal of 1 around the origin.

    VTK draws in single precision and merges points by absolute distances.
    """
    used = np.zeros(len(modes.points), dtype=bool)
    used[modes.cells] = True
    low, high = modes.points[used].min(axis=0), modes.points[used].max(axis=0)
    diagonal = np.linalg.norm(high - low)
    return replace(modes, points=(modes.points - (low + high) / 2.0) / max(diagonal, 1e-300))


def _factor(body: Skin, move: Array, scale: float | None) -> float:
    """Return the factor that makes ``move`` (s, 3) visible."""
    largest = np.linalg.norm(move, axis=1).max()
    if not largest > 0.0:
        return 1.0
    wanted = (scale or _AMPLITUDE) * body.surface.length / largest
    return wanted if scale else min(wanted, largest_scale(body, move, _ROTATION))
