from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fenics_defo.errors import DefoError, LoadError, SelectionError
from fenics_defo.runtime import LinearForce, Outputs, Probe, ReducedModel
from tests.unit.runtime.reduced_models import SIZE, make_frame, make_law, make_model

KINDS = ("linear", "cubic", "taylor")


@pytest.mark.parametrize("shape", [(), (4,), (2, 3), (0,)])
def test_what_moves_is_the_product_with_the_shapes(shape: tuple[int, ...]) -> None:
    model = make_model()
    q = np.random.default_rng(1).normal(size=(*shape, SIZE))
    expected = np.einsum("pck,...k->...pc", model.shapes, q)
    np.testing.assert_allclose(model.displacement(q), expected, rtol=1e-13, atol=1e-15)
    expected = np.einsum("ck,...k->...c", model.probes["tip"].shapes, q)
    np.testing.assert_allclose(model.probe("tip", q), expected, rtol=1e-13, atol=1e-15)


def test_shapes_lie_as_one_matrix() -> None:
    flipped = np.asfortranarray(np.random.default_rng(1).normal(size=(5, 3, SIZE)))
    model = make_model()
    outputs = Outputs(nodes=model.nodes, points=model.points, shapes=flipped)
    assert outputs.shapes.flags.c_contiguous
    np.testing.assert_array_equal(outputs.shapes, flipped)


@pytest.mark.parametrize("kind", KINDS)
def test_force_stiffness_and_energy_are_those_of_the_law(kind: str) -> None:
    model = make_model(kind)
    q = np.random.default_rng(1).normal(size=(4, SIZE))
    np.testing.assert_array_equal(model.force(q), model.law.force(q))
    np.testing.assert_array_equal(model.stiffness(q), model.law.stiffness(q))
    np.testing.assert_array_equal(model.energy(q), model.law.energy(q))
    np.testing.assert_allclose(model.force(q[0].tolist()), model.law.force(q)[0], rtol=1e-13)


def test_loads_do_the_work_of_their_forces() -> None:
    """The force on q is that of which every virtual displacement does the same work."""
    model = make_model()
    way, force = np.random.default_rng(1).normal(size=(2, SIZE))
    for row, node in enumerate(model.nodes):
        work = model.displacement(way)[row] @ force
        assert model.point_load(int(node), force) @ way == pytest.approx(work, rel=1e-12)
    several = model.point_load(7, np.stack([force, 2.0 * force]))
    np.testing.assert_allclose(several[1], 2.0 * model.point_load(7, force), rtol=1e-14)
    np.testing.assert_allclose(model.gravity((0, 0, -2)), -2.0 * model.gravity_rows[2])
    np.testing.assert_array_equal(model.load("push"), model.loads["push"])


def test_frequencies_are_those_of_the_generalised_problem() -> None:
    """Coordinates in which M is a full matrix vibrate as the mass-normalised ones do."""
    turn = np.random.default_rng(4).normal(size=(SIZE, SIZE))
    squares = np.array([4.0, 25.0, 900.0])
    law = LinearForce(turn.T @ np.diag(squares) @ turn)
    model = ReducedModel(law=law, mass=turn.T @ turn)
    np.testing.assert_allclose(2 * np.pi * model.frequencies, [2.0, 5.0, 30.0], rtol=1e-9)


def test_an_unstable_rest_state_has_no_frequency() -> None:
    model = ReducedModel(law=LinearForce(np.diag([-1.0, 4.0])), mass=np.eye(2))
    np.testing.assert_allclose(model.frequencies, [0.0, 1.0 / np.pi])


def test_what_was_not_asked_for_is_absent() -> None:
    model = ReducedModel(law=make_law(), mass=np.eye(SIZE))
    assert model.displacement(np.ones((2, SIZE))).shape == (2, 0, 3)
    np.testing.assert_array_equal(model.gravity((1.0, 2.0, 3.0)), np.zeros(SIZE))
    assert (dict(model.loads), dict(model.probes), model.frame) == ({}, {}, None)
    with pytest.raises(LoadError, match="no load 'push', it has none at all"):
        model.load("push")


@pytest.mark.parametrize(
    ("node", "message"),
    [
        (1, "node 1 is not among the 5 nodes stored in this model, 0 to 11 counted from 0; name"),
        (12, "node 12 is not among"),
        (-1, "node -1 is not among"),
        (2**70, f"node {2**70} is not among"),
        (2.0, r"a node is an integer, counted from 0 .*, got 2\.0"),
        ("tip", "a node is an integer"),
    ],
)
def test_a_load_on_a_node_that_is_not_stored(node: Any, message: str) -> None:
    with pytest.raises(LoadError, match=message):
        make_model().point_load(node, (0.0, 0.0, 1.0))


@pytest.mark.parametrize("vector", [(1.0, 2.0), 3.0, (0.0, np.nan, 0.0), ("a", "b", "c"), None])
def test_vectors_are_three_finite_numbers(vector: Any) -> None:
    model = make_model()
    with pytest.raises(LoadError, match="a force is three finite numbers"):
        model.point_load(0, vector)
    with pytest.raises(LoadError, match="an acceleration is three finite numbers"):
        model.gravity(vector)


def test_unknown_names_are_answered_with_the_known_ones() -> None:
    model = make_model()
    with pytest.raises(LoadError, match="no load 'pull', it has 'push', 'wind 2'; name one"):
        model.load("pull")
    with pytest.raises(SelectionError, match="no probe 'top', it has 'tip', 'Mitte"):
        model.probe("top", np.zeros(SIZE))


@pytest.mark.parametrize("q", [np.zeros(SIZE + 1), 1.0, np.array([0.0, np.nan, 0.0])])
def test_coordinates_that_do_not_fit_are_refused(q: Any) -> None:
    model = make_model()
    for evaluate in (model.force, model.stiffness, model.energy, model.displacement):
        with pytest.raises(ValueError, match="q "):
            evaluate(q)
    with pytest.raises(ValueError, match="q "):
        model.probe("tip", q)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": np.eye(2)}, r"mass must have the shape \(3, 3\), got \(2, 2\)"),
        ({"mass": np.diag([1.0, 0.0, 1.0])}, "mass must be positive definite"),
        ({"mass": np.full((3, 3), np.nan)}, "mass holds values that are not finite"),
        ({"damping": (-1.0, 0.0)}, "damping must not be negative"),
        ({"damping": (np.inf, 0.0)}, "damping holds values that are not finite"),
        ({"damping": (0.0,)}, r"damping must have the shape \(2,\)"),
        ({"gravity_rows": np.zeros((3, 2))}, r"gravity_rows must have the shape \(3, 3\)"),
        ({"loads": {"push": np.zeros(2)}}, r"load 'push' must have the shape \(3,\)"),
        ({"loads": {"": np.zeros(3)}}, "the name of a load must be a printable text, got ''"),
        ({"loads": {"a\0": np.zeros(3)}}, "must be a printable text"),
        ({"loads": {"\ud800": np.zeros(3)}}, "must be a printable text"),
        ({"probes": {"a": Probe(point=np.zeros(3), shapes=np.ones((3, 2)))}}, "probe 'a' has 2"),
        ({"provenance": {"a": np.zeros(3)}}, "provenance must hold plain values"),
        ({"certificate": {"a": float("nan")}}, "certificate must hold plain values"),
        ({"law": LinearForce(np.eye(2)), "mass": np.eye(2)}, "must have the shape"),
    ],
)
def test_parts_that_do_not_fit_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_model(**changes)


def test_a_frame_of_another_size_is_refused() -> None:
    model = make_model(frame=make_frame())
    assert model.frame is not None
    with pytest.raises(ValueError, match="frame has 3 coordinates, the force law has 2"):
        ReducedModel(law=LinearForce(np.eye(2)), mass=np.eye(2), frame=make_frame())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nodes": np.array([0, 2, 2, 7, 11])}, "nodes must ascend"),
        ({"nodes": np.array([-1, 2, 3, 7, 11])}, "nodes must ascend"),
        ({"nodes": np.arange(5.0)}, "nodes must hold integers"),
        ({"nodes": np.arange(5, dtype=np.uint64) + 2**63}, "too large"),
        ({"points": np.zeros((4, 3))}, r"points must have the shape \(5, 3\)"),
        ({"shapes": np.zeros((5, 2, 3))}, r"shapes must have the shape \(5, 3, 3\)"),
        ({"cells": np.array([[0, 1, 2, 5]])}, "cells name nodes outside 0 to 4"),
        ({"cells": np.array([[0, 1, -1, 2]])}, "cells name nodes outside 0 to 4"),
        ({"cells": np.array([[0, 1, 2]])}, r"cells must have the shape \(1, 4\)"),
        ({"cell_type": "wedge"}, "cell_type 'wedge' is not one of"),
        ({"cell_type": ""}, r"cells must have the shape \(2, 0\)"),
    ],
)
def test_outputs_that_do_not_fit_are_refused(changes: dict[str, Any], message: str) -> None:
    given = make_model().outputs
    fields = {name: getattr(given, name) for name in ("nodes", "points", "shapes", "cells")}
    with pytest.raises(ValueError, match=message):
        Outputs(**({"cell_type": "tetra"} | fields | changes))


def test_it_says_in_a_line_what_it_is() -> None:
    assert repr(make_model(frame=make_frame(), probes={})) == (
        "ReducedModel(cubic force of 3 coordinates, 5 nodes, probes [], loads ['push', 'wind 2'], "
        "flies)"
    )


def test_the_record_cannot_be_changed_from_outside() -> None:
    loads, provenance = {"push": np.zeros(SIZE)}, {"files": ["a.msh"]}
    model = make_model(loads=loads, provenance=provenance)
    loads["pull"] = np.ones(SIZE)
    provenance["files"].append("b.msh")
    assert list(model.loads) == ["push"]
    assert model.provenance["files"] == ["a.msh"]
    for array in (model.mass, model.shapes, model.points, model.gravity_rows, model.load("push")):
        assert not array.flags.writeable
    with pytest.raises(TypeError, match="mappingproxy"):
        model.provenance["other"] = 1  # type: ignore[index]


def test_a_law_that_needs_more_than_arrays_is_not_stored(tmp_path: Any) -> None:
    law: Any = SimpleNamespace(kind="direct", size=SIZE)
    model = make_model(law=law)
    with pytest.raises(DefoError, match="kind 'direct' cannot be stored; the kinds that can"):
        model.save(tmp_path / "model.npz")
    assert list(tmp_path.iterdir()) == []
