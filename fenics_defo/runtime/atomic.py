"""Write a file completely or not at all."""

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from fenics_defo.errors import DefoError

_DISK_TROUBLE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO}


@contextmanager
def atomic_path(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a name to write to that becomes ``path`` only when the block succeeds.

    The temporary file lies in the folder of ``path`` (a rename between file systems is a copy)
    and has its suffix (writers that choose a format by suffix work). It is flushed to the disk
    and renamed at the end; after any exception, Ctrl-C included, it is removed and a file that
    was at ``path`` before is still there, untouched.

    Args:
        path: file to create or to replace; the target of a symbolic link is replaced, the link
            stays. The permissions of a replaced file are kept.

    Yields:
        the temporary file, empty, to be overwritten.

    Raises:
        DefoError: the folder is missing or not writable, ``path`` is not a regular file, or the
            disk is full.
    """
    target = _checked_target(path)
    temporary = _claim(target, path)
    try:
        yield temporary
        _flush(temporary)
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o777)
        os.replace(temporary, target)
    except OSError as error:
        if error.errno not in _DISK_TROUBLE:
            raise
        raise DefoError(
            f"{path}: writing stopped: {error.strerror}; nothing was changed there, "
            "make room or choose another folder."
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Make sure that ``atomic_path(path)`` can begin, before hours of work depend on it.

    Nothing stays on the disk: a temporary file is created beside ``path`` and removed at once,
    which also finds out about read-only file systems and quotas.

    Raises:
        DefoError: as `atomic_path`.
    """
    _claim(_checked_target(path), path).unlink()


def _checked_target(path: str | os.PathLike[str]) -> Path:
    """Return ``path`` with its links followed, if a regular file is or can be there."""
    if not os.fspath(path):
        raise DefoError("an output file needs a name, got an empty one.")
    target = Path(os.path.realpath(path))
    # Unlike the methods of Path, these answer False for a name that the system refuses.
    if os.path.isdir(target):
        raise DefoError(f"{path}: is a folder; name a file inside it.")
    # Renaming over a device such as /dev/null would replace the device itself.
    if os.path.exists(target) and not os.path.isfile(target):
        raise DefoError(f"{path}: is not a regular file; name a new file or one to replace.")
    if not os.path.isdir(target.parent):
        raise DefoError(
            f"{path}: the folder {str(target.parent)!r} does not exist; create it first."
        )
    return target


def _claim(target: Path, path: str | os.PathLike[str]) -> Path:
    """Create an empty file of a new name beside ``target``."""
    temporary = target.parent / f".{secrets.token_hex(6)}{target.suffix}"
    try:
        with suppress(FileNotFoundError):
            os.stat(target)  # finds out about names that are too long
        # Mode 0o666 is narrowed by the user's umask, unlike the 0o600 of tempfile.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    except OSError as error:
        raise DefoError(
            f"{path}: no file can be written in {str(target.parent)!r} ({error.strerror}); "
            "choose another folder."
        ) from error
    return temporary


def _flush(path: Path) -> None:
    """Ask the system to put the content of ``path`` on the disk before it gets its name."""
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
