"""Leave no half-compiled kernel behind: later runs would wait for it, and fail.

DOLFINx compiles each form once into ``~/.cache/fenics``. The file ``NAME.c`` also is the lock of
its compilation, and ``NAME.c.cached`` says that it is done. FFCx removes the lock after an error
but not after Ctrl-C (ffcx/codegeneration/jit.py, version 0.11).
"""

import contextlib
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType

from fenics_defo.fem.compat import dolfinx

_ABANDONED = 600.0  # seconds: no compilation of ours takes a tenth of it


@contextlib.contextmanager
def no_unfinished_kernels() -> Iterator[None]:
    """Remove locks that were abandoned long ago, and after Ctrl-C the one of this process."""
    folder = Path(dolfinx.jit.get_options()["cache_dir"]).expanduser()
    _remove_abandoned(folder, time.time() - _ABANDONED)
    try:
        yield
    except BaseException as error:
        if not isinstance(error, Exception):  # else FFCx has removed its lock itself
            _remove_own(error.__traceback__)
        raise


def _remove_abandoned(folder: Path, until: float) -> None:
    for lock in folder.glob("libffcx_*.c"):
        with contextlib.suppress(OSError):  # another run was faster, or it is not ours
            if lock.stat().st_mtime <= until:
                _remove_unfinished(lock)


def _remove_own(trace: TracebackType | None) -> None:
    """Remove the lock of the compilation that the exception came out of, and no other run's."""
    for frame, _ in traceback.walk_tb(trace):
        name, folder = frame.f_locals.get("module_name"), frame.f_locals.get("cache_dir")
        if isinstance(name, str) and name.startswith("libffcx_") and isinstance(folder, Path):
            _remove_unfinished(folder / f"{name}.c")


def _remove_unfinished(lock: Path) -> None:
    if not lock.with_suffix(".c.cached").exists():
        with contextlib.suppress(OSError):
            lock.unlink()
