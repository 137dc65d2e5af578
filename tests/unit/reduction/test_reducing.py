"""What reduce() puts into a model, and what it refuses."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fenics_defo import __version__, runtime
from fenics_defo.analysis import (
    Gravity,
    Impulse,
    PointLoad,
    Pressure,
    Ramp,
    Traction,
    linear_modes,
)
from fenics_defo.energy import Invertible, LinearElastic, NeoHookean, StVenantKirchhoff
from fenics_defo.errors import DefoError, LoadError, MaterialError, SelectionError
from fenics_defo.fem import Solid
from fenics_defo.reduction import Basis, basis_from_array, linear_basis, reduce
from fenics_defo.runtime.integrators import ImplicitNewmark
from tests.unit.fem.fem_bodies import MODULI
from tests.unit.reduction.tabulated_bodies import (
    SOFT,
    bent_body,
    coordinates,
    end_node,
    smooth_shapes,
)

SIZE = 5


@pytest.fixture(scope="module")
def solid() -> Solid:
    return bent_body(element=("tetrahedron", 2, 1))


@pytest.fixture(scope="module")
def basis(solid: Solid) -> Basis:
    return basis_from_array(solid, smooth_shapes(solid, SIZE))


def test_a_model_needs_the_body_no_more(solid: Solid, basis: Basis, tmp_path: Path) -> None:
    model = reduce(solid, basis, damping=(0.5, 1e-3), probes={"end": solid.points[end_node(solid)]})
    assert (model.law.kind, model.size, model.damping) == ("cubic", SIZE, (0.5, 1e-3))
    q = coordinates(basis.shapes, 0.2, 3)
    np.testing.assert_allclose(model.displacement(q), np.tensordot(q, basis.shapes, 1), atol=1e-14)
    np.testing.assert_allclose(
        model.probe("end", q), np.tensordot(q, basis.shapes, 1)[:, end_node(solid)], atol=1e-12
    )
    np.testing.assert_array_equal(model.outputs.cells, solid.cells)
    model.save(tmp_path / "one.npz")
    reduce(solid, basis, damping=(0.5, 1e-3), probes={"end": solid.points[end_node(solid)]}).save(
        tmp_path / "two.npz"
    )
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    loaded = runtime.load(tmp_path / "one.npz")
    np.testing.assert_array_equal(loaded.force(q), model.force(q))
    assert loaded.provenance == model.provenance


def test_masses(solid: Solid, basis: Basis) -> None:
    rows = basis.shapes.reshape(SIZE, -1)
    model = reduce(solid, basis)
    np.testing.assert_allclose(model.mass, rows @ (solid.mass() @ rows.T), rtol=1e-11)
    lumped = reduce(solid, basis, mass="lumped")
    diagonal = np.repeat(solid.lumped_mass(), 3)
    np.testing.assert_allclose(lumped.mass, (rows * diagonal) @ rows.T, rtol=1e-11)
    for found, matrix in ((model, solid.mass()), (lumped, np.diag(diagonal))):
        field = np.tile((1.0, -2.0, 3.0), solid.nodes.size)
        np.testing.assert_allclose(
            found.gravity((1.0, -2.0, 3.0)), rows @ (matrix @ field), rtol=1e-10
        )


def test_modes_become_decoupled_oscillators() -> None:
    solid = bent_body(SOFT)
    modes = linear_modes(solid, 4)
    model = reduce(solid, linear_basis(solid, modes), "linear", range_tolerance=None)
    np.testing.assert_array_equal(model.mass, np.eye(4))
    np.testing.assert_allclose(model.frequencies, modes.frequencies, rtol=1e-9)
    K = model.stiffness(np.zeros(4))
    assert np.abs(K - np.diag(np.diag(K))).max() < 1e-9 * K.max()


def test_loads_are_projected(solid: Solid, basis: Basis) -> None:
    end = end_node(solid)
    loads = {
        "weight": Gravity((0.0, 0.0, -9.81)),
        "pull": PointLoad(node=end, vector=(1.0, 2.0, 3.0), history=Ramp(2.0)),
        "blow": Impulse(node=end, vector=(3.0, 0.0, 1.0), time=0.5),
        "air": Pressure("x>=0", 40.0, history=Ramp(1.0)),
    }
    model = reduce(solid, basis, loads=loads)
    assert set(model.loads) == set(loads)
    np.testing.assert_allclose(model.load("weight"), model.gravity((0.0, 0.0, -9.81)), rtol=1e-12)
    for name, vector in (("pull", (1.0, 2.0, 3.0)), ("blow", (3.0, 0.0, 1.0))):
        np.testing.assert_allclose(model.load(name), model.point_load(end, vector), rtol=1e-12)
    # A pressure on all sides does the work -p dV: of shapes of first order, -p ∫ div U dX.
    linear = bent_body(SOFT, fixed=[])
    gradient = np.random.default_rng(2).standard_normal((3, 3))
    shapes = np.array([linear.points @ gradient.T])
    squeezed = reduce(linear, basis_from_array(linear, shapes), loads=[Pressure("x>=0", 40.0)])
    volume = linear.total_mass() / SOFT.density
    assert squeezed.load("pressure")[0] == pytest.approx(-40.0 * volume * np.trace(gradient))


def test_loads_get_names_of_their_kind(solid: Solid, basis: Basis) -> None:
    pulls = [Traction("x>=0", (0.0, 0.0, float(f))) for f in (1, 2)]
    model = reduce(solid, basis, loads=[*pulls, Gravity()])
    assert list(model.loads) == ["traction", "traction 2", "gravity"]
    np.testing.assert_allclose(model.load("traction 2"), 2.0 * model.load("traction"))
    with pytest.raises(LoadError, match="a load must be"):
        reduce(solid, basis, loads=["gravity"])


def test_outputs_may_be_few(solid: Solid, basis: Basis) -> None:
    by_region = reduce(solid, basis, outputs="x>0.8")
    wanted = np.flatnonzero(solid.points[:, 0] > 0.8)
    np.testing.assert_array_equal(by_region.nodes, wanted)
    assert by_region.outputs.cell_type == ""
    by_number = reduce(solid, basis, outputs=wanted[::-1])
    np.testing.assert_array_equal(by_number.nodes, wanted)
    q = coordinates(basis.shapes, 0.1)[0]
    np.testing.assert_array_equal(by_number.displacement(q), by_region.displacement(q))
    whole = reduce(solid, basis)
    np.testing.assert_allclose(whole.displacement(q)[wanted], by_region.displacement(q), atol=1e-15)
    for outputs in ([-1], [10**6], [0.5], "x>99"):
        with pytest.raises(SelectionError):
            reduce(solid, basis, outputs=outputs)


def test_a_body_that_nothing_holds_has_a_frame() -> None:
    solid = bent_body(SOFT, fixed=[])
    x = solid.points - solid.points.mean(axis=0)
    stretch = x[None] * (1.0, 0.0, 0.0)
    shift = np.broadcast_to((1.0, 0.0, 0.0), x.shape)
    model = reduce(solid, basis_from_array(solid, stretch))
    assert model.frame is not None
    assert model.frame.mass == pytest.approx(solid.total_mass())
    moving = basis_from_array(solid, np.array([stretch[0], shift]))
    assert reduce(solid, moving).frame is None
    with pytest.raises(DefoError, match="rigid motion"):
        reduce(solid, moving, floating=True)
    assert reduce(solid, basis_from_array(solid, stretch), floating=False).frame is None


def test_it_tells_where_it_comes_from(solid: Solid, basis: Basis) -> None:
    told = json.loads(json.dumps(dict(reduce(solid, basis, "linear").provenance)))
    assert told["mesh"]["nodes"] == len(solid.points)
    assert len(told["mesh"]["sha256"]) == 64
    assert [m["region"] for m in told["materials"]] == [None, "x>0.7"]
    assert told["materials"][1]["law"] == "StVenantKirchhoff"
    assert told["basis"]["size"] == SIZE
    assert told["packages"]["fenics-defo"] == __version__
    moved = bent_body({None: Invertible(NeoHookean(**MODULI))})
    other = reduce(moved, basis_from_array(moved, smooth_shapes(moved, 1)), "direct").provenance
    assert other["mesh"]["sha256"] != told["mesh"]["sha256"]
    assert other["materials"][0]["law"] == "NeoHookean"
    assert other["materials"][0]["invertible_below"] == 0.1


@pytest.mark.parametrize(
    ("law", "force", "exact"),
    [
        (SOFT, "cubic", True),
        (SOFT, "direct", True),
        (SOFT, "linear", False),
        (SOFT, "taylor", False),
        (LinearElastic(**MODULI), "linear", True),
    ],
)
def test_the_certificate(law: Any, force: str, exact: bool) -> None:
    solid = bent_body(law)
    model = reduce(solid, basis_from_array(solid, smooth_shapes(solid, 2)), force)
    told = model.certificate["force"]
    assert (told["kind"], told["exact"], "reach_m" in told) == (force, exact, not exact)
    if exact and force != "direct":
        assert told["measured_error"] < 1e-12
    without = reduce(
        solid, basis_from_array(solid, smooth_shapes(solid, 2)), force, range_tolerance=None
    )
    assert dict(without.certificate) == {"force": {"kind": force, "exact": exact}}


def test_the_direct_model_runs_but_is_not_stored(tmp_path: Path) -> None:
    solid = bent_body(NeoHookean(**MODULI))
    basis = basis_from_array(solid, smooth_shapes(solid, 2))
    model = reduce(solid, basis, "direct")
    stepper = ImplicitNewmark(model, step=1e-3)
    stepper.advance(model.gravity((0.0, 0.0, -9.81)))
    assert np.isfinite(stepper.q).all()
    with pytest.raises(DefoError, match="cannot be stored"):
        model.save(tmp_path / "direct.npz")


def test_requests_that_make_no_sense(solid: Solid, basis: Basis) -> None:
    with pytest.raises(DefoError, match="force must be one of 'linear', 'cubic'"):
        reduce(solid, basis, "quadratic")
    with pytest.raises(DefoError, match="use basis_from_array"):
        reduce(solid, basis.shapes)
    with pytest.raises(DefoError, match='mass must be "consistent", or "lumped"'):
        reduce(solid, basis, mass="diagonal")
    with pytest.raises(LoadError, match="outside of the body"):
        reduce(solid, basis, probes={"far": (9.0, 9.0, 9.0)})
    heavy = bent_body(
        StVenantKirchhoff(young=1e5, poisson=0.3, density=5e3), element=("tetrahedron", 2, 1)
    )
    with pytest.raises(DefoError, match="it was made of another body"):
        reduce(heavy, basis)
    other = bent_body(NeoHookean(**MODULI))
    with pytest.raises(MaterialError, match="NeoHookean"):
        reduce(other, basis_from_array(other, smooth_shapes(other, 1)), "cubic")
