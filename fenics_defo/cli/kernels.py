"""Leave no half-compiled kernel behind: later runs would wait for it, and fail.

DOLFINx compiles each form once into ``~/.cache/fenics``. The file ``NAME.c`` also is the lock of
its compilation, and ``NAME.c.cached`` says that it is done. FFCx removes the lock after an error
but not after Ctrl-C (ffcx/codegeneration/jit.py, version 0.11).
"""

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path

from fenics_defo.errors import DefoError
from fenics_defo.fem.compat import dolfinx

_ABANDONED = 600.0  # seconds: no compilation of ours takes a tenth of it


@contextlib.contextmanager
def no_unfinished_kernels() -> Iterator[None]:
    """Remove locks that were abandoned long ago, and after Ctrl-C those of this run."""
    folder = Path(dolfinx.jit.get_options()["cache_dir"]).expanduser()
    begin = time.time()
    _remove_locks(folder, until=begin - _ABANDONED)
    try:
        yield
    except (DefoError, OSError):  # told after the compilations
        raise
    except BaseException:  # Ctrl-C, also where it ended the compiler and shows as its error
        _remove_locks(folder, since=begin)
        raise


def _remove_locks(folder: Path, *, since: float = 0.0, until: float = float("inf")) -> None:
    """Remove the locks without kernels whose time of change lies in between."""
    for lock in folder.glob("libffcx_*.c"):
        if lock.with_suffix(".c.cached").exists():
            continue
        with contextlib.suppress(OSError):  # another run was faster, or it is not ours
            if since <= lock.stat().st_mtime <= until:
                lock.unlink()
