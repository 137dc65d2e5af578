"""Modal derivatives are the second derivatives of the body's answer to modal loads."""

from dataclasses import replace

import numpy as np
import pytest
from bent_bodies import (
    NEO,
    SOFT,
    STVK,
    beam,
    curved_response,
    elastic,
    rigid,
    usual,
)

from fenics_defo.analysis import Gravity, Phases, linear_modes, static_equilibrium
from fenics_defo.analysis.static_response import StaticResponse
from fenics_defo.energy import Corotational, Invertible, LinearElastic, MassSpring
from fenics_defo.errors import DefoError, EigenSolveError, SolverError
from fenics_defo.reduction import modal_derivatives
from fenics_defo.reduction.body_fields import own_columns

SPRINGS = MassSpring(young=1e5, density=1000.0)
WARPED = Corotational(**SOFT, tangent="approximate")
BODIES = {
    "stvk": {"material": STVK},
    "stvk free": {"material": STVK, "held": False},
    "stvk tetrahedra of order 2": {"material": STVK, "kind": "tetrahedron", "order": 2},
    "neo": {"material": NEO},
    "corotational": {"material": Corotational(**SOFT)},
    "invertible free": {"material": Invertible(NEO, tangent="exact"), "held": False},
    "springs": {"material": SPRINGS, "kind": "tetrahedron"},
}


def pairs_of(count):
    return list(zip(*np.triu_indices(count), strict=True))


def check_response(solid, modes, derivatives, pair, state):
    """Differences tend to the derivative with the square of their step."""
    exact = derivatives[pairs_of(len(elastic(modes))).index(pair)]
    size, step = np.abs(exact).max(), 0.04 / np.abs(elastic(modes)[list(pair)]).max()
    rough, fine = (
        curved_response(solid, modes, pair, step * part, state) - exact for part in (1.0, 0.5)
    )
    assert np.linalg.norm(rough) / np.linalg.norm(fine) == pytest.approx(4.0, rel=0.05)
    assert np.abs(4.0 * fine - rough).max() < 1e-3 * size  # the limit is the derivative


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("pair", [(0, 0), (0, 2)])
def test_they_bend_the_static_response(name, pair):
    solid = beam(**BODIES[name])
    modes = linear_modes(solid, 9 if name.endswith("free") else 3)
    derivatives = modal_derivatives(solid, modes)
    assert derivatives.shape == (6, *solid.points.shape)
    assert (derivatives[:, solid.held] == 0.0).all()
    check_response(solid, modes, derivatives, pair, np.zeros(solid.points.shape))


@pytest.mark.parametrize("material", [STVK, Corotational(**SOFT)], ids=["stvk", "corotational"])
def test_they_bend_the_response_about_an_equilibrium(material):
    solid = beam(material)
    sagged = static_equilibrium(solid, [Gravity((0.0, 0.1, -0.3))], tolerance=1e-13).displacement
    assert np.abs(sagged).max() > 0.1
    modes = linear_modes(solid, 2, displacement=sagged)
    derivatives = modal_derivatives(solid, modes, displacement=sagged)
    check_response(solid, modes, derivatives, (0, 1), sagged)
    at_rest = modal_derivatives(solid, modes)
    assert np.abs(at_rest - derivatives).max() > 0.05 * np.abs(derivatives).max()


def test_a_free_bodys_hold_no_rigid_motion():
    solid, modes = usual(held=False)
    derivatives = modal_derivatives(solid, modes)
    mass, motions = solid.mass(), rigid(modes)
    flat = derivatives.reshape(10, -1).T
    lengths = np.sqrt(np.diag(flat.T @ (mass @ flat)))
    assert np.abs(motions @ (mass @ flat) / lengths).max() < 1e-12
    # What is left of the load is the inertia of a rigid acceleration.
    force = solid.tangent() @ flat
    load = np.empty_like(force)
    with StaticResponse(solid) as response:
        columns = own_columns(solid, elastic(modes))
        for place, (i, j) in enumerate(pairs_of(4)):
            curved = response.curvature(solid.nodes.scatter(elastic(modes)[j]), columns[:, [i]])
            load[:, place] = -solid.nodes.gather_own(curved.reshape(-1, 3)).ravel()
    rest = load - force
    inertia = mass @ motions.T @ (motions @ load)
    assert rest == pytest.approx(inertia, abs=1e-11 * np.abs(load).max())
    assert np.abs(inertia).max() > 1e-3 * np.abs(load).max()  # the projection is no formality


@pytest.mark.parametrize("material", [STVK, NEO, WARPED, SPRINGS], ids=lambda m: type(m).__name__)
def test_the_two_modes_of_a_pair_may_change_places(material):
    """H is symmetric, also by differences, and of laws whose own tangent is no derivative."""
    kind = "tetrahedron" if material is SPRINGS else "hexahedron"
    solid = beam(material, kind=kind)
    shapes = elastic(linear_modes(solid, 3))
    columns, local = own_columns(solid, shapes), [solid.nodes.scatter(s) for s in shapes]
    with StaticResponse(solid) as response:
        table = np.stack([response.curvature(direction, columns) for direction in local])
    one_way, other_way = table, table.transpose(2, 1, 0)
    assert one_way == pytest.approx(other_way, abs=1e-10 * np.abs(table).max())
    assert np.abs(table).max() > 0.0


def test_they_turn_with_the_body():
    """About a rest shape that was turned as a whole they are those of rest, turned."""
    solid, modes = usual(held=False)
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    turned = replace(modes, shapes=modes.shapes @ turn.T)
    found = modal_derivatives(solid, turned, displacement=solid.points @ turn.T - solid.points)
    expected = modal_derivatives(solid, modes) @ turn.T
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def test_a_linear_body_has_none():
    solid = beam(LinearElastic(**SOFT))
    assert (modal_derivatives(solid, linear_modes(solid, 3)) == 0.0).all()


def test_many_modes_are_solved_for_in_blocks_alike():
    """More pairs than go into one block; each pair in its place."""
    solid = beam()
    many, few = linear_modes(solid, 14), linear_modes(solid, 3)
    phases = Phases()
    derivatives = modal_derivatives(solid, many, phases=phases)
    assert set(phases.seconds) == {"assemble", "factorise", "multiply", "solve", "gather"}
    assert len(derivatives) == 105 > 64
    expected = modal_derivatives(solid, few)
    chosen = [pairs_of(14).index(pair) for pair in pairs_of(3)]
    assert derivatives[chosen] == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_what_cannot_be_is_refused():
    solid, modes = usual()
    free, free_modes = usual(held=False)
    with pytest.raises(DefoError, match="all 6 modes are rigid"):
        modal_derivatives(free, free_modes.select(slice(6)))
    with pytest.raises(DefoError, match=r"number 0 is .* there"):
        modal_derivatives(solid, free_modes.select(slice(6, None)))
    with pytest.raises(DefoError, match="must be what linear_modes"):
        modal_derivatives(solid, modes.shapes)
    with pytest.raises(DefoError, match="another body: its nodes"):
        modal_derivatives(solid, replace(modes, points=modes.points + 0.1))
    with pytest.raises(DefoError, match=r"displacement must have the shape \(20, 3\)"):
        modal_derivatives(solid, modes, displacement=np.zeros((3, 3)))
    with pytest.raises(SolverError, match="free to move as a whole and loaded"):
        modal_derivatives(free, free_modes, displacement=0.1 * free.points)
    with pytest.raises(EigenSolveError, match="not a stable state"):
        modal_derivatives(solid, modes, displacement=-0.7 * solid.points * ~solid.held)
