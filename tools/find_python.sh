#!/bin/sh
# Print the path of the Python that .venv is made with: the first one, 3.12 or newer, that really runs.
# A command that is found but fails (a pyenv shim of a version that is not active) is passed over.
#
#   PYTHON=...   use this one, or fail with the reason
#
# Order: python3.14 ... python3.12 and python3 on PATH, pyenv's own versions, uv's.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd -P)

# CPython with its lock: the compiled packages have no wheels for PyPy or the free-threaded builds.
# Inside a virtual environment the Python it was made from is the one to take: the active one may well
# be the half-made .venv that is about to be replaced.
suits='
import sys, sysconfig
free_threaded = sysconfig.get_config_var("Py_GIL_DISABLED") == 1
if sys.version_info < (3, 12) or sys.implementation.name != "cpython" or free_threaded:
    sys.exit(3)
print(getattr(sys, "_base_executable", None) or sys.executable)
'

path_of() { # COMMAND: prints its interpreter's own path if it suits
    "$1" -c "$suits" </dev/null 2>/dev/null
}

fail() {
    printf '%s\n' "$1" >&2
    exit 1
}

if [ -n "${PYTHON:-}" ]; then
    if path_of "$PYTHON"; then
        exit 0
    fi
    version=$("$PYTHON" -c 'import platform as p; print(p.python_implementation(), p.python_version())' \
        </dev/null 2>/dev/null) ||
        fail "PYTHON=$PYTHON does not run: give the path of a Python 3.12 or newer, or leave PYTHON unset to search for one."
    fail "PYTHON=$PYTHON is $version, and CPython 3.12 or newer is needed: give another, or leave PYTHON unset to search for one."
fi

# A Python that cannot make a virtual environment (Debian's without python3-venv) is kept in mind but only
# taken when there is no better one; check_system.py then names the package that it lacks.
without_venv=''

take() { # COMMAND: prints and ends if it suits
    found=$(path_of "$1") || return 0
    if "$found" -c 'import ensurepip, venv' </dev/null >/dev/null 2>&1; then
        printf '%s\n' "$found"
        exit 0
    fi
    without_venv=${without_venv:-$found}
}

for name in python3.14 python3.13 python3.12 python3; do
    take "$name"
done

versions=${PYENV_ROOT:-${HOME:-/nonexistent}/.pyenv}/versions
if [ -d "$versions" ]; then
    for name in $(cd "$versions" && printf '%s\n' 3.* | sort -rV); do
        take "$versions/$name/bin/python3"
    done
fi

if command -v uv >/dev/null 2>&1; then
    found=$(uv python find --system --no-project '>=3.12' 2>/dev/null) && take "$found"
    # What uv downloads stays inside the project too.
    UV_PYTHON_INSTALL_DIR=$root/.cache/python UV_PYTHON_INSTALL_BIN=0 UV_PYTHON_PREFERENCE=only-managed
    export UV_PYTHON_INSTALL_DIR UV_PYTHON_INSTALL_BIN UV_PYTHON_PREFERENCE
    if [ -z "$without_venv" ] && uv python install --quiet 3.12 >&2; then
        found=$(uv python find --system --no-project 3.12) && take "$found"
    fi
fi

if [ -n "$without_venv" ]; then
    printf '%s\n' "$without_venv"
    exit 0
fi

as_root=''
[ "$(id -u)" = 0 ] || as_root='sudo '
fail "No Python 3.12 or newer was found: on Debian 13, Ubuntu 24.04 and newer run \`${as_root}apt-get install python3 python3-venv python3-dev\`, elsewhere install one with uv (\`uv python install 3.12\`) or pyenv, or name one with PYTHON=/path/to/python3.12."
