from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.analysis.motion import RIGID_SHARE, describe_motion
from fenics_defo.runtime import Modes

Array = NDArray[np.float64]

CANTILEVER_ROOT = 1.8751040687  # cos x cosh x = -1


def box(length: float, width: float, height: float, cells: tuple[int, int, int]) -> Array:
    """Nodes (n, 3) of a grid with x along the length, centred on the axis."""
    ticks = [
        np.linspace(0.0, length, cells[0] + 1),
        np.linspace(-width / 2, width / 2, cells[1] + 1),
        np.linspace(-height / 2, height / 2, cells[2] + 1),
    ]
    return np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)


def cantilever(s: Array, root: float = CANTILEVER_ROOT) -> tuple[Array, Array]:
    """Euler-Bernoulli shape of a clamped beam and its slope at s = x / length."""
    r = root
    ratio = (np.cosh(r) + np.cos(r)) / (np.sinh(r) + np.sin(r))
    shape = np.cosh(r * s) - np.cos(r * s) - ratio * (np.sinh(r * s) - np.sin(r * s))
    slope = np.sinh(r * s) + np.sin(r * s) - ratio * (np.cosh(r * s) - np.cos(r * s))
    return shape, r * slope


def bending(points: Array, direction: Array, root: float = CANTILEVER_ROOT) -> Array:
    """Plane sections stay normal to the bent axis."""
    length = np.ptp(points[:, 0])
    shape, slope = cantilever(points[:, 0] / length, root)
    along = points @ direction
    return shape[:, None] * direction - (slope / length * along)[:, None] * np.eye(3)[0]


def torsion(points: Array, half_waves: float = 0.5) -> Array:
    angle = np.sin(np.pi * half_waves * points[:, 0] / np.ptp(points[:, 0]))
    return np.cross(np.eye(3)[0], points) * angle[:, None]


def axial(points: Array, half_waves: float = 0.5) -> Array:
    return np.outer(np.sin(np.pi * half_waves * points[:, 0] / np.ptp(points[:, 0])), np.eye(3)[0])


def rigid(points: Array) -> list[Array]:
    unit = np.eye(3)
    shifts = [np.broadcast_to(e, points.shape) for e in unit]
    return shifts + [np.cross(e, points) for e in unit]


def record(points: Array, shapes: list[Array], **changes: Any) -> Modes:
    k, n = len(shapes), len(points)
    fields: dict[str, Any] = {
        "frequencies": np.arange(1.0, k + 1.0),
        "shapes": np.array(shapes),
        "points": points,
        "cells": np.array([[0, 1, 2, 3]]),
        "cell_type": "tetra",
        "node_numbers": np.arange(1, n + 1),
        "node_mass": np.full(n, 2.0 / n),
        "residuals": np.zeros(k),
        "rigid_modes": 0,
        "complete": True,
        "participation": np.zeros((k, 6)),
        "total_mass": 2.0,
        "centre": np.zeros(3),
        "inertia": np.ones(6),
    }
    return Modes(**(fields | changes))


BEAM = box(1.0, 0.1, 0.06, (40, 4, 3))
Y, Z = np.eye(3)[1:]


def kinds(points: Array) -> list[Array]:
    return [
        bending(points, Y),
        bending(points, Z),
        torsion(points),
        axial(points),
        bending(points, Z, 4.6940911330),
        torsion(points, 1.5),
        axial(points, 2.5),
    ]


WORDS = ("bending y", "bending z", "torsion", "axial", "bending z", "torsion", "axial")


@pytest.mark.parametrize("cells", [(40, 4, 3), (13, 2, 2), (100, 1, 1), (37, 6, 5)])
def test_beam_theory_is_called_by_its_name(cells: tuple[int, int, int]) -> None:
    points = box(1.0, 0.1, 0.06, cells)
    assert describe_motion(record(points, kinds(points))) == WORDS


def test_shortest_slender_box_still_has_names() -> None:
    points = box(4.0, 1.0, 1.0, (16, 4, 4))
    assert describe_motion(record(points, kinds(points))) == WORDS


def test_stubby_body_has_none_and_a_cube_neither() -> None:
    for size in ((2.5, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 0.9, 0.05)):
        points = box(*size, (16, 6, 6))
        assert set(describe_motion(record(points, kinds(points)))) == {""}


def test_scattered_nodes_and_uneven_masses() -> None:
    rng = np.random.default_rng(3)
    points = rng.uniform([0.0, -0.05, -0.03], [1.0, 0.05, 0.03], size=(900, 3))
    mass = rng.uniform(0.2, 1.0, size=900)
    points -= [0.0, *(mass @ points[:, 1:] / mass.sum())]
    assert describe_motion(record(points, kinds(points), node_mass=mass)) == WORDS


def test_turning_the_body_takes_its_directions_along() -> None:
    quarter = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # x -> y -> z -> x
    turned = record(BEAM @ quarter.T, [shape @ quarter.T for shape in kinds(BEAM)])
    assert describe_motion(turned)[:4] == ("bending z", "bending x", "torsion", "axial")
    oblique, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turned = record(BEAM @ oblique.T + 7.0, [shape @ oblique.T for shape in kinds(BEAM)])
    assert describe_motion(turned)[:4] == ("bending", "bending", "torsion", "axial")


def test_scale_and_unit_of_length_do_not_matter() -> None:
    for factor in (1e-6, 1e4):
        shapes = [1e5 * shape for shape in kinds(BEAM * factor)]
        assert describe_motion(record(BEAM * factor, shapes)) == WORDS


def test_pairs_of_a_square_section_have_no_direction_unless_aligned() -> None:
    points = box(1.0, 0.1, 0.1, (40, 4, 4))
    angles = np.radians([0.0, 5.0, 30.0, 45.0, 88.0])
    shapes = [bending(points, np.cos(a) * Y + np.sin(a) * Z) for a in angles]
    expected = ("bending y", "bending y", "bending", "bending", "bending z")
    assert describe_motion(record(points, shapes)) == expected


def test_mixtures_are_not_named() -> None:
    a, b = bending(BEAM, Z), torsion(BEAM)
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    shares = [0.5, 0.7, 0.9]
    shapes = [np.sqrt(s) * a + np.sqrt(1.0 - s) * b for s in shares]
    assert describe_motion(record(BEAM, shapes))[:2] == ("", "")
    assert describe_motion(record(BEAM, shapes))[2].startswith("bending")


def test_distorted_sections_are_not_named() -> None:
    """Breathing and ovalling have no mean translation and no rotation."""
    x, y, z = BEAM.T
    wave = np.sin(np.pi * x)[:, None]
    breathing = np.stack([0 * x, y, z], axis=1) * wave
    ovalling = np.stack([0 * x, y, -z], axis=1) * wave
    noise = np.random.default_rng(8).normal(size=BEAM.shape)
    assert describe_motion(record(BEAM, [breathing, ovalling, noise])) == ("", "", "")


def test_prongs_that_swing_against_each_other_are_not_named() -> None:
    prong = box(1.0, 0.05, 0.05, (40, 2, 2))
    points = np.concatenate([prong + 0.08 * Y, prong - 0.08 * Y])
    swing = bending(prong, Y)
    assert describe_motion(record(points, [np.concatenate([swing, -swing])])) == ("",)


def test_rigid_motions_are_found_and_declared_ones_believed() -> None:
    shapes = rigid(BEAM)
    mixed = [sum((i + 1.0) * shape for i, shape in enumerate(shapes))]
    assert describe_motion(record(BEAM, shapes + mixed)) == ("rigid",) * 7
    assert describe_motion(record(BEAM, kinds(BEAM), rigid_modes=2))[:3] == (
        "rigid",
        "rigid",
        "torsion",
    )
    cube = box(1.0, 1.0, 1.0, (3, 3, 3))
    assert describe_motion(record(cube, rigid(cube))) == ("rigid",) * 6


def test_first_bending_of_a_clamped_beam_is_not_rigid() -> None:
    """The nearest there is: a straight line explains 0.98 of its energy."""
    shape, _ = cantilever(np.linspace(0.0, 1.0, 400))
    line = np.stack([np.ones(400), np.linspace(0.0, 1.0, 400)], axis=1)
    _, misfit, *_ = np.linalg.lstsq(line, shape)
    share = 1.0 - misfit[0] / (shape @ shape)
    assert 0.95 < share < RIGID_SHARE
    assert describe_motion(record(BEAM, [bending(BEAM, Z)])) == ("bending z",)


def test_gently_curved_beam_keeps_its_names() -> None:
    points = BEAM + np.outer(0.02 * np.sin(np.pi * BEAM[:, 0]), Z)
    shapes = [bending(BEAM, Y), torsion(BEAM), axial(BEAM)]
    assert describe_motion(record(points, shapes)) == ("bending y", "torsion", "axial")


def test_no_mass_or_no_motion_is_no_trouble() -> None:
    assert describe_motion(record(BEAM, kinds(BEAM), node_mass=np.zeros(len(BEAM)))) == ("",) * 7
    assert describe_motion(record(BEAM, [np.zeros_like(BEAM)])) == ("",)


def test_nodes_without_mass_may_lie_anywhere() -> None:
    points = np.vstack([BEAM, [[0.0, 500.0, -300.0]]])
    shapes = [np.vstack([shape, np.ones((1, 3))]) for shape in kinds(BEAM)]
    mass = np.append(np.full(len(BEAM), 1.0), 0.0)
    assert describe_motion(record(points, shapes, node_mass=mass)) == WORDS
