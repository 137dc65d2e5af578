"""Scalar formulas as lists of operations: written down once each, and differentiated.

A `Tape` records operations on `Scalar` symbols. Equal operations on equal operands are one entry,
so that what a stress and its tangent share is computed once. Derivatives are written on the same
tape by the reverse sweep of algorithmic differentiation.

References: Griewank and Walther, Evaluating Derivatives (2008), section 3.2.
"""

from collections.abc import Callable, Sequence

import numpy as np

from fenics_defo.errors import MaterialError
from fenics_defo.runtime.operations import OPERATIONS, OperationList
from fenics_defo.runtime.operations.catalogue import WIDTH

type Number = "Scalar | float"

_COMMUTATIVE = {"add", "multiply", "minimum", "maximum", "equal", "not_equal"}
_COMMUTATIVE |= {"logical_and", "logical_or"}


class Scalar:
    """A value on a tape; arithmetic with it writes on the tape."""

    __slots__ = ("place", "tape")
    __array_ufunc__ = None  # NumPy's numbers leave arithmetic with it to it

    def __init__(self, tape: "Tape", place: int) -> None:
        self.tape = tape
        self.place = place

    def __add__(self, other: Number) -> Number:
        return self.tape.apply("add", self, other)

    def __radd__(self, other: Number) -> Number:
        return self.tape.apply("add", other, self)

    def __sub__(self, other: Number) -> Number:
        return self.tape.apply("subtract", self, other)

    def __rsub__(self, other: Number) -> Number:
        return self.tape.apply("subtract", other, self)

    def __mul__(self, other: Number) -> Number:
        return self.tape.apply("multiply", self, other)

    def __rmul__(self, other: Number) -> Number:
        return self.tape.apply("multiply", other, self)

    def __truediv__(self, other: Number) -> Number:
        return self.tape.apply("divide", self, other)

    def __rtruediv__(self, other: Number) -> Number:
        return self.tape.apply("divide", other, self)

    def __pow__(self, other: Number) -> Number:
        return self.tape.apply("power", self, other)

    def __rpow__(self, other: Number) -> Number:
        return self.tape.apply("power", other, self)

    def __neg__(self) -> Number:
        return self.tape.apply("negative", self)


class Tape:
    """Operations on inputs, in the order in which they were written.

    Args:
        inputs: number of inputs.
    """

    def __init__(self, inputs: int) -> None:
        #: Operation and operands of each value; none for an input.
        self._entries: list[tuple[str, tuple[Number, ...]] | None] = [None] * inputs
        self._known: dict[tuple[object, ...], Scalar] = {}
        self.inputs = tuple(Scalar(self, place) for place in range(inputs))

    def apply(self, name: str, *operands: Number) -> Number:
        """The result of an operation: a number if all operands are, else a value on the tape."""
        values = tuple(x if isinstance(x, Scalar) else float(x) for x in operands)
        if not any(isinstance(x, Scalar) for x in values):
            with np.errstate(all="ignore"):
                numbers = [np.array(x) for x in values]
                return float(OPERATIONS[name].function(*numbers, out=np.empty(())))
        shorter = _simplified(self, name, values)
        if shorter is not None:
            return shorter
        keys = [("value", x.place) if isinstance(x, Scalar) else ("number", x) for x in values]
        key = (name, *(sorted(keys) if name in _COMMUTATIVE else keys))
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = Scalar(self, len(self._entries))
            self._entries.append((name, values))
        return found

    def gradient(self, value: Number, inputs: Sequence[Scalar]) -> list[Number]:
        """Derivatives of a value by some inputs, written on the tape."""
        if not isinstance(value, Scalar):
            return [0.0] * len(inputs)
        slopes: dict[int, Number] = {value.place: 1.0}
        wanted = self._on_the_way(value, inputs)
        for place in sorted(wanted, reverse=True):
            entry = self._entries[place]
            slope = slopes.get(place, 0.0)
            if entry is None or _is(slope, 0.0):
                continue
            name, operands = entry
            for position, operand in enumerate(operands):
                if isinstance(operand, Scalar) and operand.place in wanted:
                    partial = self._partial(name, operands, position, Scalar(self, place))
                    step = self.apply("multiply", slope, partial)
                    earlier = slopes.get(operand.place, 0.0)
                    slopes[operand.place] = self.apply("add", earlier, step)
        return [slopes.get(scalar.place, 0.0) for scalar in inputs]

    def _on_the_way(self, value: Scalar, inputs: Sequence[Scalar]) -> set[int]:
        """Places that ``value`` depends on and that depend on ``inputs``."""
        depends = {scalar.place for scalar in inputs}
        for place in range(value.place + 1):
            entry = self._entries[place]
            if entry and any(isinstance(x, Scalar) and x.place in depends for x in entry[1]):
                depends.add(place)
        return depends & self._needed([value])

    def _needed(self, values: Sequence[Number]) -> set[int]:
        """Places that values depend on, their own included."""
        needed: set[int] = set()
        stack = [x.place for x in values if isinstance(x, Scalar)]
        while stack:
            place = stack.pop()
            if place in needed:
                continue
            needed.add(place)
            entry = self._entries[place]
            stack += [x.place for x in (entry[1] if entry else ()) if isinstance(x, Scalar)]
        return needed

    def _partial(
        self, name: str, operands: tuple[Number, ...], position: int, result: Scalar
    ) -> Number:
        if name in _FLAT:
            return 0.0
        rule = _PARTIALS.get(name)
        if rule is None:
            raise MaterialError(f"the derivative of {name!r} is not known")
        return rule(self, operands, position, result)

    def listing(self, outputs: Sequence[Number]) -> OperationList:
        """What computes some values, and no more, from all the inputs."""
        needed = self._needed(outputs)
        first = len(self.inputs)
        chosen = sorted(place for place in needed if place >= first)
        entries = [self._entries[place] for place in chosen]
        numbers: dict[float, int] = {}
        for operand in (x for entry in entries if entry for x in entry[1]):
            if not isinstance(operand, Scalar):
                numbers.setdefault(operand, first + len(numbers))
        for value in outputs:
            if not isinstance(value, Scalar):
                numbers.setdefault(float(value), first + len(numbers))
        places = {place: place for place in range(first)}
        places |= {place: first + len(numbers) + row for row, place in enumerate(chosen)}

        def number(x: Number) -> int:
            return places[x.place] if isinstance(x, Scalar) else numbers[float(x)]

        codes, operands = [], []
        for entry in entries:
            assert entry is not None  # inputs come before
            codes.append(OPERATIONS[entry[0]].code)
            row = [number(x) for x in entry[1]]
            operands.append(row + [-1] * (WIDTH - len(row)))
        return OperationList(
            inputs=first,
            constants=np.array(list(numbers), np.float64),
            codes=np.array(codes, np.int64),
            operands=np.array(operands, np.int64).reshape(-1, WIDTH),
            outputs=np.array([number(x) for x in outputs], np.int64),
        )


def _is(value: Number, number: float) -> bool:
    return not isinstance(value, Scalar) and value == number


def _simplified(tape: Tape, name: str, operands: tuple[Number, ...]) -> Number | None:
    """A shorter way to the same finite value, if there is one."""
    rule = _SIMPLER.get(name)
    return rule(tape, *operands) if rule else None


def _add(tape: Tape, a: Number, b: Number) -> Number | None:
    return b if _is(a, 0.0) else a if _is(b, 0.0) else None


def _subtract(tape: Tape, a: Number, b: Number) -> Number | None:
    return a if _is(b, 0.0) else tape.apply("negative", b) if _is(a, 0.0) else None


def _multiply(tape: Tape, a: Number, b: Number) -> Number | None:
    for x, y in ((a, b), (b, a)):
        if _is(x, 0.0):
            return 0.0
        if _is(x, 1.0):
            return y
        if _is(x, -1.0):
            return tape.apply("negative", y)
    if isinstance(a, Scalar) and isinstance(b, Scalar) and a.place == b.place:
        return tape.apply("square", a)
    return None


def _divide(tape: Tape, a: Number, b: Number) -> Number | None:
    if _is(a, 0.0):
        return 0.0
    if isinstance(b, Scalar):
        return tape.apply("reciprocal", b) if _is(a, 1.0) else None
    return a if _is(b, 1.0) else None


def _power(tape: Tape, a: Number, b: Number) -> Number | None:
    """Powers that are products: NumPy's general power takes ten times as long."""
    if isinstance(b, Scalar):
        return None
    short: dict[float, Callable[[], Number]] = {
        0.0: lambda: 1.0,
        1.0: lambda: a,
        2.0: lambda: tape.apply("square", a),
        3.0: lambda: tape.apply("multiply", tape.apply("square", a), a),
        4.0: lambda: tape.apply("square", tape.apply("square", a)),
        0.5: lambda: tape.apply("sqrt", a),
        -1.0: lambda: tape.apply("reciprocal", a),
        -2.0: lambda: tape.apply("reciprocal", tape.apply("square", a)),
    }
    found = short.get(b)
    return found() if found else None


def _where(tape: Tape, condition: Number, yes: Number, no: Number) -> Number | None:
    if not isinstance(condition, Scalar):
        return yes if condition else no
    same = isinstance(yes, Scalar) and isinstance(no, Scalar) and yes.place == no.place
    same = same or (not isinstance(yes, Scalar) and not isinstance(no, Scalar) and yes == no)
    return yes if same else None


_SIMPLER: dict[str, Callable[..., Number | None]] = {
    "add": _add,
    "subtract": _subtract,
    "multiply": _multiply,
    "divide": _divide,
    "power": _power,
    "where": _where,
}

#: Operations whose derivative is zero wherever there is one.
_FLAT = {"sign", "less", "less_equal", "greater", "greater_equal", "equal", "not_equal"}
_FLAT |= {"logical_and", "logical_or", "logical_not"}

type Rule = Callable[[Tape, tuple[Number, ...], int, Scalar], Number]


def _power_partial(tape: Tape, ab: tuple[Number, ...], position: int, result: Scalar) -> Number:
    a, b = ab
    if position == 1:
        return result * tape.apply("log", a)
    if not isinstance(b, Scalar) and b < 1.0:  # the same power again, which has no value at 0
        return b * (result / a)
    return b * tape.apply("power", a, tape.apply("subtract", b, 1.0))


def _extreme(name: str) -> Rule:
    def rule(tape: Tape, ab: tuple[Number, ...], position: int, result: Scalar) -> Number:
        return tape.apply("where", tape.apply(name, *ab), 1.0 - position, float(position))

    return rule


def _arctan2(tape: Tape, yx: tuple[Number, ...], position: int, result: Scalar) -> Number:
    y, x = yx
    square = tape.apply("add", tape.apply("square", x), tape.apply("square", y))
    along = x if position == 0 else tape.apply("negative", y)
    return tape.apply("divide", along, square)


def _of_one(rule: Callable[[Callable[..., Number], Number, Scalar], Number]) -> Rule:
    return lambda tape, operands, _, result: rule(tape.apply, operands[0], result)


_PARTIALS: dict[str, Rule] = {
    "add": lambda tape, ab, i, r: 1.0,
    "subtract": lambda tape, ab, i, r: 1.0 - 2.0 * i,
    "multiply": lambda tape, ab, i, r: ab[1 - i],
    "divide": lambda tape, ab, i, r: tape.apply("divide", 1.0, ab[1]) if i == 0 else -(r / ab[1]),
    "negative": lambda tape, a, i, r: -1.0,
    "square": lambda tape, a, i, r: 2.0 * a[0],
    "reciprocal": _of_one(lambda f, a, r: f("negative", f("square", r))),
    "power": _power_partial,
    "sqrt": _of_one(lambda f, a, r: f("divide", 0.5, r)),
    "exp": _of_one(lambda f, a, r: r),
    "log": _of_one(lambda f, a, r: f("divide", 1.0, a)),
    "absolute": _of_one(lambda f, a, r: f("sign", a)),
    "minimum": _extreme("less"),
    "maximum": _extreme("greater"),
    "sin": _of_one(lambda f, a, r: f("cos", a)),
    "cos": _of_one(lambda f, a, r: f("negative", f("sin", a))),
    "tan": _of_one(lambda f, a, r: f("add", 1.0, f("square", r))),
    "arcsin": _of_one(lambda f, a, r: f("divide", 1.0, f("sqrt", 1.0 - f("square", a)))),
    "arccos": _of_one(lambda f, a, r: f("divide", -1.0, f("sqrt", 1.0 - f("square", a)))),
    "arctan": _of_one(lambda f, a, r: f("divide", 1.0, f("add", 1.0, f("square", a)))),
    "arctan2": _arctan2,
    "sinh": _of_one(lambda f, a, r: f("cosh", a)),
    "cosh": _of_one(lambda f, a, r: f("sinh", a)),
    "tanh": _of_one(lambda f, a, r: 1.0 - f("square", r)),
    "where": lambda tape, cyn, i, r: (
        0.0 if i == 0 else tape.apply("where", cyn[0], 2.0 - i, i - 1.0)
    ),
}
