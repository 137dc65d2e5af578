"""The displacements that a reduced body can have: the span of a few fields."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError

Array = NDArray[np.float64]

type Plain = str | int | float | bool | tuple["Plain", ...] | None
"""What the origin of a basis is told in: values that JSON can hold."""

_ASYMMETRY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Basis:
    """Fields U_i that span the displacements u = Σ q_i U_i of a reduced body.

    Nodes are in the order of the user's file. The arrays are kept as read-only views, not copied.

    Args:
        shapes: U (r, n, 3), zero at held components; [kg^-1/2] if they are mass-orthonormal.
        mass: reduced mass Uᵀ M U (r, r), M the consistent mass; 1 if they are mass-orthonormal.
        kind: how it was made: "linear", "modal-derivatives", "snapshots", "joined" or "given".
        singular_values: of all candidates (s,), s ≥ r, descending, in the unit of √(uᵀ M u); None
            where nothing was chosen by them.
        kept: Σ of the squares of the first r of them over that of all [-]; None without them.
        origin: what else a reader of the model may want to know of it, in plain values.

    Raises:
        DefoError: arrays whose shapes or values do not fit together.
    """

    shapes: Array
    mass: Array
    kind: str
    singular_values: Array | None = None
    kept: float | None = None
    origin: Mapping[str, Plain] = field(default_factory=dict)

    def __post_init__(self) -> None:
        shape = np.shape(self.shapes)
        if len(shape) != 3 or shape[2] != 3 or 0 in shape:
            raise DefoError(
                f"the shapes of a basis must be (r, n, 3), with r from 1, got {shape}; give one "
                "displacement field of all n nodes for each of its r columns"
            )
        self._freeze("shapes", shape)
        self._freeze("mass", (shape[0], shape[0]))
        size = float(np.abs(self.mass).max())
        if not np.abs(self.mass - self.mass.T).max() <= _ASYMMETRY * size:
            raise DefoError("the mass of a basis must be symmetric: it is Uᵀ M U")
        if self.singular_values is not None:
            self._freeze("singular_values", (len(self.singular_values),))
        object.__setattr__(self, "origin", MappingProxyType(dict(self.origin)))

    def _freeze(self, name: str, shape: tuple[int, ...]) -> None:
        """Keep a read-only contiguous view of an array, if its shape and values allow."""
        array = np.ascontiguousarray(getattr(self, name), np.float64).view()
        if array.shape != shape or not np.isfinite(array).all():
            raise DefoError(
                f"{name} of a basis must be finite and of the shape {shape}, got {array.shape}"
            )
        array.flags.writeable = False
        object.__setattr__(self, name, array)

    @property
    def size(self) -> int:
        """Number r of fields."""
        return len(self.shapes)

    @property
    def is_orthonormal(self) -> bool:
        """Whether the reduced mass is 1 but for round-off (1e-12)."""
        return bool(np.abs(self.mass - np.eye(self.size)).max() <= 1e-12)
