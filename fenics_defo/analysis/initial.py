"""How a body starts to move."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import LoadError
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Initial:
    """Displacement and velocity at time zero.

    Args:
        displacement: (n, 3) [m], or three numbers for all nodes; rest if not given.
        velocity: (n, 3) [m/s], or three numbers for all nodes; rest if not given.

    Raises:
        LoadError: another shape, or not finite.
    """

    displacement: ArrayLike | None = None
    velocity: ArrayLike | None = None

    def __post_init__(self) -> None:
        for name in ("displacement", "velocity"):
            given = getattr(self, name)
            if given is not None:
                object.__setattr__(self, name, _checked(name, given))

    def fields(self, nodes: int) -> tuple[Array, Array]:
        """Displacement (nodes, 3) [m] and velocity (nodes, 3) [m/s].

        Raises:
            LoadError: they were given for another number of nodes.
        """
        found = []
        for name in ("displacement", "velocity"):
            given = getattr(self, name)
            values = np.zeros(3) if given is None else np.asarray(given)
            if values.shape not in ((3,), (nodes, 3)):
                raise LoadError(
                    f"the initial {name} of this body has the shape ({nodes}, 3) or (3,), "
                    f"got {values.shape}"
                )
            found.append(np.array(np.broadcast_to(values, (nodes, 3))))
        return found[0], found[1]


def mode_displacement(modes: Modes, number: int, amplitude: float) -> Array:
    """A vibration mode as an initial displacement.

    Args:
        modes: modes of the same body.
        number: 1 for the first of them.
        amplitude: largest displacement of a node [m]; negative turns the shape round.

    Returns:
        (n, 3) [m].

    Raises:
        LoadError: there is no such mode, or ``amplitude`` is not finite.
    """
    if isinstance(number, bool) or not isinstance(number, int | np.integer):
        raise LoadError(f"the number of a mode must be a whole number from 1, got {number!r}")
    if not 1 <= number <= modes.size:
        raise LoadError(f"the number of a mode must be from 1 to {modes.size}, got {number}")
    if not np.isfinite(amplitude):
        raise LoadError(f"the amplitude of a mode must be finite [m], got {amplitude!r}")
    shape = modes.shapes[number - 1]
    return np.asarray(shape * (amplitude / np.linalg.norm(shape, axis=1).max()))


def _checked(name: str, given: ArrayLike) -> Array:
    try:
        values = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if not (values.ndim in (1, 2) and values.shape[-1] == 3 and np.isfinite(values).all()):
        raise LoadError(
            f"the initial {name} must be finite numbers of the shape (n, 3) or (3,), "
            f"got an array of the shape {np.shape(given)}"
        )
    values.setflags(write=False)
    return values
