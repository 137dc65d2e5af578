"""A material law as data: what a model file keeps of it, and the kernel that it becomes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.laws.corotational import corotational
from fenics_defo.runtime.laws.general import GeneralKernel
from fenics_defo.runtime.laws.invertible import invertible
from fenics_defo.runtime.laws.isotropic import IsotropicKernel
from fenics_defo.runtime.laws.kernel import PointKernel
from fenics_defo.runtime.laws.response import PointResponse
from fenics_defo.runtime.laws.responses import ResponseKernel
from fenics_defo.runtime.laws.stretches import of_stretches
from fenics_defo.runtime.operations import OperationList, evaluate

type Array = NDArray[np.float64]

#: What the list of operations of each kind gives: outputs and inputs before the parameters.
_LISTS = {"isotropic": (10, 3), "invertible": (10, 3), "general": (55, 9)}
_TANGENTS = {
    "isotropic": ("exact",),
    "general": ("exact",),
    "invertible": ("exact", "definite"),
    "corotational": ("exact", "definite", "approximate"),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MaterialLaw:
    """A material law that runs where UFL is not installed.

    Args:
        kind: "isotropic", an energy of the invariants; "general", one of F; "corotational"; or
            "invertible", an isotropic energy continued through inversion.
        names: its parameters, in the order in which a kernel takes them.
        listing: the operations of `IsotropicKernel` or `GeneralKernel`; None for "corotational",
            whose parameters are "mu" and "lmbda".
        tangent: "exact", "definite" or "approximate", as far as the kind knows it.
        threshold: principal stretch below which an invertible law is continued, 0 for others.

    Raises:
        FileFormatError: they do not fit together.
    """

    kind: str
    names: tuple[str, ...]
    listing: OperationList | None = None
    tangent: str = "exact"
    threshold: float = 0.0

    #: What `from_arrays` needs in an archive.
    SPECS = {
        "kind": ArraySpec("U", 0),
        "names": ArraySpec("U", 1),
        "tangent": ArraySpec("U", 0),
        "threshold": ArraySpec("f", 0),
    } | OperationList.SPECS

    def __post_init__(self) -> None:
        if self.tangent not in _TANGENTS.get(self.kind, ()):
            raise FileFormatError(
                f"a law of kind {self.kind!r} with the tangent {self.tangent!r} is not known; the "
                "file was made by a newer version, or is damaged"
            )
        if (self.kind == "invertible") != (0.0 < self.threshold < 1.0):
            raise FileFormatError(f"the threshold {self.threshold} does not go with {self.kind!r}")
        expected = _LISTS.get(self.kind)
        if expected is None:
            fits = self.listing is None and self.names == ("mu", "lmbda")
        else:
            outputs, variables = expected
            fits = self.listing is not None and (
                self.listing.outputs.size == outputs
                and self.listing.inputs == variables + len(self.names)
            )
        if not fits:
            raise FileFormatError(f"a law of kind {self.kind!r} lacks what it is made of")

    def kernel(self, parameters: Sequence[Array | float], count: int) -> PointKernel:
        """The law at ``count`` points.

        Args:
            parameters: (count,) or a number for each of ``names``.
            count: number of points.
        """
        if self.kind == "corotational":
            mu, lmbda = parameters
            return ResponseKernel(partial(_corotational, mu, lmbda, self.tangent), count)
        assert self.listing is not None  # checked when the law was made
        if self.kind == "isotropic":
            return IsotropicKernel(self.listing, parameters, count)
        if self.kind == "general":
            return GeneralKernel(self.listing, parameters, count)
        derivatives = partial(_stretched, self.listing)
        definite = self.tangent == "definite"
        answer = partial(_invertible, derivatives, tuple(parameters), self.threshold, definite)
        return ResponseKernel(answer, count)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The law as arrays, by the names of `SPECS`."""
        listing = self.listing or _EMPTY
        return {
            "kind": np.array(self.kind),
            "names": np.array(self.names, dtype=str),
            "tangent": np.array(self.tangent),
            "threshold": np.array(self.threshold),
        } | listing.arrays()

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The law of `arrays`.

        Raises:
            FileFormatError: see the class and `OperationList`.
        """
        kind = str(arrays["kind"])
        return cls(
            kind=kind,
            names=tuple(str(name) for name in arrays["names"]),
            listing=OperationList.from_arrays(arrays) if kind in _LISTS else None,
            tangent=str(arrays["tangent"]),
            threshold=float(arrays["threshold"]),
        )


#: In the place of a list that a law does without.
_EMPTY = OperationList(
    inputs=1,
    constants=np.zeros(0),
    codes=np.zeros(0, np.int64),
    operands=np.zeros((0, 3), np.int64),
    outputs=np.zeros(1, np.int64),
)


def _corotational(
    mu: Array | float, lmbda: Array | float, kind: Any, F: Array, tangent: bool, out: PointResponse
) -> None:
    corotational(F, mu, lmbda, tangent=kind if tangent else None, out=out)


def _invertible(
    derivatives: Any,
    parameters: tuple[Array | float, ...],
    threshold: float,
    definite: bool,
    F: Array,
    tangent: bool,
    out: PointResponse,
) -> None:
    invertible(
        F,
        derivatives,
        parameters,
        threshold=threshold,
        tangent=tangent,
        definite=definite,
        out=out,
    )


def _stretched(
    listing: OperationList, stretches: Array, *parameters: Array | float
) -> tuple[Array, Array, Array]:
    """Derivatives in the principal stretches, as `invertible` takes them."""
    with np.errstate(all="ignore"):  # what is not finite shows in the result
        return of_stretches(
            lambda *invariants: evaluate(listing, [*invariants, *parameters]), stretches
        )
