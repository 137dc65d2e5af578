"""Energies of UFL as lists of scalar operations, which run where UFL is not installed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from numpy.typing import NDArray
from ufl import classes as nodes
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering
from ufl.algorithms.apply_derivatives import apply_derivatives
from ufl.core.expr import Expr

from fenics_defo.energy.evaluation import node_children, node_key, node_rule
from fenics_defo.energy.material import IsotropicMaterial, Material
from fenics_defo.energy.tape import Number, Scalar, Tape
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.operations import OperationList
from fenics_defo.runtime.operations.listing import LONGEST

type Symbols = NDArray[np.object_]

#: Pairs i <= j of a symmetric matrix, row by row.
type Pairs = tuple[tuple[int, int], ...]


def upper_pairs(size: int) -> Pairs:
    """Entries on and above the diagonal of a (size, size) matrix, row by row."""
    return tuple((i, j) for i in range(size) for j in range(i, size))


@dataclass(frozen=True, slots=True)
class LoweredEnergy:
    """An energy of some variables, with its first and second derivatives, as operations.

    Args:
        variables: number of variables v: the first inputs.
        names: the law's parameters: the inputs after them.
        listing: outputs are the energy, its v first derivatives, and its v (v + 1) / 2 second
            derivatives, on and above the diagonal row by row.
    """

    variables: int
    names: tuple[str, ...]
    listing: OperationList


def lower_isotropic(material: IsotropicMaterial) -> LoweredEnergy:
    """ψ(I1, I2, J) and its derivatives as operations, the law's parameters left open.

    Raises:
        MaterialError: the energy holds what has no value at one point, or is too long.
    """
    I1, I2, J = variables = [_variable(()) for _ in range(3)]
    symbols = {name: _variable(()) for name in material.parameters}
    energy = ufl.as_ufl(material.invariant_energy(I1, I2, J, symbols))
    return _lowered(energy, variables, symbols)


def lower_general(material: Material) -> LoweredEnergy:
    """ψ(F) and its derivatives as operations of the nine entries of F, row by row.

    Raises:
        MaterialError: the energy holds what has no value at one point, or is too long.
    """
    F = _variable((3, 3))
    symbols = {name: _variable(()) for name in material.parameters}
    return _lowered(ufl.as_ufl(material.strain_energy(F, symbols)), [F], symbols)


def _variable(shape: tuple[int, ...]) -> Expr:
    return ufl.variable(ufl.zero(shape) if shape else ufl.as_ufl(1.0))


def _lowered(energy: Expr, variables: Sequence[Expr], symbols: Mapping[str, Expr]) -> LoweredEnergy:
    count = sum(int(np.prod(v.ufl_shape)) for v in variables)
    tape = Tape(count + len(symbols))
    given = iter(tape.inputs)
    known: dict[Expr, Symbols] = {}
    for symbol in [*variables, *symbols.values()]:
        entries = np.empty((1, *symbol.ufl_shape), dtype=object)
        for index in np.ndindex(entries.shape):
            entries[index] = next(given)
        known[node_key(symbol)] = entries
    value = _write(energy, known)
    inputs = tape.inputs[:count]
    first = tape.gradient(value, inputs)
    second: list[Number] = []
    for i in range(count):
        second += tape.gradient(first[i], inputs[i:])
    listing = tape.listing([value, *first, *second])
    return LoweredEnergy(count, tuple(symbols), listing)


def _write(energy: Expr, known: dict[Expr, Symbols]) -> Number:
    """Write the energy's operations on the tape of the symbols it is given."""
    root = apply_derivatives(apply_algebra_lowering(energy))
    if root.ufl_shape or root.ufl_free_indices:
        raise MaterialError(f"the energy must be a scalar, got the shape {root.ufl_shape}")
    stack = [root]
    while stack:
        node = stack[-1]
        children = node_children(node)
        if node_key(node) in known:
            stack.pop()
        elif waiting := [child for child in children if node_key(child) not in known]:
            stack.extend(waiting)
        else:
            operands = [known[node_key(child)] for child in children]
            known[node_key(node)] = np.asarray(node_rule(node, _WRITTEN)(operands), object)
        if len(known) > LONGEST:
            raise MaterialError(
                f"the energy has more than {LONGEST} parts; write it with fewer operations"
            )
    value: Number = known[node_key(root)].reshape(-1)[0]
    return value


def _by_name(name: str, arity: int) -> Callable[..., Any]:
    def write(*operands: Number) -> Number:
        for operand in operands:
            if isinstance(operand, Scalar):
                return operand.tape.apply(name, *operands)
        return Tape(0).apply(name, *operands)  # of numbers alone: a number

    return np.frompyfunc(write, arity, 1)


def _conditional(condition: Symbols, yes: Symbols, no: Symbols) -> Symbols:
    where = _by_name("where", 3)
    result: Symbols = where(condition.reshape(-1, *[1] * (yes.ndim - 1)), yes, no)
    return result


_WRITTEN: dict[type[Expr], Callable[..., Any]] = {
    node: _by_name(name, arity)
    for node, name, arity in (
        (nodes.Sum, "add", 2),
        (nodes.Product, "multiply", 2),
        (nodes.Division, "divide", 2),
        (nodes.Power, "power", 2),
        (nodes.Abs, "absolute", 1),
        (nodes.MinValue, "minimum", 2),
        (nodes.MaxValue, "maximum", 2),
        (nodes.Sqrt, "sqrt", 1),
        (nodes.Exp, "exp", 1),
        (nodes.Ln, "log", 1),
        (nodes.Sin, "sin", 1),
        (nodes.Cos, "cos", 1),
        (nodes.Tan, "tan", 1),
        (nodes.Asin, "arcsin", 1),
        (nodes.Acos, "arccos", 1),
        (nodes.Atan, "arctan", 1),
        (nodes.Atan2, "arctan2", 2),
        (nodes.Sinh, "sinh", 1),
        (nodes.Cosh, "cosh", 1),
        (nodes.Tanh, "tanh", 1),
        (nodes.LT, "less", 2),
        (nodes.LE, "less_equal", 2),
        (nodes.GT, "greater", 2),
        (nodes.GE, "greater_equal", 2),
        (nodes.EQ, "equal", 2),
        (nodes.NE, "not_equal", 2),
        (nodes.AndCondition, "logical_and", 2),
        (nodes.OrCondition, "logical_or", 2),
        (nodes.NotCondition, "logical_not", 1),
    )
} | {nodes.Conditional: _conditional}
