"""The reduced model: all that moves a body in real time, as NumPy arrays."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.errors import FileFormatError, LoadError, SelectionError
from fenics_defo.runtime.floating.frame import FloatingFrame
from fenics_defo.runtime.forces.coordinates import checked
from fenics_defo.runtime.forces.force_law import ForceLaw
from fenics_defo.runtime.frozen import frozen_array, symmetric_array
from fenics_defo.runtime.metadata import plain_mapping
from fenics_defo.runtime.model_file import read_model, write_model
from fenics_defo.runtime.outputs import Outputs, Probe

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_NO_GRAVITY = np.zeros((3, 0))
_NO_OUTPUTS = Outputs(
    nodes=np.zeros(0, dtype=np.int64), points=np.zeros((0, 3)), shapes=np.zeros((0, 3, 0))
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ReducedModel:
    """Motion u = U q of a body by r coordinates: M q'' + C q' + f(q) = load.

    U is stored only at the nodes and probes that were asked for. C = alpha M + beta K(q).

    Args:
        law: internal force f and its derivatives.
        mass: M = U^T M_full U (r, r) [kg for shapes without a unit], positive definite; the
            identity for mass-normalised shapes.
        outputs: U at nodes; none by default.
        gravity_rows: forces on the coordinates by unit accelerations along x, y and z (3, r);
            0 by default.
        damping: alpha [1/s] and beta [s] that integrators take if they are given none.
        probes: name -> U at a point.
        loads: name -> force on the coordinates at the load's full value (r,).
        frame: integrals of mass of a body that flies; None for one that is held.
        provenance: what the model was made of, as plain values.
        certificate: measured errors and ranges, as plain values.

    Raises:
        ValueError: parts whose shapes or values do not fit together.
    """

    law: ForceLaw
    mass: Array
    outputs: Outputs = field(default_factory=lambda: _NO_OUTPUTS)
    gravity_rows: Array = field(default_factory=lambda: _NO_GRAVITY)
    damping: tuple[float, float] = (0.0, 0.0)
    probes: Mapping[str, Probe] = field(default_factory=dict)
    loads: Mapping[str, Array] = field(default_factory=dict)
    frame: FloatingFrame | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    certificate: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        r = self.law.size
        mass = symmetric_array("mass", self.mass)
        if len(mass) != r:
            raise ValueError(f"mass must have the shape {(r, r)}, got {mass.shape}")
        try:
            np.linalg.cholesky(mass)
        except np.linalg.LinAlgError:
            raise ValueError("mass must be positive definite") from None
        set_field = object.__setattr__
        set_field(self, "mass", mass)
        if self.gravity_rows is _NO_GRAVITY:
            set_field(self, "gravity_rows", np.zeros((3, r)))
        if self.outputs is _NO_OUTPUTS:
            nowhere = np.zeros((0, 3, r))
            set_field(self, "outputs", replace(_NO_OUTPUTS, shapes=nowhere))
        set_field(self, "gravity_rows", frozen_array("gravity_rows", self.gravity_rows, (3, r)))
        damping = frozen_array("damping", self.damping, (2,))
        if not (damping >= 0.0).all():
            raise ValueError(f"damping must not be negative, got {tuple(damping.tolist())}")
        set_field(self, "damping", tuple(damping.tolist()))
        set_field(self, "probes", _named("probe", self.probes))
        loads = {n: frozen_array(f"load {n!r}", load, (r,)) for n, load in self.loads.items()}
        set_field(self, "loads", _named("load", loads))
        set_field(self, "provenance", plain_mapping("provenance", self.provenance))
        set_field(self, "certificate", plain_mapping("certificate", self.certificate))
        self._check_sizes(r)

    def _check_sizes(self, r: int) -> None:
        parts = {"outputs": self.outputs.size}
        parts |= {f"probe {name!r}": probe.shapes.shape[1] for name, probe in self.probes.items()}
        if self.frame is not None:
            parts["frame"] = self.frame.size
        for name, size in parts.items():
            if size != r:
                raise ValueError(f"{name} has {size} coordinates, the force law has {r}")

    def __repr__(self) -> str:
        flies = "" if self.frame is None else ", flies"
        return (
            f"ReducedModel({self.law.kind} force of {self.size} coordinates, "
            f"{self.nodes.size} nodes, probes {list(self.probes)}, loads {list(self.loads)}{flies})"
        )

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return self.law.size

    @property
    def nodes(self) -> IntArray:
        """Stored nodes (p,), zero-based in the order of the body's file."""
        return self.outputs.nodes

    @property
    def points(self) -> Array:
        """Stored nodes at rest (p, 3) [m]."""
        return self.outputs.points

    @property
    def shapes(self) -> Array:
        """Displacements of the stored nodes by each coordinate (p, 3, r)."""
        return self.outputs.shapes

    @property
    def frequencies(self) -> Array:
        """Frequencies of K(0) and M (r,) [Hz], ascending; 0 where the rest state is not stable."""
        factor = np.linalg.cholesky(self.mass)
        half = np.linalg.solve(factor, self.law.stiffness(np.zeros(self.size)))
        squares = np.linalg.eigvalsh(np.linalg.solve(factor, half.T))
        return np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)

    def force(self, q: ArrayLike) -> Array:
        """Return the internal force f (..., r) at ``q`` (..., r).

        Raises:
            ValueError: another number of coordinates, or values that are not finite.
        """
        return self.law.force(np.asarray(q, dtype=np.float64))

    def stiffness(self, q: ArrayLike) -> Array:
        """Return the tangent K = df/dq (..., r, r) at ``q`` (..., r).

        Raises:
            ValueError: as `force`.
        """
        return self.law.stiffness(np.asarray(q, dtype=np.float64))

    def energy(self, q: ArrayLike) -> Array:
        """Return the strain energy (...) [J] at ``q`` (..., r).

        Raises:
            ValueError: as `force`.
        """
        return self.law.energy(np.asarray(q, dtype=np.float64))

    def displacement(self, q: ArrayLike) -> Array:
        """Return the displacements of the stored nodes (..., p, 3) [m] at ``q`` (..., r).

        Raises:
            ValueError: as `force`.
        """
        return self.outputs.displacement(q)

    def probe(self, name: str, q: ArrayLike) -> Array:
        """Return the displacement (..., 3) [m] of a probe at ``q`` (..., r).

        Raises:
            SelectionError: the model has no such probe.
            ValueError: as `force`.
        """
        if name not in self.probes:
            raise SelectionError(_unknown("probe", name, self.probes))
        return np.asarray(checked(q, self.size) @ self.probes[name].shapes.T)

    def gravity(self, vector: ArrayLike) -> Array:
        """Return the force on the coordinates (..., r) by accelerations (..., 3) [m/s²].

        Raises:
            LoadError: ``vector`` is not three finite numbers.
        """
        return np.asarray(_vector("an acceleration", vector) @ self.gravity_rows)

    def point_load(self, node: int, vector: ArrayLike) -> Array:
        """Return the force on the coordinates (..., r) by forces (..., 3) [N] on a node.

        Args:
            node: zero-based, in the order of the body's file; one of `nodes`.
            vector: force.

        Raises:
            LoadError: the node is not stored, or ``vector`` is not three finite numbers.
        """
        return np.asarray(_vector("a force", vector) @ self.shapes[self.outputs.row(node)])

    def load(self, name: str) -> Array:
        """Return the force on the coordinates (r,) by a named load at its full value, read-only.

        Raises:
            LoadError: the model has no such load.
        """
        if name not in self.loads:
            raise LoadError(_unknown("load", name, self.loads))
        return self.loads[name]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model to ``path``, all or nothing, as an ``.npz`` that ``np.load`` opens.

        The same model gives the same bytes.

        Raises:
            DefoError: the file cannot be written, or the force law cannot be stored.
        """
        write_model(path, {part.name: getattr(self, part.name) for part in fields(self)})


def load_model(path: str | os.PathLike[str]) -> ReducedModel:
    """Read a model that `ReducedModel.save` wrote; needs NumPy only and executes nothing of it.

    Raises:
        FileFormatError: the file is missing, damaged, from a newer version, or not of a model.
    """
    parts = read_model(path)
    try:
        return ReducedModel(**parts)
    except ValueError as error:
        raise FileFormatError(f"{path}: is inconsistent: {error}.") from error


def _named[T](what: str, values: Mapping[str, T]) -> Mapping[str, T]:
    """Return a read-only copy, if each name can be printed."""
    for name in values:
        if not (isinstance(name, str) and name and name.isprintable()):
            raise ValueError(f"the name of a {what} must be a printable text, got {name!r}")
    return MappingProxyType(dict(values))


def _unknown(what: str, name: str, known: Mapping[str, Any]) -> str:
    names = ", ".join(repr(each) for each in known) or "none at all"
    return (
        f"this model has no {what} {name!r}, it has {names}; name one of these, or ask for it "
        "when the body is reduced."
    )


def _vector(what: str, vector: ArrayLike) -> Array:
    """Return vectors (..., 3).

    Raises:
        LoadError: other shapes, or numbers that are not finite.
    """
    try:
        found = np.asarray(vector, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.shape[-1:] != (3,) or not np.isfinite(found).all():
        raise LoadError(f"{what} is three finite numbers (..., 3), got {vector!r}.")
    return found
