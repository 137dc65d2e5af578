"""PyVista, imported so that it draws without a display and without a word on standard error."""

import os
import sys
from typing import Any

from fenics_defo.errors import MissingDependencyError

_WINDOW = "vtkEGLRenderWindow"

if sys.platform == "linux":
    # VTK would try X11 first and warn where there is no display; it reads this when it makes its
    # first window. A user's own choice stays.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", _WINDOW)
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")  # Mesa's notes about drivers that are absent

try:
    import pyvista
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (brings the kinds of windows)
    from PIL import Image, ImageDraw, ImageFont
    from vtkmodules.vtkCommonCore import vtkLogger
    from vtkmodules.vtkRenderingCore import vtkRenderWindow
except ImportError as error:
    raise MissingDependencyError(
        f"pictures need PyVista, which cannot be imported ({error}); "
        "pip install 'fenics_defo[view]'."
    ) from error

__all__ = ["Image", "ImageDraw", "ImageFont", "pyvista", "require_rendering"]


def require_rendering() -> None:
    """Make sure that VTK can draw here: without this, it warns at length and then crashes.

    Raises:
        MissingDependencyError: EGL is missing or has no driver.
    """
    if os.environ.get("VTK_DEFAULT_OPENGL_WINDOW") != _WINDOW:
        return
    found = _window_class()
    if found != _WINDOW:
        raise MissingDependencyError(
            "pictures without a display need EGL and a driver for it, and VTK finds none; "
            "install them, on Debian with: apt install libegl1 libgl1-mesa-dri."
        )


def _window_class() -> str:
    """Return what kind of window VTK makes, after trying in silence."""
    verbosity: Any = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        return str(vtkRenderWindow().GetClassName())
    finally:
        vtkLogger.SetStderrVerbosity(verbosity)
