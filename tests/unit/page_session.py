"""Runs what a page shows, in its order: JSON steps on standard input, in the present folder.

Started by test_readme.py in a process of its own, as a reader of the page would have one. A Python
block that begins with an import begins afresh; another goes on from the one before it.
"""

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any


def main() -> None:
    """Do the steps; what fails says which line of which page it was."""
    names: dict[str, Any] = {}
    for kind, page, line, text in json.load(sys.stdin):
        if kind == "save":
            name = text.splitlines()[0].removeprefix("#").strip()
            Path(name).write_text(text, encoding="utf-8")
        elif kind == "run":
            words = shlex.split(text, comments=True)
            beside = Path(sys.executable).parent / Path(words[0]).name
            done = subprocess.run([beside, *words[1:]], capture_output=True, text=True)
            if done.returncode != 0:
                raise SystemExit(f"{page}:{line}: {text}\n{done.stderr}")
        else:
            if text.startswith(("import ", "from ")):
                names = {"__name__": "__main__"}
            # Empty lines before the block let tracebacks name the page's own line.
            exec(compile("\n" * line + text, page, "exec"), names)


if __name__ == "__main__":
    main()
