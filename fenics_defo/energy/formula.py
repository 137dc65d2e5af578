"""Whether two materials have the same energy function, whatever their constants are."""

from collections.abc import Hashable
from functools import cache

import ufl
from ufl.algorithms.signature import compute_expression_signature
from ufl.core.expr import Expr

from fenics_defo.energy.material import Material

_GRADIENT = ufl.variable(ufl.Identity(3))


def formula(material: Material) -> Hashable:
    """What two materials share when they have the same energy function: the function's formula.

    Their class is not enough: a user's own may keep a direction, say, outside of `parameters`.

    Raises:
        MaterialError: the energy is no scalar.
    """
    symbols = {name: _symbol(name) for name in material.parameters}
    energy = ufl.as_ufl(material.strain_energy(_GRADIENT, symbols))
    return tuple(symbols), compute_expression_signature(energy, _Names())


class _Names(dict[object, str]):
    """Names by which UFL's signature calls variables and functions: those of the very objects."""

    def __missing__(self, key: object) -> str:
        return repr(key)


@cache
def _symbol(name: str) -> Expr:
    """The same symbol each time for a parameter of that name; its number is never used."""
    return ufl.variable(ufl.as_ufl(1.0))
