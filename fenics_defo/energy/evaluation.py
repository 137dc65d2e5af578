"""Numbers from UFL expressions at given deformation gradients, with NumPy alone.

UFL lowers the expression (derivatives included), and it is walked once from its leaves up. Each
node becomes one array (b, *shape, *free), with b points (or 1), the node's tensor shape, and one
axis for each free index in UFL's own order, ascending. Only the kinds of node listed in `_RULES`
are known; there is no compiler.
"""

from collections.abc import Callable, Mapping
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
    bound = {_key(symbol): _batch(symbol, value) for symbol, value in values.items()}
    points = max((len(array) for array in bound.values()), default=1)
    root = apply_derivatives(apply_algebra_lowering(expression))
    known: dict[Expr, Array] = {}
    stack = [root]
    with np.errstate(all="ignore"):  # the caller sees NaN and infinity in the result
        while stack:
            node = stack[-1]
            if node in known:
                stack.pop()
            elif _key(node) in bound:
                known[node] = bound[_key(node)]
            elif waiting := [child for child in _children(node) if child not in known]:
                stack.extend(waiting)
            else:
                known[node] = _apply(node, [known[child] for child in _children(node)])
    return np.broadcast_to(known[root], (points, *root.ufl_shape)).astype(np.float64)


def _key(node: Expr) -> Expr:
    """What a node is bound by: lowering may rewrite what is inside a variable, not its label."""
    return node.label() if isinstance(node, nodes.Variable) else node


def _batch(symbol: Expr, value: ArrayLike) -> Array:
    array = np.asarray(value, dtype=np.float64)
    return array[np.newaxis] if array.ndim == len(symbol.ufl_shape) else array


def _children(node: Expr) -> list[Expr]:
    """Operands that have a value."""
    return [c for c in node.ufl_operands if not isinstance(c, nodes.MultiIndex | nodes.Label)]


def _apply(node: Expr, operands: list[Array]) -> Array:
    rule = _RULES.get(type(node))
    if rule is None:
        raise MaterialError(
            f"the energy holds {node} ({type(node).__name__}), which has no value at one point; "
            "use F, UFL's algebra and elementary functions, and pass numbers as constants"
        )
    return rule(node, operands)


def _elementwise(function: Callable[..., Array]) -> Callable[[Expr, list[Array]], Array]:
    """Rule of a function of scalars, or of tensors of one shape, with their free indices."""

    def rule(node: Expr, operands: list[Array]) -> Array:
        target = node.ufl_free_indices
        aligned = []
        for child, array in zip(_children(node), operands, strict=True):
            shape_axes = [slice(None)] * (1 + len(child.ufl_shape))
            free_axes = [slice(None) if i in child.ufl_free_indices else None for i in target]
            aligned.append(array[(*shape_axes, *free_axes)])
        return function(*aligned)

    return rule


def _zero(node: Expr, _: list[Array]) -> Array:
    return np.zeros((1, *node.ufl_shape, *node.ufl_index_dimensions))


def _number(node: Expr, _: list[Array]) -> Array:
    return np.array([float(node)])


def _identity(node: Expr, _: list[Array]) -> Array:
    return np.eye(*node.ufl_shape)[np.newaxis]


def _operand(_: Expr, operands: list[Array]) -> Array:
    return operands[0]


def _condition(function: Callable[..., Array]) -> Callable[[Expr, list[Array]], Array]:
    """Rule of a condition: UFL allows scalars without free indices only."""
    return lambda _, operands: function(*operands)


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
    nodes.NotCondition: _condition(np.logical_not),
    nodes.AndCondition: _condition(np.logical_and),
    nodes.OrCondition: _condition(np.logical_or),
    nodes.EQ: _condition(np.equal),
    nodes.NE: _condition(np.not_equal),
    nodes.LT: _condition(np.less),
    nodes.GT: _condition(np.greater),
    nodes.LE: _condition(np.less_equal),
    nodes.GE: _condition(np.greater_equal),
    nodes.Sum: _elementwise(np.add),
    nodes.Product: _elementwise(np.multiply),
    nodes.Division: _elementwise(np.divide),
    nodes.Power: _elementwise(np.power),
    nodes.Abs: _elementwise(np.abs),
    nodes.MinValue: _elementwise(np.minimum),
    nodes.MaxValue: _elementwise(np.maximum),
    nodes.Sqrt: _elementwise(np.sqrt),
    nodes.Exp: _elementwise(np.exp),
    nodes.Ln: _elementwise(np.log),
    nodes.Sin: _elementwise(np.sin),
    nodes.Cos: _elementwise(np.cos),
    nodes.Tan: _elementwise(np.tan),
    nodes.Asin: _elementwise(np.arcsin),
    nodes.Acos: _elementwise(np.arccos),
    nodes.Atan: _elementwise(np.arctan),
    nodes.Atan2: _elementwise(np.arctan2),
    nodes.Sinh: _elementwise(np.sinh),
    nodes.Cosh: _elementwise(np.cosh),
    nodes.Tanh: _elementwise(np.tanh),
}
