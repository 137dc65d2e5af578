"""Numbers from UFL expressions at given deformation gradients, with NumPy alone.

UFL lowers the expression (derivatives included), and it is walked once from its leaves up. Each
node becomes one array (b, *shape, *free), with b points (or 1), the node's tensor shape, and one
axis for each free index in UFL's own order, ascending. Only the kinds of node listed in `_RULES`
are known; there is no compiler.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from ufl import classes as nodes
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

from fenics_defo.errors import MaterialError

type Array = NDArray[Any]  # of float64, or of bool for a condition


def evaluate(expression: Expr, values: Mapping[Expr, ArrayLike]) -> NDArray[np.float64]:
    """Value of a UFL ``expression`` at b points.

    Args:
        expression: no free indices; may hold ``ufl.diff`` with respect to UFL variables.
        values: for each variable, coefficient or constant in it, either one value of its shape, or
            b of them, shape (b, *shape).

    Returns:
        (b, *shape), with b = 1 where no point was given; NaN or infinite where it has no value.

    Raises:
        MaterialError: ``expression`` holds a node that has no value at a point, or is not known.
    """
    (result,) = Program([expression], list(values))(*values.values())
    return result.copy()


class Program:
    """UFL expressions made ready to be evaluated many times.

    What several expressions share is computed once, and what depends on no symbol once for all.

    Args:
        expressions: see `evaluate`.
        symbols: the variables, coefficients and constants in them that will be given values.

    Raises:
        MaterialError: an expression holds a node that has no value at a point, or is not known.
    """

    def __init__(self, expressions: Sequence[Expr], symbols: Sequence[Expr]) -> None:
        self._symbols = list(symbols)
        places = {node_key(symbol): place for place, symbol in enumerate(symbols)}
        self._roots = [apply_derivatives(apply_algebra_lowering(e)) for e in expressions]
        self._constants: dict[int, Array] = {}
        self._steps: list[tuple[int, Callable[[list[Array]], Array], list[int]]] = []
        for root in self._roots:
            self._plan(root, places)
        self._results = [places[node_key(root)] for root in self._roots]
        self._size = len(places)

    def _plan(self, root: Expr, places: dict[Expr, int]) -> None:
        """Append the steps that lead to ``root``; each node gets a place for its value."""
        stack = [root]
        while stack:
            node = stack[-1]
            children = node_children(node)
            if node_key(node) in places:
                stack.pop()
            elif waiting := [child for child in children if node_key(child) not in places]:
                stack.extend(waiting)
            else:
                place = places[node_key(node)] = len(places)
                operands = [places[node_key(child)] for child in children]
                if all(operand in self._constants for operand in operands):
                    with np.errstate(all="ignore"):
                        value = node_rule(node, FUNCTIONS)(
                            [self._constants[operand] for operand in operands]
                        )
                    self._constants[place] = value
                else:
                    self._steps.append((place, node_rule(node, FUNCTIONS), operands))

    def __call__(self, *values: ArrayLike) -> list[NDArray[np.float64]]:
        """Value of each expression at b points, for values of the symbols in their order.

        Args:
            values: for each symbol either one value of its shape, or b of them, (b, *shape).

        Returns:
            for each expression (b, *shape), b = 1 where no point was given; a view that must not
            be written to; NaN or infinite where it has no value.
        """
        known: list[Array | None] = [None] * self._size
        for place, (symbol, value) in enumerate(zip(self._symbols, values, strict=True)):
            known[place] = _batch(symbol, value)
        points = max((len(array) for array in known if array is not None), default=1)
        for place, constant in self._constants.items():
            known[place] = constant
        with np.errstate(all="ignore"):  # the caller sees NaN and infinity in the result
            for place, function, operands in self._steps:
                known[place] = function([known[operand] for operand in operands])  # type: ignore[misc]
        answers = zip(self._roots, self._results, strict=True)
        return [_broadcast(known[place], (points, *root.ufl_shape)) for root, place in answers]


def _broadcast(value: Array | None, shape: tuple[int, ...]) -> NDArray[np.float64]:
    assert value is not None
    return np.broadcast_to(value.astype(np.float64, copy=False), shape)


def node_key(node: Expr) -> Expr:
    """What a node is bound by: lowering may rewrite what is inside a variable, not its label."""
    return node.label() if isinstance(node, nodes.Variable) else node


def _batch(symbol: Expr, value: ArrayLike) -> Array:
    array = np.asarray(value, dtype=np.float64)
    return array[np.newaxis] if array.ndim == len(symbol.ufl_shape) else array


def node_children(node: Expr) -> list[Expr]:
    """Operands that have a value."""
    return [c for c in node.ufl_operands if not isinstance(c, nodes.MultiIndex | nodes.Label)]


def node_rule(
    node: Expr, functions: Mapping[type[Expr], Callable[..., Array]]
) -> Callable[[list[Array]], Array]:
    """What computes ``node`` from its operands' values.

    Args:
        node: of an expression without derivatives.
        functions: what computes the values of each kind of node, entry by entry; what only moves
            entries is known.

    Raises:
        MaterialError: the node has no value at a point, or is not known.
    """
    function, rule = functions.get(type(node)), _RULES.get(type(node))
    if function is not None:
        if any(child.ufl_free_indices for child in node_children(node)):
            return partial(_aligned, function, node)
        return lambda operands: function(*operands)
    if rule is None:
        raise MaterialError(
            f"the energy holds {node} ({type(node).__name__}), which has no value at one point; "
            "use F, UFL's algebra and elementary functions, and pass numbers as constants"
        )
    return partial(rule, node)


def _aligned(function: Callable[..., Array], node: Expr, operands: list[Array]) -> Array:
    """Function of scalars, or of tensors of one shape, with their free indices."""
    target = node.ufl_free_indices
    aligned = []
    for child, array in zip(node_children(node), operands, strict=True):
        shape_axes = [slice(None)] * (1 + len(child.ufl_shape))
        free_axes = [slice(None) if i in child.ufl_free_indices else None for i in target]
        aligned.append(array[(*shape_axes, *free_axes)])
    return function(*aligned)


def _power(base: Array, exponent: Array) -> Array:
    """numpy.power, which is an order slower than a product for the commonest exponents."""
    if exponent.size == 1:
        known = {2.0: np.square, 1.0: np.positive, -1.0: np.reciprocal, 0.5: np.sqrt}
        function = known.get(float(exponent.flat[0]))
        if function is not None:
            return function(base)
    return np.power(base, exponent)


def _zero(node: Expr, _: list[Array]) -> Array:
    return np.zeros((1, *node.ufl_shape, *node.ufl_index_dimensions))


def _number(node: Expr, _: list[Array]) -> Array:
    return np.array([float(node)])


def _identity(node: Expr, _: list[Array]) -> Array:
    return np.eye(*node.ufl_shape)[np.newaxis]


def _operand(_: Expr, operands: list[Array]) -> Array:
    return operands[0]


def _conditional(_: Expr, operands: list[Array]) -> Array:
    condition, yes, no = operands
    return np.where(condition.reshape(-1, *[1] * (yes.ndim - 1)), yes, no)


def _indexed(node: Expr, operands: list[Array]) -> Array:
    """Components: fixed indices pick, a free index names an axis (twice: the diagonal)."""
    child, chosen = node.ufl_operands
    picks: list[int | slice] = [slice(None)]
    labels = []
    for index in chosen.indices():
        fixed = isinstance(index, nodes.FixedIndex)
        picks.append(int(index) if fixed else slice(None))
        labels += [] if fixed else [index.count()]
    labels += child.ufl_free_indices
    # einsum takes small axis numbers only; 0 is the axis of the points.
    number = {label: axis for axis, label in enumerate(dict.fromkeys(labels), start=1)}
    axes = [0, *(number[label] for label in labels)]
    kept = [0, *(number[label] for label in node.ufl_free_indices)]
    return np.einsum(operands[0][tuple(picks)], axes, kept)


def _index_sum(node: Expr, operands: list[Array]) -> Array:
    child, summed = node.ufl_operands
    position = child.ufl_free_indices.index(summed[0].count())
    return operands[0].sum(axis=1 + len(child.ufl_shape) + position)


def _component_tensor(node: Expr, operands: list[Array]) -> Array:
    """Free indices of a scalar become axes of a tensor."""
    child, moved = node.ufl_operands
    order = [index.count() for index in moved.indices()] + list(node.ufl_free_indices)
    axes = [1 + child.ufl_free_indices.index(label) for label in order]
    return operands[0].transpose(0, *axes)


def _list_tensor(_: Expr, operands: list[Array]) -> Array:
    return np.stack(np.broadcast_arrays(*operands), axis=1)


_RULES: dict[type[Expr], Callable[[Expr, list[Array]], Array]] = {
    nodes.Zero: _zero,
    nodes.IntValue: _number,
    nodes.FloatValue: _number,
    nodes.Identity: _identity,
    nodes.Variable: _operand,
    nodes.Conj: _operand,  # everything is real here
    nodes.Real: _operand,
    nodes.Indexed: _indexed,
    nodes.IndexSum: _index_sum,
    nodes.ComponentTensor: _component_tensor,
    nodes.ListTensor: _list_tensor,
    nodes.Conditional: _conditional,
}

#: Functions of each entry; operands of one shape.
FUNCTIONS: dict[type[Expr], Callable[..., Array]] = {
    nodes.Sum: np.add,
    nodes.Product: np.multiply,
    nodes.Division: np.divide,
    nodes.Power: _power,
    nodes.Abs: np.abs,
    nodes.MinValue: np.minimum,
    nodes.MaxValue: np.maximum,
    nodes.Sqrt: np.sqrt,
    nodes.Exp: np.exp,
    nodes.Ln: np.log,
    nodes.Sin: np.sin,
    nodes.Cos: np.cos,
    nodes.Tan: np.tan,
    nodes.Asin: np.arcsin,
    nodes.Acos: np.arccos,
    nodes.Atan: np.arctan,
    nodes.Atan2: np.arctan2,
    nodes.Sinh: np.sinh,
    nodes.Cosh: np.cosh,
    nodes.Tanh: np.tanh,
    nodes.NotCondition: np.logical_not,  # of scalars, without free indices
    nodes.AndCondition: np.logical_and,
    nodes.OrCondition: np.logical_or,
    nodes.EQ: np.equal,
    nodes.NE: np.not_equal,
    nodes.LT: np.less,
    nodes.GT: np.greater,
    nodes.LE: np.less_equal,
    nodes.GE: np.greater_equal,
}
