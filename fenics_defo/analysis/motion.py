"""Say in a word how a mode moves, where a word can be defended.

A slender body has an axis: the principal axis of its mass along which it is longest. Motions of
its plane cross-sections span three spaces of displacement fields, with z along the axis, (x, y)
the distance from the centre of the section, and f, g, h any functions of z:

    bending   (f1, f2, g1 x + g2 y)    the section shifts sideways and tilts
    torsion   (-h y, h x, 0)           it turns about the axis
    axial     (0, 0, h)                it shifts along the axis

A mode is called by the space that holds nearly all of its kinetic energy sum_p m_p |u_p|^2 (its
mass-weighted projection); one that mixes them, distorts its sections, or lives in a body without
a clear axis, is not called anything.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime import Modes

Array = NDArray[np.float64]

SLENDERNESS = 3.0
"""Least ratio of the two largest radii of gyration; length / width for a box."""

RIGID_SHARE = 0.9999
"""Least share of the kinetic energy that makes a motion rigid; a clamped beam reaches 0.98."""

KIND_SHARE = 0.8
"""Least share of the kinetic energy that gives a mode its name."""

DIRECTION_SHARE = 0.95
"""Least share of the sideways kinetic energy along one coordinate axis that names it."""

_MOST_STATIONS = 41
_NODES_PER_INTERVAL = 2.0  # along the axis: fewer, and f, g, h could follow any displacement


def describe_motion(modes: Modes) -> tuple[str, ...]:
    """Name the kind of motion of each mode.

    Args:
        modes: k modes with the lumped masses of their nodes.

    Returns:
        k words: ``"rigid"``, ``"bending"`` (``"bending y"`` when it is along a coordinate axis),
        ``"torsion"``, ``"axial"``, or ``""`` where none of them holds `KIND_SHARE` of the
        kinetic energy or the body is not slender.
    """
    points, shapes, mass = _massive(modes)
    energy = np.einsum("n,knp,knp->k", mass, shapes, shapes)
    is_rigid = _rigid_share(points, shapes, mass, energy) >= RIGID_SHARE
    is_rigid[: modes.rigid_modes] = True
    frame = _slender_frame(points, mass)
    if frame is None:
        return tuple("rigid" if rigid else "" for rigid in is_rigid)
    shares = _shares(frame, shapes, mass, energy)
    best = np.argmax(list(shares.values()), axis=0)
    words = []
    for i, rigid in enumerate(is_rigid):
        kind = list(shares)[best[i]]
        if rigid:
            words.append("rigid")
        elif not shares[kind][i] >= KIND_SHARE:
            words.append("")
        elif kind == "bending":
            words.append(kind + _direction(shapes[i], mass, frame.axes[2]))
        else:
            words.append(kind)
    return tuple(words)


def _massive(modes: Modes) -> tuple[Array, Array, Array]:
    """Return points, shapes and masses of the nodes that have mass: others may lie anywhere."""
    keep = modes.node_mass > 0.0
    if keep.all():
        return modes.points, modes.shapes, modes.node_mass
    return modes.points[keep], modes.shapes[:, keep], modes.node_mass[keep]


@dataclass(frozen=True, slots=True)
class _Frame:
    """Stations along the axis of a slender body.

    Args:
        axes: rows e_x, e_y, e_z, an orthonormal basis with e_z along the body (3, 3).
        local: distance from the centre of the section (n, 2) [m].
        interval: interval of the axis that holds each node (n,).
        hats: values at each node of the two hat functions of its interval (2, n).
        stations: number of hat functions.
    """

    axes: Array
    local: Array
    interval: NDArray[np.int64]
    hats: Array
    stations: int

    def sums(self, values: Array) -> Array:
        """Return sum_p hat_s(p) value_p for each station s."""
        left, right = (np.bincount(self.interval, h * values, self.stations) for h in self.hats)
        return left + np.roll(right, 1)  # the last interval's right end is never beyond the end


def _slender_frame(points: Array, mass: Array) -> _Frame | None:
    """Find the axis of the body, or None where there is no clear one."""
    if not mass.size:
        return None
    offset = points - mass @ points / mass.sum()
    moments, vectors = np.linalg.eigh((offset * mass[:, None]).T @ offset)
    if not moments[2] >= SLENDERNESS**2 * moments[1]:
        return None
    axes = vectors.T
    coordinates = offset @ axes.T
    extent = np.ptp(coordinates, axis=0)
    spacing = np.cbrt(extent.prod() / len(points))
    wanted = extent[2] / max(_NODES_PER_INTERVAL * spacing, extent[2] / (_MOST_STATIONS - 1))
    intervals = max(2, int(wanted))
    position = (coordinates[:, 2] - coordinates[:, 2].min()) / extent[2] * intervals
    interval = np.minimum(position.astype(np.int64), intervals - 1)
    hats = np.stack([1.0 - (position - interval), position - interval])
    # Measured from the axis itself first, then from the centres of the sections: the axis of a
    # slightly curved or lopsided body is the line of those centres.
    straight = _Frame(axes, coordinates[:, :2], interval, hats, intervals + 1)
    centres = _fit(straight, mass, coordinates[:, :2])
    return _Frame(axes, coordinates[:, :2] - centres, interval, hats, intervals + 1)


def _fit(frame: _Frame, mass: Array, values: Array) -> Array:
    """Return the best piecewise linear function of the axis for ``values`` (n, c)."""
    matrix = _hat_products(frame, mass)
    sums = np.stack([frame.sums(mass * column) for column in values.T], axis=1)
    at_stations = np.linalg.pinv(matrix, hermitian=True) @ sums
    i = frame.interval
    return frame.hats[0][:, None] * at_stations[i] + frame.hats[1][:, None] * at_stations[i + 1]


def _hat_products(frame: _Frame, weights: Array) -> Array:
    """Return sum_p w_p hat_s(p) hat_t(p) as a (stations, stations) tridiagonal matrix."""
    left, right = frame.hats
    off = np.bincount(frame.interval, left * right * weights, frame.stations)[:-1]
    diagonal = np.bincount(frame.interval, left**2 * weights, frame.stations)
    diagonal += np.roll(np.bincount(frame.interval, right**2 * weights, frame.stations), 1)
    return np.diag(diagonal) + np.diag(off, 1) + np.diag(off, -1)


def _shares(frame: _Frame, shapes: Array, mass: Array, energy: Array) -> dict[str, Array]:
    """Return the share of the kinetic energy of each kind of motion (k,)."""
    x, y = frame.local.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    fields = {
        "bending": [(one, zero, zero), (zero, one, zero), (zero, zero, x), (zero, zero, y)],
        "torsion": [(-y, x, zero)],
        "axial": [(zero, zero, one)],
    }
    local_shapes = shapes @ frame.axes.T
    explained = {
        kind: _explained(frame, np.array(basis), local_shapes, mass)
        for kind, basis in fields.items()
    }
    return {kind: _ratio(value, energy) for kind, value in explained.items()}


def _explained(frame: _Frame, basis: Array, shapes: Array, mass: Array) -> Array:
    """Return the energy of the projection of ``shapes`` (k, n, 3) on hat_s(z) basis_c (k,).

    With b_sc = sum_p m_p hat_s basis_c . u and N the Gram matrix of these fields: b^T N^-1 b.
    """
    gram = np.block(
        [[_hat_products(frame, mass * (a * b).sum(axis=0)) for b in basis] for a in basis]
    )
    sums = [
        np.concatenate([frame.sums(mass * (a.T * shape).sum(axis=1)) for a in basis])
        for shape in shapes
    ]
    # Scaled to a unit diagonal: shifts [-] and tilts [m] have no common unit for a cut-off.
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    inverse = np.linalg.pinv(gram / np.outer(scale, scale), rcond=1e-10, hermitian=True)
    scaled = np.array(sums) / scale
    return np.einsum("ki,ij,kj->k", scaled, inverse, scaled)


def _rigid_share(points: Array, shapes: Array, mass: Array, energy: Array) -> Array:
    """Return the share of the kinetic energy that the six rigid motions explain (k,)."""
    if not mass.size:
        return np.zeros_like(energy)
    offset = points - mass @ points / mass.sum()
    offset = offset / max(np.abs(offset).max(), np.finfo(float).tiny)
    unit = np.eye(3)
    shifts = np.broadcast_to(unit[:, None, :], (3, *offset.shape))
    turns = np.cross(unit[:, None, :], offset[None])
    motions = np.concatenate([shifts, turns])
    flat = (motions * mass[:, None]).reshape(6, -1)
    gram = flat @ motions.reshape(6, -1).T
    momenta = shapes.reshape(len(shapes), -1) @ flat.T
    inverse = np.linalg.pinv(gram, rcond=1e-10, hermitian=True)
    return _ratio(np.einsum("ki,ij,kj->k", momenta, inverse, momenta), energy)


def _direction(shape: Array, mass: Array, axis: Array) -> str:
    """Return `` x``, `` y`` or `` z`` if the sideways motion is along it, else nothing."""
    sideways = shape - np.outer(shape @ axis, axis)
    energies = mass @ sideways**2
    letter = int(np.argmax(energies))
    return f" {'xyz'[letter]}" if energies[letter] >= DIRECTION_SHARE * energies.sum() else ""


def _ratio(part: Array, whole: Array) -> Array:
    return np.divide(part, whole, out=np.zeros_like(whole), where=whole > 0.0)
