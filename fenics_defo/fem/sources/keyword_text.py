"""Text files made of ``*KEYWORD`` lines and lines of numbers, with other files included."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import MeshError
from fenics_defo.fem.sources.msh_cursor import text_numbers, whole

DEPTH = 32  # of files including files; deeper than any real model


@dataclass(frozen=True, slots=True, kw_only=True)
class Section:
    """A keyword line, without its star, and the data lines below it.

    Args:
        head: the keyword line.
        lines: data lines, comments and blank lines removed.
        where: file and line number of the keyword line, to begin a sentence with.
    """

    head: str
    lines: list[str]
    where: str

    def numbers(self, lines: list[str] | None = None) -> NDArray[np.float64]:
        """All numbers of the data lines, separated by white space or commas, (k,)."""
        text = "\n".join(self.lines if lines is None else lines)
        return text_numbers(text.replace(",", " "), self.where)

    def integers(self, lines: list[str] | None = None) -> NDArray[np.int64]:
        """The same as whole numbers, (k,)."""
        return whole(self.numbers(lines), self.where)


def read_sections(
    path: Path, *, comment: str, included: Callable[[str], str | None]
) -> list[Section]:
    """Sections of a file and of those it includes.

    Args:
        path: the file.
        comment: what a comment line begins with.
        included: from a keyword line without its star to the name of the file it includes, or
            None where it includes none.

    Raises:
        MeshError: not a text file; an included file is missing, or includes itself.
    """
    sections: list[Section] = []
    opening = Section(head="", lines=[], where=str(path))
    _append(sections, [opening], path, (), comment, included)
    return sections


def _append(
    sections: list[Section],
    current: list[Section],
    path: Path,
    stack: tuple[Path, ...],
    comment: str,
    included: Callable[[str], str | None],
) -> None:
    lines = [line.strip() for line in read_text(path).splitlines()]
    stars = [i for i, line in enumerate(lines) if line[:1] == "*" and not _is(line, comment)]
    for start, end in zip([-1, *stars], [*stars, len(lines)], strict=True):
        if start >= 0:
            head = lines[start][1:].strip()
            name = included(head)
            if name is None:
                current[0] = Section(
                    head=head, lines=[], where=f"{path}: line {start + 1} (*{head})"
                )
                sections.append(current[0])
            else:
                target = _target(name, path, (*stack, path), start + 1)
                # The lines of the included file continue the section that includes it.
                _append(sections, current, target, (*stack, path), comment, included)
        body = lines[start + 1 : end]
        current[0].lines.extend([line for line in body if line and not _is(line, comment)])


def _is(line: str, comment: str) -> bool:
    return line.startswith(comment)


def _target(name: str, path: Path, stack: tuple[Path, ...], line: int) -> Path:
    """The included file: beside the file that names it, or beside the first one."""
    where = f"{path}: line {line} includes {name!r}"
    if not name:
        raise MeshError(f"{path}: line {line} includes a file without naming it; add its name")
    candidates = [path.parent / name, stack[0].parent / name]
    target = next((c for c in candidates if c.is_file()), None)
    if target is None:
        raise MeshError(f"{where}, which does not exist in {path.parent}; put it there")
    if target.resolve() in {file.resolve() for file in stack} or len(stack) > DEPTH:
        raise MeshError(f"{where}, which includes this file again; remove the circle")
    return target


def read_text(path: Path) -> str:
    """Text of a file; refused if it holds zero bytes, as no text does."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path} cannot be opened ({error.strerror})") from None
    if b"\0" in data:
        raise MeshError(f"{path} is not a text file, as its suffix says; check what it is")
    return data.decode("utf-8", errors="replace")
