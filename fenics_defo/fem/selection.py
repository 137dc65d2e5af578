"""Selections: the part of a mesh that the user means, as text, before any mesh is at hand.

A selection is the name of a physical group, its number, a comparison of coordinates in metres such
as ``x<1e-6`` or ``z>=0.5 and y<0.1``, or ``nodes:FILE``, a file of node numbers.
"""

import operator
import re
from collections.abc import Callable, Container
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import SelectionError
from fenics_defo.fem.selection_grammar import Step, parse_comparison, shortened

#: Largest difference of two equal lengths, as a part of the mesh's diagonal.
EQUALITY = 1e-9

_NODE_FILE = "nodes:"


@dataclass(frozen=True, slots=True)
class GroupSelection:
    """A physical group of the mesh.

    Args:
        group: its name, or its number.
    """

    group: str | int


@dataclass(frozen=True, slots=True)
class ComparisonSelection:
    """The points whose coordinates fulfil a condition.

    Args:
        text: the condition as the user wrote it; see `selection_grammar`.

    Raises:
        SelectionError: ``text`` is not such a condition.
    """

    text: str

    def __post_init__(self) -> None:
        parse_comparison(self.text)

    def evaluate(self, points: ArrayLike, tolerance: float) -> NDArray[np.bool_]:
        """Which of ``points`` fulfil the condition.

        A quotient or a root without a value (NaN) fulfils no comparison; < and > ignore
        ``tolerance``.

        Args:
            points: (n, 3) [m].
            tolerance: a == b means |a − b| <= ``tolerance``, [m] if a and b are lengths; on
                each rank that of the whole mesh, see `equality_tolerance`.

        Returns:
            (n,) bool.
        """
        points = np.asarray(points, dtype=np.float64)
        stack: list[Any] = []  # of arrays (n,) or single numbers
        with np.errstate(all="ignore"):  # overflow and 0/0 are values here
            for step in parse_comparison(self.text):
                _advance(stack, step, points, tolerance)
        return np.broadcast_to(stack.pop(), len(points)).copy()


@dataclass(frozen=True, slots=True)
class NodeFileSelection:
    """Nodes listed in a file, by their one-based numbers in the mesh file.

    Args:
        path: text file; numbers separated by commas, spaces or lines.
    """

    path: Path

    def read(self) -> NDArray[np.int64]:
        """The numbers in the file: (k,) int64, one-based, ascending, each once.

        Raises:
            SelectionError: the file cannot be read, holds none, or something else than whole
                numbers from 1.
        """
        try:
            text = self.path.read_text(encoding="utf-8-sig", errors="replace")
        except OSError as error:
            raise SelectionError(
                f"the node file {self.path} cannot be read ({error.strerror})"
            ) from error
        # Eighteen digits always fit into 64 bits.
        wrong = re.search(r"(?<![^\s,])(?!0{0,20}[1-9][0-9]{0,17}(?![^\s,]))[^\s,]+", text)
        if wrong:
            line = text.count("\n", 0, wrong.start()) + 1
            raise SelectionError(
                f"{self.path}, line {line}: {shortened(wrong.group())!r} is no node number; "
                "allowed are whole numbers from 1, separated by commas, spaces or lines"
            )
        numbers = text.replace(",", " ").split()
        if not numbers:
            raise SelectionError(f"the node file {self.path} holds no node number")
        return np.unique(np.fromiter(map(int, numbers), dtype=np.int64, count=len(numbers)))


type Selection = GroupSelection | ComparisonSelection | NodeFileSelection


def parse_selection(selection: str | int, *, groups: Container[str] = ()) -> Selection:
    """What the user's text selects.

    Looked at in this order: a name among ``groups``, exactly; ``nodes:FILE``; a name in single or
    double quotes; a number; a comparison, known by one of the signs < > =; else a group's name.

    Args:
        selection: the user's text, or a group's number.
        groups: names of the groups of the mesh, where they are known: a name that looks like
            something else then needs no quotes.

    Raises:
        SelectionError: the text is empty, or a comparison that is not well formed.
    """
    if isinstance(selection, int) and not isinstance(selection, bool):
        return GroupSelection(selection)
    if not isinstance(selection, str):
        raise SelectionError(
            f"a selection must be a text or a group's number, got {selection!r}; "
            "write a group's name, its number, a comparison such as 'x<1e-6', or 'nodes:FILE'"
        )
    if selection in groups:
        return GroupSelection(selection)
    text = selection.strip()
    if not text:
        raise SelectionError(
            "a selection is empty; "
            "write a group's name, its number, a comparison such as 'x<1e-6', or 'nodes:FILE'"
        )
    if text in groups:
        return GroupSelection(text)
    if text.startswith(_NODE_FILE):
        return _node_file(text)
    if text[0] in "'\"":
        return _quoted(text)
    if re.fullmatch(r"[0-9]{1,18}", text):
        return GroupSelection(int(text))
    return ComparisonSelection(text) if re.search("[<>=]", text) else GroupSelection(text)


def equality_tolerance(lower: ArrayLike, upper: ArrayLike) -> float:
    """Tolerance of == [m]: 1e-9 of the diagonal of the whole mesh's bounding box.

    Args:
        lower: smallest coordinates (3,) [m].
        upper: largest coordinates (3,) [m].
    """
    diagonal = np.asarray(upper, dtype=np.float64) - np.asarray(lower, dtype=np.float64)
    return EQUALITY * float(np.linalg.norm(diagonal))


def _node_file(text: str) -> NodeFileSelection:
    name = text.removeprefix(_NODE_FILE).strip()
    if not name or "\0" in name:
        raise SelectionError(f"the selection {text!r} names no file; write nodes:FILE")
    return NodeFileSelection(Path(name))


def _quoted(text: str) -> GroupSelection:
    name = text[1:-1]
    if len(text) < 2 or text[-1] != text[0] or text[0] in name or not name.strip():
        raise SelectionError(
            f"the selection {shortened(text)} starts with a quote, but is not one quoted group name"
        )
    return GroupSelection(name)


_BINARY: dict[str, Callable[[Any, Any], Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": np.power,
    "and": np.logical_and,
    "or": np.logical_or,
}
_CALLS: dict[str, Callable[[Any], Any]] = {"abs": np.abs, "sqrt": np.sqrt}
_ORDER: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def _advance(stack: list[Any], step: Step, points: NDArray[np.float64], tolerance: float) -> None:
    """Take one step of a condition on the ``stack``."""
    match step:
        case Step("number", float(value)):
            stack.append(np.float64(value))
        case Step("coordinate", str(axis)):
            stack.append(points[:, "xyz".index(axis)])
        case Step("negate"):
            stack.append(-stack.pop())
        case Step("not"):
            stack.append(np.logical_not(stack.pop()))
        case Step("call", str(name)):
            stack.append(_CALLS[name](stack.pop()))
        case Step("binary" | "logic", str(name)):
            right, left = stack.pop(), stack.pop()
            stack.append(_BINARY[name](left, right))
        case Step("compare", tuple(operators)):
            operands = stack[-len(operators) - 1 :]
            del stack[-len(operators) - 1 :]
            pairs = zip(operators, operands[:-1], operands[1:], strict=True)
            results = [
                np.abs(a - b) <= tolerance if sign == "==" else _ORDER[sign](a, b)
                for sign, a, b in pairs
            ]
            stack.append(np.logical_and.reduce(np.broadcast_arrays(*results)))
