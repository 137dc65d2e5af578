"""UFL's traversals, kept from holding on to every form they have ever seen.

Python 3.13.0 and 3.13.1 remember, for each ``functools.singledispatchmethod``, the objects that it
was called on, by a closure that refers to the object itself: none is ever freed (CPython's issue
127750). UFL's traversals hold the functions, meshes and MPI communicators of what they traversed,
of which MPICH has 2048: a process that makes some hundreds of bodies would end. What was remembered
saves nothing worth having.
"""

import functools
from collections.abc import Iterator

import ufl.algorithms.apply_derivatives  # noqa: F401 -- its traversals are subclasses below
from ufl.corealg.dag_traverser import DAGTraverser


def forget_traversals() -> None:
    """Have no traversal remember what it was called on, from now on."""
    for kind in _kinds(DAGTraverser):
        for method in vars(kind).values():
            if isinstance(method, functools.singledispatchmethod) and hasattr(
                method, "_method_cache"
            ):
                method._method_cache = None


def _kinds(kind: type) -> Iterator[type]:
    yield kind
    children: list[type] = kind.__subclasses__()
    for child in children:
        yield from _kinds(child)
