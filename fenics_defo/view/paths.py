"""Whether files can be written under the names given: questions for before a long run."""

import os
from pathlib import Path

from fenics_defo.errors import DefoError
from fenics_defo.runtime import check_writable

VTK_SUFFIXES = (".vtu", ".vtk")


def check_vtk_path(path: str | os.PathLike[str]) -> str:
    """Return the suffix of ``path`` if `write_modes_vtk` can write there.

    Raises:
        DefoError: another suffix, or a place that cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in VTK_SUFFIXES:
        raise DefoError(
            f"{path}: the suffix {suffix!r} is not one of {', '.join(VTK_SUFFIXES)}; "
            "name the file *.vtu to open it in ParaView."
        )
    check_writable(path)
    return suffix


def check_picture_path(path: str | os.PathLike[str]) -> None:
    """Make sure that `mode_picture` can write to ``path``.

    Raises:
        DefoError: another suffix than .png, or a place that cannot be written.
    """
    if Path(path).suffix.lower() != ".png":
        raise DefoError(f"{path}: pictures are PNG files; name it *.png.")
    check_writable(path)
