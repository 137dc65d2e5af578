"""Docstrings are plain text with `names` in backticks and indented formulas; Sphinx wants more.

What reStructuredText would take for markup (|F|, 2*x, q_) is escaped, names become references, and
indented formulas literal blocks. So no docstring can break the build, and none is written for it.
"""

import re
from itertools import groupby
from typing import Any

_CODE = re.compile(r"(``.+?``|`[^`]+`)")
_MARKUP = re.compile(r"[\\*|]|_(?!\w)")
_NAME = re.compile(r"[A-Za-z_][\w.]*")
_SECTION = re.compile(r"(Args|Returns|Yields|Raises|Attributes|References|Notes?|Examples?):$")
_ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[(?:Any|int), \.\.\.\], ~?(?:numpy\.)?dtype\[([^\]]+)\]\]"
)
_VALUES = ("attribute", "data", "property")
_FIELDS = {"Returns:": ":returns:", "Yields:": ":yields:"}
_escaped: dict[str, list[str]] = {}


def escape_docstring(
    app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    """Rewrite the lines of a docstring in place, before napoleon sees them."""
    begin = next((at for at, line in enumerate(lines) if _SECTION.match(line)), len(lines))
    lines[:] = [*_text(lines[:begin]), *_sections(lines[begin:])]
    if what == "module":
        lines[:] = _of_interest(lines)
    elif what in _VALUES:
        _escaped[name] = list(lines)


def restore_docstring(
    app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    """Undo what napoleon does to a value: it takes what stands before a colon for the type."""
    if what in _VALUES:
        lines[:] = _escaped.pop(name, lines)


def shorten_signature(
    app: Any, what: str, name: str, obj: Any, options: Any, signature: str, returned: str
) -> tuple[str, str]:
    """Write ``NDArray[float64]`` for what it stands for."""
    return _shorten(signature), _shorten(returned)


def _shorten(text: str | None) -> Any:
    if not text:
        return text
    # Sphinx cannot parse <factory>, and would show the text as it stands.
    text = _ARRAY.sub(r"NDArray[\1]", text.replace("<factory>", "..."))
    return text.replace("~numpy._typing._array_like.", "").replace("~numpy.float64", "float64")


def _of_interest(lines: list[str]) -> list[str]:
    """Return a package's docstring without how its names are loaded, which is for its writers."""
    begin = next((at for at, line in enumerate(lines) if "on first use" in line), len(lines))
    return lines[:begin]


def _text(lines: list[str]) -> list[str]:
    """Return paragraphs, of which those with indented lines keep their layout; but not lists."""
    written: list[str] = []
    for blank, group in groupby(lines, key=lambda line: not line.strip()):
        paragraph = list(group)
        laid_out = any(line.startswith("  ") for line in paragraph)
        if laid_out and not blank and not paragraph[0].startswith("- "):
            written += ["::", "", *(f"    {line}" for line in paragraph)]
        else:
            written += [_escape(line) for line in paragraph]
    return written


def _sections(lines: list[str]) -> list[str]:
    """Return Google's sections; what is returned as a field, with no type before a colon."""
    written: list[str] = []
    field = ""
    for line in lines:
        if line in _FIELDS:
            field = _FIELDS[line]
        elif field and line.strip():
            written.append(f"{field} {_escape(line.strip())}")
            field = ""
        else:
            written.append(_escape(line))
    return written


def _escape(line: str) -> str:
    """Escape all but code; a name in backticks becomes a reference, where there is one."""
    parts = _CODE.split(line)
    parts[::2] = [_MARKUP.sub(lambda found: "\\" + found.group(), part) for part in parts[::2]]
    parts[1::2] = [_code(part) for part in parts[1::2]]
    return "".join(parts)


def _code(part: str) -> str:
    text = part.strip("`")
    if part.startswith("``") or not _NAME.fullmatch(text):
        return f"``{text}``"
    return f":py:obj:`{text}`"
