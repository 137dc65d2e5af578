"""The grammar of comparisons such as ``z>=0.5 and y<0.1``, read into a small list of steps.

    either     := both ("or" both)*
    both       := negated ("and" negated)*
    negated    := "not" negated | comparison
    comparison := sum (("<" | "<=" | ">" | ">=" | "==") sum)*
    sum        := product (("+" | "-") product)*
    product    := signed (("*" | "/") signed)*
    signed     := ("+" | "-") signed | power
    power      := operand ("**" signed)?
    operand    := number | "x" | "y" | "z" | ("abs" | "sqrt") "(" either ")" | "(" either ")"

Each part is a number or a condition, and is checked to be the one that its place needs. Precedence
is Python's, and so is a chain: ``0<x<1`` means ``0<x and x<1``. Nothing is handed to Python's own
parser: the steps, in postfix order, know only what is listed here. Length and depth are limited, so
that no input can exhaust the stack.
"""

import math
import re
from collections.abc import Callable
from typing import Literal, NamedTuple, NoReturn

from fenics_defo.errors import SelectionError

MAX_LENGTH = 2000
#: Parentheses, signs, powers and ``not`` inside each other; each costs up to ten Python calls.
MAX_DEPTH = 40

type Kind = Literal["number", "condition"]

_COORDINATES = ("x", "y", "z")
_COMPARISONS = ("<", "<=", ">", ">=", "==")
_FUNCTIONS = ("abs", "sqrt")
_ALLOWED = (
    "allowed are x, y, z, numbers, + - * / **, abs(), sqrt(), < <= > >= ==, and, or, not, "
    "and parentheses"
)
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<word>[^\W\d]\w*)|(?P<symbol>\*\*|[<>=!]=|[-+*/()<>])|(?P<end>\Z)|(?P<unknown>.))"
)
_HINTS = {
    "=": "write == for equality within the tolerance",
    "!=": "write not (... == ...)",
    "^": "write ** for a power",
    "&": "write and",
    "|": "write or",
    "!": "write not",
    "'": "a quoted group name stands alone",
    '"': "a quoted group name stands alone",
}


class Step(NamedTuple):
    """One step, in postfix order.

    ``number`` and ``coordinate`` push a value; the others replace the uppermost values by their
    result: ``negate``, ``call`` and ``not`` one, ``binary`` and ``logic`` two, ``compare`` one more
    than it has operators. ``argument`` is the number, the coordinate, the name of the function or
    operator, or the operators of a chain of comparisons.
    """

    action: Literal["number", "coordinate", "negate", "call", "binary", "compare", "not", "logic"]
    argument: float | str | tuple[str, ...] = ""


def parse_comparison(text: str) -> tuple[Step, ...]:
    """Steps of the comparison ``text``, in postfix order.

    Raises:
        SelectionError: ``text`` is too long, too deep or not a condition on x, y and z; the message
            names the word at fault and its column, counted from 1.
    """
    if len(text) > MAX_LENGTH:
        raise SelectionError(
            f"the selection {shortened(text)!r} has {len(text)} characters, a comparison at most "
            f"{MAX_LENGTH}; name a group of the mesh, or list the nodes in a file: nodes:FILE"
        )
    return _Parser(text).whole()


def shortened(text: str) -> str:
    """``text`` cut to a length that fits into a message."""
    return text if len(text) <= 70 else f"{text[:60]}...{text[-7:]}"


class _Token(NamedTuple):
    kind: str  # "number", "word", "symbol", "end" or "unknown"
    text: str
    position: int  # from 0


class _Parser:
    """Recursive descent: each method appends the steps of what it reads and returns its kind."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = [
            _Token(str(m.lastgroup), m[m.lastgroup or 0], m.start(m.lastgroup or 0))
            for m in _TOKEN.finditer(text)
        ]
        self.steps: list[Step] = []
        self.index = 0
        self.depth = 0

    def whole(self) -> tuple[Step, ...]:
        """The condition that the whole text is."""
        kind = self._either()
        if self._token.kind != "end":
            self._unexpected("the end, and, or, or an operator")
        self._demand("condition", kind, 0)
        if not any(step.action == "coordinate" for step in self.steps):
            self._fail(0, "the condition names none of x, y and z, so it is the same everywhere")
        return tuple(self.steps)

    @property
    def _token(self) -> _Token:
        return self.tokens[self.index]

    def _take(self, *texts: str) -> str | None:
        """The next token, used up if it is one of ``texts``."""
        found = self._token.text
        if found not in texts:  # the empty text of the end is never asked for
            return None
        self.index += 1
        return found

    def _either(self) -> Kind:
        return self._left_to_right("logic", ("or",), self._both, "condition")

    def _both(self) -> Kind:
        return self._left_to_right("logic", ("and",), self._negated, "condition")

    def _negated(self) -> Kind:
        if not self._take("not"):
            return self._comparison()
        start = self._token.position
        self._demand("condition", self._nested(self._negated), start)
        self.steps.append(Step("not"))
        return "condition"

    def _comparison(self) -> Kind:
        start, kind = self._token.position, self._sum()
        operators: list[str] = []
        while operator := self._take(*_COMPARISONS):
            self._demand("number", kind, start)
            operators.append(operator)
            start, kind = self._token.position, self._sum()
            self._demand("number", kind, start)
        if not operators:
            return kind
        self.steps.append(Step("compare", tuple(operators)))
        return "condition"

    def _sum(self) -> Kind:
        return self._left_to_right("binary", ("+", "-"), self._product, "number")

    def _product(self) -> Kind:
        return self._left_to_right("binary", ("*", "/"), self._signed, "number")

    def _left_to_right(
        self,
        action: Literal["binary", "logic"],
        operators: tuple[str, ...],
        operand: Callable[[], Kind],
        needed: Kind,
    ) -> Kind:
        start, kind = self._token.position, operand()
        while operator := self._take(*operators):
            self._demand(needed, kind, start)
            start, kind = self._token.position, operand()
            self._demand(needed, kind, start)
            self.steps.append(Step(action, operator))
        return kind

    def _signed(self) -> Kind:
        sign = self._take("+", "-")
        if sign is None:
            return self._power()
        start = self._token.position
        self._demand("number", self._nested(self._signed), start)
        if sign == "-":
            self.steps.append(Step("negate"))
        return "number"

    def _power(self) -> Kind:
        start, kind = self._token.position, self._operand()
        if self._take("**"):
            self._demand("number", kind, start)
            start = self._token.position
            self._demand("number", self._nested(self._signed), start)
            self.steps.append(Step("binary", "**"))
        return kind

    def _operand(self) -> Kind:
        token = self._token
        if token.kind == "number":
            return self._number(token)
        if token.text in _COORDINATES:
            self.index += 1
            self.steps.append(Step("coordinate", token.text))
            return "number"
        if function := self._take(*_FUNCTIONS):
            if self._token.text != "(":
                self._unexpected(f"( after {function}")
            self._demand("number", self._parenthesis(), token.position)
            self.steps.append(Step("call", function))
            return "number"
        if token.text == "(":
            return self._parenthesis()
        self._unexpected("a coordinate, a number or a parenthesis")

    def _parenthesis(self) -> Kind:
        self.index += 1
        kind = self._nested(self._either)
        if not self._take(")"):
            self._unexpected("a closing parenthesis")
        return kind

    def _number(self, token: _Token) -> Kind:
        value = float(token.text)
        if not math.isfinite(value):
            self._fail(token.position, f"the number {shortened(token.text)} is too large")
        self.index += 1
        self.steps.append(Step("number", value))
        return "number"

    def _nested(self, part: Callable[[], Kind]) -> Kind:
        if self.depth == MAX_DEPTH:
            self._fail(self._token.position, f"nested more than {MAX_DEPTH} deep; simplify it")
        self.depth += 1
        kind = part()
        self.depth -= 1
        return kind

    def _demand(self, needed: Kind, found: Kind, start: int) -> None:
        if found == needed:
            return
        if needed == "condition":
            self._fail(start, "a condition is needed here, such as x<0.1, not a number")
        self._fail(start, "a number is needed here, not a condition")

    def _unexpected(self, expected: str) -> NoReturn:
        token = self._token
        if token.kind == "end":
            self._fail(token.position, f"it ends where {expected} is expected")
        if token.kind == "word" and token.text.lower() in (*_COORDINATES, *_FUNCTIONS, "and", "or"):
            hint = f"expected {expected}, in small letters"
        elif token.kind == "word":
            hint = f"{_ALLOWED}; a group name that looks like a comparison is put into quotes"
        else:
            hint = _HINTS.get(token.text, f"expected {expected}; {_ALLOWED}")
        self._fail(token.position, f"unexpected {shortened(token.text)!r}; {hint}")

    def _fail(self, position: int, problem: str) -> NoReturn:
        column = position + 1
        raise SelectionError(f"selection {shortened(self.text)!r}, column {column}: {problem}")
