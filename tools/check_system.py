"""Tell in one sentence what this machine lacks, with the packages that bring it.

Before anything is downloaded: a C compiler and Python's headers, for the kernels that DOLFINx
compiles at run time, ``ensurepip`` for the virtual environment, and the shared libraries of the
desktop that gmsh and VTK link to even when they draw nothing on a screen. With ``--loads``, after
the installation: whether the compiled packages really load. Standard library only; writes
nothing.
"""

import os
import re
import shlex
import subprocess
import sys
import sysconfig

# Shared library -> package of Debian and Ubuntu: what the wheels of gmsh (its ELF header) and VTK
# (libEGL, opened at run time) leave to the system.
LIBRARIES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libGLU.so.1": "libglu1-mesa",
    "libX11.so.6": "libx11-6",
    "libXcursor.so.1": "libxcursor1",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXrender.so.1": "libxrender1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
    "libstdc++.so.6": "libstdc++6",
    "libz.so.1": "zlib1g",
}

COMPILED_PACKAGES = ("dolfinx_solver", "gmsh", "vtkmodules.vtkRenderingOpenGL2")


def missing_libraries(libraries: dict[str, str] = LIBRARIES) -> dict[str, str]:
    """Return ``{library: package}`` of those that the dynamic linker does not find."""
    try:
        import ctypes
    except ImportError:  # a Python built without libffi; --loads will tell
        return {}
    missing = {}
    for name, package in libraries.items():
        try:
            ctypes.CDLL(name)
        except OSError:
            missing[name] = package
    return missing


def debian_python_package(suffix: str) -> str:
    """Return the package of this Python with ``suffix``; empty if it is not Debian's own."""
    if sys.base_prefix != "/usr":
        return ""
    return f"python3.{sys.version_info.minor}-{suffix}"


def compiles(compiler: list[str], header: str) -> bool:
    """Whether ``compiler`` runs and finds ``header``; nothing is written."""
    command = [*compiler, "-I" + sysconfig.get_path("include"), "-fsyntax-only", "-x", "c", "-"]
    source = f"#include <{header}>\n"
    try:
        done = subprocess.run(command, input=source, capture_output=True, text=True, check=False)
    except OSError:
        return False
    return done.returncode == 0


def missing_build_tools() -> dict[str, str]:
    """Return ``{thing: package}`` of what making .venv and compiling a kernel need."""
    missing = {}
    try:
        import ensurepip  # noqa: F401
    except ImportError:
        missing["Python's ensurepip"] = debian_python_package("venv")
    # The order in which setuptools, which compiles for DOLFINx, looks for it.
    compiler = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    # math.h is the C library's, which a compiler alone does not bring.
    if not compiles(compiler, "math.h"):
        missing[f"a C compiler that works ({compiler[0]})"] = "gcc libc6-dev"
        if not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")):
            missing["Python.h"] = debian_python_package("dev")
    elif not compiles(compiler, "Python.h"):
        missing["Python.h"] = debian_python_package("dev")
    return missing


def sentence(missing: dict[str, str]) -> str:
    """Return one sentence that says what is missing and what to install.

    Args:
        missing: ``{thing: package or packages}``; an empty package when none brings it.
    """
    packages = sorted({name for package in missing.values() for name in package.split()})
    sudo = "" if os.geteuid() == 0 else "sudo "
    text = f"This machine lacks {', '.join(missing)}"
    if packages:
        install = f"{sudo}apt-get update && {sudo}apt-get install {' '.join(packages)}"
        text += f": on Debian or Ubuntu run `{install}`"
    if not all(missing.values()):
        text += " and" if packages else ":"
        text += f" choose another Python than {sys.executable} with PYTHON=/path/to/python3"
    return text + ", then run make again."


def failed_loads(modules: tuple[str, ...] = COMPILED_PACKAGES) -> dict[str, str]:
    """Return ``{module: last line of its error}`` of those that this Python cannot import."""
    failed = {}
    for name in modules:
        done = subprocess.run(
            [sys.executable, "-c", "import " + name],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines()
            failed[name] = lines[-1] if lines else f"exit status {done.returncode}"
    return failed


def report_loads() -> int:
    """Print what does not load, one line a module, and return the exit status."""
    failed = failed_loads()
    for name, error in failed.items():
        found = re.search(r"(lib[\w.+-]+\.so[.\d]*): cannot open shared object file", error)
        if found:
            library = found.group(1)
            print(sentence({library: LIBRARIES.get(library, "")}), file=sys.stderr)
        else:
            print(f"{name} is installed but does not load: {error}", file=sys.stderr)
    return 1 if failed else 0


def main(arguments: list[str]) -> int:
    """Return 0 when nothing is missing, else print the sentence and return 1."""
    if arguments == ["--loads"]:
        return report_loads()
    if arguments:
        print("usage: check_system.py [--loads]", file=sys.stderr)
        return 2
    missing = {**missing_build_tools(), **missing_libraries()}
    if missing:
        print(sentence(missing), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
