"""Libraries built once from the C sources in ``native``, by the compiler DOLFINx itself needs."""

import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

SOURCES = Path(__file__).with_name("native")


def cache_folder() -> Path:
    """DOLFINx's cache of compiled forms (its documented default)."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "fenics"


def build_library(source: Path, *, flags: Sequence[str] = ("-O3",), folder: Path) -> Path:
    """Compile a C source unless the folder holds the library already.

    Args:
        source: C file.
        flags: of the compiler; part of what names the library.
        folder: where it is kept.

    Returns:
        Path of the shared library.

    Raises:
        OSError: no C compiler, or the folder cannot be written.
        subprocess.CalledProcessError: the compiler failed.
    """
    digest = hashlib.sha256(source.read_bytes() + " ".join(flags).encode()).hexdigest()[:16]
    library = folder / f"libfenics_defo_{source.stem}_{digest}.so"
    if library.exists():
        return library
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise FileNotFoundError("no C compiler (cc or gcc) on PATH")
    folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(suffix=".so", dir=folder)
    os.close(handle)
    try:
        command = [*compiler.split(), *flags, "-shared", "-fPIC", str(source), "-o", name]
        subprocess.run(command, check=True, capture_output=True)
        os.replace(name, library)  # ranks and test workers build at the same time: last one wins
    finally:
        Path(name).unlink(missing_ok=True)
    return library
