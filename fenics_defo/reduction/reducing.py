"""From a body and a basis to a model that runs without FEniCSx."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fenics_defo.analysis import Load
from fenics_defo.analysis.loads import checked_vector
from fenics_defo.analysis.point_location import locate_point
from fenics_defo.errors import DefoError, SelectionError
from fenics_defo.fem import Solid
from fenics_defo.fem.projection import Projection
from fenics_defo.fem.regions import select_nodes
from fenics_defo.reduction.basis import Basis
from fenics_defo.reduction.body_fields import checked_fields
from fenics_defo.reduction.cubature.training import CubatureTraining, train_cubature
from fenics_defo.reduction.direct_force import DirectForce
from fenics_defo.reduction.floating_frame import inertia_integrals
from fenics_defo.reduction.force_range import measure_error, measure_range
from fenics_defo.reduction.load_projection import (
    MassKind,
    gravity_rows,
    mass_of,
    projected_loads,
    reduced_mass,
)
from fenics_defo.reduction.origin import provenance
from fenics_defo.reduction.tabulation import tabulate_cubic, tabulate_linear, taylor_force
from fenics_defo.runtime import FloatingFrame, ForceLaw, Outputs, Probe, ReducedModel

Array = NDArray[np.float64]

type ForceKind = Literal["linear", "cubic", "taylor", "direct", "cubature"]
_FORCES = get_args(ForceKind.__value__)
# Departure of the basis's mass from the body's, relative to its largest entry.
_SAME_MASS = 1e-8


def reduce(
    solid: Solid,
    basis: Basis,
    force: ForceKind = "cubic",
    *,
    outputs: str | int | ArrayLike | None = None,
    loads: Sequence[Load] | Mapping[str, Load] = (),
    probes: Mapping[str, ArrayLike] | None = None,
    damping: tuple[float, float] = (0.0, 0.0),
    mass: MassKind = "consistent",
    floating: bool | None = None,
    range_tolerance: float | None = 0.01,
    training: CubatureTraining | None = None,
) -> ReducedModel:
    """Project a body onto a basis: M q'' + C q' + f(q) = Uᵀ g.

    Collective; the same model on each rank.

    Args:
        solid: body.
        basis: its coordinates.
        force: "linear", f = Uᵀ K(0) U q; "cubic", exact for st-venant-kirchhoff and linear laws;
            "taylor", the third-order expansion about rest of any UFL energy; "cubature", any law
            but springs, summed over few points; "direct", Uᵀ f(U q) assembled at each call, which
            cannot be stored.
        outputs: nodes whose displacement is wanted: a selection, or their numbers from 0; all if
            not given.
        loads: their projections are kept by name, see `projected_loads`; gravity is always there.
        probes: points [m] at rest by name.
        damping: Rayleigh's (alpha [1/s], beta [s]).
        mass: "consistent", or "lumped" as the full simulation's explicit integrators have it.
        floating: keep the inertia integrals of a body that flies; by default where nothing holds
            it and no combination of the shapes is a rigid motion.
        range_tolerance: error of the force that is accepted in measuring how far "linear" and
            "taylor" may be trusted, see `measure_range`; None to leave out that measurement, and
            that of the round-off of exact laws.
        training: what `train_cubature` returned for this body and these shapes; for "cubature" with
            options of your own.

    Returns:
        the model, with its provenance and, in its certificate, what is known of its force.

    Raises:
        DefoError: a basis of another body, or an unknown force or mass.
        MaterialError: the force cannot represent one of the body's laws.
        LoadError, SelectionError: loads, probes or outputs that the body does not have.
    """
    check_force(force)
    shapes = _checked_shapes(solid, basis)
    projection, inertia = Projection(solid, shapes), mass_of(solid, mass)
    lumped = reduced_mass(solid, projection, inertia) if mass == "lumped" else None
    matrix = np.eye(basis.size) if basis.is_orthonormal else basis.mass
    if force == "cubature" and training is None:
        training = train_cubature(solid, shapes)
    law = _law(solid, shapes, force, training)
    return ReducedModel(
        law=law,
        mass=matrix if lumped is None else lumped,
        outputs=_outputs(solid, shapes, outputs),
        gravity_rows=gravity_rows(solid, projection, inertia),
        damping=damping,
        probes=_probes(solid, shapes, probes or {}),
        loads=projected_loads(solid, projection, inertia, loads),
        frame=_frame(solid, shapes, floating),
        provenance=provenance(solid, basis, force, mass),
        certificate=_certificate(solid, shapes, law, range_tolerance, training),
    )


def check_force(force: str) -> None:
    """Check the name of a force law.

    Raises:
        DefoError: it is unknown.
    """
    if force not in _FORCES:
        names = ", ".join(repr(name) for name in _FORCES)
        raise DefoError(f"force must be one of {names}, got {force!r}")


def _checked_shapes(solid: Solid, basis: Basis) -> Array:
    if not isinstance(basis, Basis):
        raise DefoError(
            "basis must be what linear_basis, modal_derivative_basis, snapshot_basis, join or "
            f"basis_from_array returned, got {type(basis).__name__}; for an array of shapes "
            "(r, n, 3) use basis_from_array(solid, shapes)"
        )
    shapes = checked_fields(solid, basis.shapes, "the shapes of the basis")
    mass = reduced_mass(solid, Projection(solid, shapes), mass_of(solid, "consistent"))
    apart = float(np.abs(mass - basis.mass).max() / np.abs(mass).max())
    if not apart <= _SAME_MASS:
        raise DefoError(
            f"the mass of this body within the basis departs by {apart:.2g} (relative) from the "
            "basis's own: it was made of another body; make one of this body"
        )
    return shapes


def _law(
    solid: Solid, shapes: Array, force: ForceKind, training: CubatureTraining | None
) -> ForceLaw:
    if (training is not None) != (force == "cubature"):
        raise DefoError(
            f'a training is for the force "cubature", and {force!r} was asked for; leave it out'
        )
    if training is not None:
        if training.force.size != len(shapes):
            raise DefoError(
                f"the training is for {training.force.size} coordinates, and the basis has "
                f"{len(shapes)}; train for the shapes of this basis"
            )
        return training.force
    match force:
        case "linear":
            return tabulate_linear(solid, shapes)
        case "cubic":
            return tabulate_cubic(solid, shapes)
        case "taylor":
            return taylor_force(solid, shapes)
        case _:
            return DirectForce(solid, shapes)


def _outputs(solid: Solid, shapes: Array, wanted: str | int | ArrayLike | None) -> Outputs:
    n = solid.nodes.size
    if wanted is None:
        nodes = np.arange(n)
    elif isinstance(wanted, str | int) and not isinstance(wanted, bool):
        nodes = np.flatnonzero(select_nodes(solid.mesh_data, solid.space, solid.nodes, wanted))
    else:
        nodes = _numbered(wanted, n)
    everything = len(nodes) == n
    return Outputs(
        nodes=nodes.astype(np.int64),
        points=solid.points[nodes],
        shapes=np.ascontiguousarray(shapes[:, nodes].transpose(1, 2, 0)),
        cells=solid.cells if everything else np.zeros((0, 0), np.int64),
        cell_type=solid.nodes.cell_type if everything else "",
    )


def _numbered(wanted: ArrayLike, n: int) -> NDArray[np.int64]:
    given = np.asarray(wanted)
    if given.ndim != 1 or (given.size and given.dtype.kind not in "iu"):
        raise SelectionError(
            "outputs must be a selection such as 'x>0.5', or node numbers from 0 (p,), "
            f"got {wanted!r}"
        )
    nodes = np.unique(given).astype(np.int64)
    if nodes.size and not (nodes[0] >= 0 and nodes[-1] < n):
        raise SelectionError(
            f"outputs must be nodes from 0 to {n - 1}, got {nodes[0]} to {nodes[-1]}"
        )
    return nodes


def _probes(solid: Solid, shapes: Array, points: Mapping[str, ArrayLike]) -> dict[str, Probe]:
    found = {}
    for name, given in points.items():
        what = f"probe {name!r}"
        point = np.asarray(checked_vector(what, given, "point"), dtype=np.float64)
        place = locate_point(solid, point, what=what)
        rows = np.einsum("c,rci->ir", place.weights, shapes[:, place.rows])
        found[name] = Probe(point=point, shapes=rows)
    return found


def _frame(solid: Solid, shapes: Array, floating: bool | None) -> FloatingFrame | None:
    if floating is False or (floating is None and solid.held.any()):
        return None
    try:
        return inertia_integrals(solid, shapes)
    except DefoError:
        if floating:
            raise
        return None  # the shapes hold rigid motions: the coordinates move the body themselves


def _certificate(
    solid: Solid,
    shapes: Array,
    law: ForceLaw,
    tolerance: float | None,
    training: CubatureTraining | None,
) -> dict[str, Any]:
    """What is known of the force within the basis, against `DirectForce`."""
    if training is not None:
        return {"force": {"kind": law.kind, "exact": False} | training.certificate()}
    exact = law.kind in ("cubic", "direct") or (law.kind == "linear" and solid.is_linear)
    told: dict[str, Any] = {"kind": law.kind, "exact": exact}
    if tolerance is not None and law.kind != "direct":
        if exact:
            told["measured_error"] = measure_error(solid, law, shapes)
        else:
            told |= measure_range(solid, law, shapes, tolerance=tolerance).certificate()
    return {"force": told}
