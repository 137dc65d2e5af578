"""Bases are mass-orthonormal and hold what they were made from, as far as they say."""

import json
import logging

import numpy as np
import pytest
from bent_bodies import SOFT, STVK, beam, beam_arrays, elastic, rigid, spans, usual
from scipy import linalg

from fenics_defo.analysis import Gravity, State, linear_modes, static_equilibrium
from fenics_defo.analysis.spectrum import signs
from fenics_defo.energy import LinearElastic, StVenantKirchhoff
from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.fem import Solid, build_mesh
from fenics_defo.reduction import (
    Basis,
    basis_from_array,
    join,
    linear_basis,
    modal_derivative_basis,
    modal_derivatives,
    snapshot_basis,
)
from fenics_defo.runtime.recording import FrameMesh, FrameSeries


def gram(solid, shapes):
    flat = shapes.reshape(len(shapes), -1)
    return flat @ (solid.mass() @ flat.T)


def weighted(modes, derivatives, amplitude=1.0):
    """The candidates of a modal-derivative basis, (s, n, 3)."""
    values = modes.omega[modes.rigid_modes :] ** 2
    ratio = values[0] / values
    i, j = np.triu_indices(len(ratio))
    second = amplitude * (ratio[i] * ratio[j])[:, None, None] * derivatives
    return np.concatenate([ratio[:, None, None] * elastic(modes), second])


def singular(solid, fields):
    """Singular values by a dense Cholesky factor of M."""
    lower = linalg.cholesky(solid.mass().toarray(), lower=True)
    return linalg.svdvals(lower.T @ fields.reshape(len(fields), -1).T)


def check_record(solid, basis, kind):
    assert basis.kind == kind
    assert np.abs(basis.mass - np.eye(basis.size)).max() < 1e-12
    assert basis.is_orthonormal
    assert np.abs(gram(solid, basis.shapes) - basis.mass).max() < 1e-12
    assert (basis.shapes[:, solid.held] == 0.0).all()
    assert (signs(basis.shapes) == 1.0).all()
    json.dumps(dict(basis.origin))  # fit for a model's file


@pytest.mark.parametrize("held", [True, False])
def test_linear(held):
    solid, modes = usual(held=held)
    basis = linear_basis(solid, modes, 3)
    check_record(solid, basis, "linear")
    assert basis.shapes == pytest.approx(elastic(modes)[:3], abs=1e-7 * np.abs(modes.shapes).max())
    assert linear_basis(solid, modes).size == 4
    assert basis.singular_values is None
    assert basis.kept is None


@pytest.mark.parametrize("held", [True, False])
def test_components_of_modes_and_derivatives(held):
    solid, modes = usual(held=held)
    derivatives = modal_derivatives(solid, modes)
    basis = modal_derivative_basis(solid, modes, 6)
    check_record(solid, basis, "modal-derivatives")
    assert basis.origin["modes"] == 4
    assert basis.origin["derivatives"] == 10
    # At the weights' bend the first mode moves a point by a fifth of the body's length.
    farthest = np.linalg.norm(elastic(modes)[0], axis=1).max()
    bend = basis.origin["amplitude"] * farthest
    assert bend == pytest.approx(0.2 * np.ptp(solid.points, axis=0).max(), rel=1e-12)
    fields = weighted(modes, derivatives, basis.origin["amplitude"])
    values = singular(solid, fields)
    assert basis.singular_values == pytest.approx(values, abs=1e-12 * values[0])
    assert basis.kept == pytest.approx((values[:6] ** 2).sum() / (values**2).sum(), rel=1e-12)
    # Nothing misses less of the candidates: what is lost are the other singular values.
    flat = fields.reshape(len(fields), -1).T
    U = basis.shapes.reshape(6, -1).T
    mass = solid.mass()
    rest = flat - U @ (U.T @ (mass @ flat))
    assert np.sum(rest * (mass @ rest)) == pytest.approx((values[6:] ** 2).sum(), rel=1e-6)
    if not held:
        assert np.abs(rigid(modes) @ (mass @ U)).max() < 1e-13


def test_weights_of_the_derivatives():
    solid, modes = usual()
    derivatives = modal_derivatives(solid, modes)
    for amplitude in (1.0, 30.0):
        basis = modal_derivative_basis(
            solid, modes, 4, derivatives=derivatives, amplitude=amplitude
        )
        values = singular(solid, weighted(modes, derivatives, amplitude))
        assert basis.singular_values == pytest.approx(values, abs=1e-12 * values[0])


def test_share_chooses_the_size():
    solid, modes = usual()
    derivatives = modal_derivatives(solid, modes)
    whole = modal_derivative_basis(solid, modes, derivatives=derivatives, share=1.0)
    assert whole.size == len(whole.singular_values) == 14
    assert whole.kept == 1.0
    assert spans(solid, derivatives, whole.shapes) < 1e-9
    squares = whole.singular_values**2
    for share in (0.5, 0.99, 1.0 - 1e-6):
        basis = modal_derivative_basis(solid, modes, derivatives=derivatives, share=share)
        assert basis.kept >= share
        assert squares[: basis.size - 1].sum() / squares.sum() < share
    capped = modal_derivative_basis(solid, modes, 3, derivatives=derivatives, share=1.0)
    assert capped.size == 3


def test_a_linear_bodys_are_its_modes():
    solid = beam(LinearElastic(**SOFT))
    modes = linear_modes(solid, 4)
    basis = modal_derivative_basis(solid, modes, 4)
    # Singular values are the weights λ₁/λ_i, which descend.
    assert basis.shapes == pytest.approx(modes.shapes, abs=1e-7 * np.abs(modes.shapes).max())
    assert basis.singular_values[4:] == pytest.approx(0.0, abs=1e-15)
    with pytest.raises(DefoError, match="at most 4, the number of independent candidates, got 5"):
        modal_derivative_basis(solid, modes, 5)


def test_nearly_dependent_fields_do_not_harm():
    """Where a Gram matrix of the fields would hold nothing but round-off."""
    solid, modes = usual()
    rng = np.random.default_rng(1)
    shapes = elastic(modes)
    fields = shapes[:1] + 1e-9 * np.tensordot(rng.standard_normal((5, 4)), shapes, 1)
    basis = snapshot_basis(solid, fields, 4)
    check_record(solid, basis, "snapshots")
    assert basis.singular_values[1] < 1e-8 * basis.singular_values[0]
    assert spans(solid, shapes, basis.shapes) < 1e-5


def test_equal_singular_values_have_one_answer():
    """Round-off would turn the two bending modes of a square section by any angle."""
    points, cells = beam_arrays("hexahedron", (4, 2, 2))
    angle, radius = np.arctan2(points[:, 0], points[:, 2]), np.hypot(points[:, 0], points[:, 2])
    straight = np.stack([angle, points[:, 1] - 0.25, (radius - 2.175) * (0.5 / 0.35)], axis=1)
    solid = Solid(build_mesh(straight, cells, kind="hexahedron"), STVK, fixed=["x<1e-9"])
    modes = linear_modes(solid, 2)
    swing = np.cos(np.linspace(0.0, 2.0 * np.pi, 9)[:-1]), np.sin(np.linspace(0, 2 * np.pi, 9)[:-1])
    circle = np.tensordot(np.array(swing).T, modes.shapes, 1)
    one = snapshot_basis(solid, circle, 2)
    assert one.singular_values == pytest.approx([2.0, 2.0] + 6 * [0.0], abs=1e-12)
    turned = np.array([[0.6, 0.8], [-0.8, 0.6]])
    other = snapshot_basis(solid, np.tensordot(turned, circle[[0, 2]], 1), 2)
    assert one.shapes == pytest.approx(other.shapes, abs=1e-9 * np.abs(one.shapes).max())


def states_of(fields):
    zero = np.zeros_like(fields[0])
    return [State(0.1 * k, k, field, zero, zero) for k, field in enumerate(fields)]


def test_snapshots_of_all_kinds(tmp_path):
    solid, modes = usual()
    rng = np.random.default_rng(2)
    fields = np.tensordot(rng.standard_normal((7, 3)), elastic(modes)[:3], 1)
    expected = snapshot_basis(solid, fields, 3)
    check_record(solid, expected, "snapshots")
    assert expected.kept == pytest.approx(1.0, abs=1e-14)
    assert expected.origin["snapshots"] == 7
    assert spans(solid, elastic(modes)[:3], expected.shapes) < 1e-12
    mesh = FrameMesh(solid.points, solid.cells, solid.nodes.cell_type)
    series = FrameSeries(tmp_path, "motion", mesh)
    for time, field in enumerate(fields):
        series.append(float(time), {"displacement": field, "velocity": 0.0 * field})
    for snapshots in (list(fields), states_of(fields), tmp_path, tmp_path / "motion.pvd"):
        basis = snapshot_basis(solid, snapshots, 3)
        assert (basis.shapes == expected.shapes).all()
    single = static_equilibrium(solid, [Gravity((0.0, 0.0, -0.1))])
    one = snapshot_basis(solid, single, 1)
    assert spans(solid, single.displacement[None], one.shapes) < 1e-12


def test_a_recorded_motion_of_another_body(tmp_path):
    solid, _ = usual()
    with pytest.raises(FileFormatError, match="cannot be read"):
        snapshot_basis(solid, tmp_path, 3)
    other = beam(cells=(3, 1, 1))
    mesh = FrameMesh(other.points, other.cells, other.nodes.cell_type)
    series = FrameSeries(tmp_path, "motion", mesh)
    series.append(0.0, {"displacement": other.points})
    with pytest.raises(FileFormatError, match="motion of another body, its 16 nodes"):
        snapshot_basis(solid, tmp_path, 3)


def test_a_flying_bodys_snapshots_lose_their_rigid_motion():
    """Deformations seen from a tumbling body, turned by any angle, are those it has at rest."""
    solid, modes = usual(held=False)
    rng = np.random.default_rng(3)
    shapes = 0.2 * elastic(modes)[:2] / np.abs(elastic(modes)[:2]).max()
    fields = np.tensordot(rng.standard_normal((6, 2)), shapes, 1)
    basis = snapshot_basis(solid, fields, share=1.0 - 1e-12)
    mass, flat = solid.mass(), basis.shapes.reshape(basis.size, -1)
    assert np.abs(rigid(modes) @ (mass @ flat.T)).max() < 1e-13
    turns = [linalg.expm(np.cross(np.eye(3), rng.standard_normal(3))) for _ in fields]
    flown = [
        (solid.points + field) @ turn.T + rng.standard_normal(3) - solid.points
        for field, turn in zip(fields, turns, strict=True)
    ]
    again = snapshot_basis(solid, np.array(flown), basis.size)
    assert again.singular_values == pytest.approx(
        basis.singular_values, abs=1e-11 * basis.singular_values[0]
    )
    assert spans(solid, again.shapes, basis.shapes) < 1e-6


def test_joined_bases_hold_both():
    solid, modes = usual()
    one = linear_basis(solid, modes, 3)
    rng = np.random.default_rng(4)
    tents = np.where(solid.held, 0.0, rng.standard_normal((2, *solid.points.shape)))
    other = basis_from_array(solid, np.concatenate([modes.shapes[1:2] + modes.shapes[:1], tents]))
    both = join(solid, one, other)
    check_record(solid, both, "joined")
    assert both.size == 5  # one column is no news
    assert both.shapes[:3] == pytest.approx(one.shapes, abs=1e-12 * np.abs(one.shapes).max())
    assert spans(solid, other.shapes, both.shapes) < 1e-12
    assert both.origin == {"kinds": ("linear", "given"), "sizes": (3, 3)}
    assert join(solid, one, one).size == 3
    assert join(solid, other, one).size == 5
    with pytest.raises(DefoError, match="two or more bases, got 1"):
        join(solid, one)


def test_given_fields_are_kept():
    solid, modes = usual()
    rng = np.random.default_rng(5)
    fields = np.tensordot(rng.standard_normal((3, 4)), elastic(modes), 1)
    basis = basis_from_array(solid, fields)
    assert basis.kind == "given"
    assert (basis.shapes == fields).all()
    fields[:] = 0.0  # a copy was taken
    assert np.abs(basis.shapes).max() > 0.0
    assert not basis.is_orthonormal
    assert basis.mass == pytest.approx(gram(solid, basis.shapes), rel=1e-12)


def test_given_fields_that_are_no_basis():
    solid, modes = usual()
    fields = np.array(elastic(modes)[:3])
    moved = fields.copy()
    moved[1][solid.held] = 1e-3
    for given, message in [
        (fields[0], r"shapes must have the shape \(r, 20, 3\), r from 1.*got \(20, 3\)"),
        (fields[:0], "r from 1"),
        (fields * np.nan, "must be finite"),
        (moved, "zero where the body is held, but number 1 is 0.001 there"),
        (fields * np.array([1, 0, 1])[:, None, None], "number 1 is; leave it out"),
        (np.stack([*fields, fields[0] - 2.0 * fields[2]]), "hang together, from 0: 0, 2, 3"),
        (np.stack([*fields, fields[1] * (1 + 1e-9)]), "hang together, from 0: 1, 3"),
    ]:
        with pytest.raises(DefoError, match=message):
            basis_from_array(solid, given)
    every = np.zeros((61, 60))
    every[:60] = np.eye(60)
    free = beam(held=False)
    with pytest.raises(DefoError, match="must be independent"):  # more than there are components
        basis_from_array(free, every.reshape(61, 20, 3) + 1.0)


def test_nodes_that_first_order_displacements_do_not_have():
    """On a mesh of second order the mid nodes follow their corners, whatever is given for them."""
    solid = beam(STVK, kind="tetrahedron", order=2)
    mesh = build_mesh(solid.points, solid.cells, kind="tetrahedron")
    first = Solid(mesh, STVK, order=1, fixed=["x<1e-9"])
    middle = ~first.nodes.carried
    assert middle.any()
    modes = linear_modes(first, 2)
    given = modes.shapes.copy()
    given[:, middle & ~first.held.any(axis=1)] += 1.0
    basis = basis_from_array(first, given)
    assert basis.shapes == pytest.approx(modes.shapes, abs=1e-12 * np.abs(modes.shapes).max())
    assert linear_basis(first, modes).shapes == pytest.approx(basis.shapes, abs=1e-6)


def test_what_does_not_say_how_many():
    solid, modes = usual()
    for size, share, message in [
        (None, None, "say how large"),
        (0, None, "whole number from 1, got 0"),
        (2.5, None, "got 2.5"),
        (True, None, "got True"),
        (None, 0.0, "share must be above 0 and at most 1, got 0.0"),
        (None, float("nan"), "got nan"),
        (None, 1.5, "got 1.5"),
        (15, None, "at most 14, the number of independent candidates, got 15"),
    ]:
        with pytest.raises(DefoError, match=message):
            modal_derivative_basis(solid, modes, size, share=share)
    with pytest.raises(DefoError, match="at most 4, the number of elastic modes, got 5"):
        linear_basis(solid, modes, 5)
    with pytest.raises(DefoError, match="amplitude must be positive"):
        modal_derivative_basis(solid, modes, 3, amplitude=-1.0)
    with pytest.raises(DefoError, match="4 modes have 10 derivatives, got 4"):
        modal_derivative_basis(solid, modes, 3, derivatives=modes.shapes)
    with pytest.raises(DefoError, match="all fields are zero"):
        snapshot_basis(solid, np.zeros((2, *solid.points.shape)), 1)
    with pytest.raises(DefoError, match="snapshots must be an array"):
        snapshot_basis(solid, [object()], 1)


def test_the_record_checks_itself():
    shapes = np.ones((2, 4, 3))
    basis = Basis(shapes=shapes, mass=np.diag([1.0, 2.0]), kind="given", origin={"a": 1})
    assert basis.size == 2
    with pytest.raises(ValueError, match="read-only"):
        basis.shapes[0] = 0.0
    with pytest.raises(TypeError):
        basis.origin["a"] = 2
    for change, message in [
        ({"shapes": shapes[0]}, r"must be \(r, n, 3\)"),
        ({"mass": np.eye(3)}, r"of the shape \(2, 2\), got \(3, 3\)"),
        ({"mass": np.array([[1.0, 0.5], [0.0, 1.0]])}, "must be symmetric"),
        ({"mass": np.full((2, 2), np.nan)}, "mass of a basis must be finite"),
        ({"shapes": shapes * np.inf}, "shapes of a basis must be finite"),
    ]:
        with pytest.raises(DefoError, match=message):
            Basis(**({"shapes": shapes, "mass": np.eye(2), "kind": "given"} | change))


def test_nothing_is_logged(caplog):
    """The library is silent on what is as it should be."""
    with caplog.at_level(logging.INFO):
        solid, modes = usual()
        modal_derivative_basis(solid, modes, 3)
    assert not caplog.records


def test_the_weights_do_not_depend_on_the_size_and_weight_of_a_body():
    """Bodies of one form have one spectrum, whatever their length, modulus and density are."""
    spectra = []
    points, cells = beam_arrays("hexahedron")
    for scale, density in ((1.0, 1e3), (1e-3, 20.0)):
        law = StVenantKirchhoff(young=density**2, poisson=0.3, density=density)
        mesh = build_mesh(scale * points, cells, kind="hexahedron")
        solid = Solid(mesh, law, fixed=[f"x<{1e-9 * scale}"])
        values = modal_derivative_basis(solid, linear_modes(solid, 3), 5).singular_values
        spectra.append(values / values[0])
    assert spectra[1] == pytest.approx(spectra[0], rel=1e-6, abs=1e-9)
