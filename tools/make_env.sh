#!/bin/sh
# Fill .venv with what pyproject.toml asks for, in the versions of constraints.txt. Called by make.
#
# .venv/.begun becomes .venv/.complete when everything is in place and was seen to load. A .venv with
# .begun was interrupted, at whatever point, and is made afresh; one with neither file is not ours.
set -eu

root=$(CDPATH='' cd -- "$(dirname -- "$0")/.." && pwd -P)
cd "$root"
begun=.venv/.begun
complete=.venv/.complete
dropped=.cache/dropped-venv

say() {
    printf '%s\n' "$*" >&2
}

works_here() { # a .venv holds its own path, so it does not survive a move
    [ -f "$complete" ] && [ "$(cat "$complete")" = "$root" ] && .venv/bin/python -c '' 2>/dev/null
}

make_venv() {
    python=$(sh tools/find_python.sh)
    "$python" tools/check_system.py
    if [ -e .venv ]; then
        # Renamed first: a removal that is interrupted must not leave half of it under its name.
        rm -rf "$dropped"
        mv .venv "$dropped"
        rm -rf "$dropped"
    fi
    mkdir .venv
    : >"$begun"
    say "Making .venv with $("$python" --version) ($python)"
    "$python" -m venv .venv
}

install_with_uv() { # minutes faster than pip, which fetches one wheel after the other
    .venv/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt uv &&
        UV_PYTHON_DOWNLOADS=never .venv/bin/uv pip install --compile-bytecode --python .venv/bin/python \
            --constraints constraints.txt --build-constraints constraints.txt --editable '.[dev]'
}

install_with_pip() { # knows every proxy, mirror and certificate that pip was told of
    .venv/bin/python -m pip install --disable-pip-version-check -c constraints.txt hatchling editables &&
        .venv/bin/python -m pip install --disable-pip-version-check -c constraints.txt \
            --no-build-isolation --editable '.[dev]'
}

mkdir -p .cache
if command -v flock >/dev/null 2>&1; then # two makes at once: the second waits, then finds it done
    exec 9>.cache/env.lock
    flock 9
fi

if works_here; then
    if [ -z "$(find pyproject.toml constraints.txt -newer "$complete")" ]; then
        exit 0
    fi
    say "pyproject.toml or constraints.txt has changed: updating .venv"
    mv "$complete" "$begun"
elif [ -e .venv ] && ! [ -f "$begun" ] && ! [ -f "$complete" ] && ! rmdir .venv 2>/dev/null; then
    say "The folder .venv was not made by make: move it away or delete it, then run make again."
    exit 1
else
    make_venv
fi

say "Installing into .venv (about 0.5 GB to download the first time)"
if ! install_with_uv; then
    say "uv could not install; trying pip"
    install_with_pip
fi
.venv/bin/python tools/check_system.py --loads
printf '%s\n' "$root" >"$begun"
mv "$begun" "$complete"
