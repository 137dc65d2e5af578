import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.view.camera import View, good_view

Array = NDArray[np.float64]
RNG = np.random.default_rng(4)


def box(*size: float) -> Array:
    return RNG.uniform(-0.5, 0.5, size=(3000, 3)) * size


def inside(view: View, points: Array) -> bool:
    seen = (points - view.centre) @ np.stack([view.right, view.up]).T
    half = np.array([view.width, view.height]) / 2.0
    return bool((np.abs(seen) <= half * (1.0 + 1e-12)).all())


@pytest.mark.parametrize("size", [(10, 1, 1), (1, 10, 1), (1, 1, 10), (3, 3, 0.1), (1, 1, 1)])
def test_everything_is_in_the_picture_and_no_room_is_lost(size: tuple[float, ...]) -> None:
    points = box(*size)
    moved = np.stack([points + 0.3, points * 1.2])
    view = good_view(points, moved)
    assert inside(view, points)
    assert inside(view, moved.reshape(-1, 3))
    axes = np.stack([view.right, view.up, view.towards])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)  # not a mirror image
    smaller = View(
        right=view.right,
        up=view.up,
        towards=view.towards,
        centre=view.centre,
        width=0.999 * view.width,
        height=0.999 * view.height,
    )
    assert not inside(smaller, np.concatenate([points, *moved]))


@pytest.mark.parametrize("size", [(10, 1, 1), (1, 10, 1), (3, 3, 0.1), (1, 1, 1), (1, 1.5, 9)])
def test_bodies_along_the_axes_stand_upright_and_show_three_sides(size: tuple[float, ...]) -> None:
    points = box(*size)
    view = good_view(points, points)
    assert view.up[2] > 0.8
    assert abs(view.right[2]) < 1e-12
    assert (np.abs(view.towards) > 0.2).all()


def test_long_bodies_lie_along_the_picture_however_they_are_turned() -> None:
    for _ in range(20):
        turn, _ = np.linalg.qr(RNG.normal(size=(3, 3)))
        view = good_view(box(12, 1, 1) @ turn.T, box(12, 1, 1) @ turn.T)
        assert max(view.width / view.height, view.height / view.width) > 2.0
    turn, _ = np.linalg.qr(np.array([[1.0, 0.3, 0.2], [1.0, -0.5, 0.1], [1.0, 0.4, -0.9]]))
    view = good_view(box(12, 1, 0.8) @ turn.T, box(12, 1, 0.8) @ turn.T)
    assert view.width / view.height > 2.5


def test_plates_are_seen_from_above_their_broad_side() -> None:
    plate = box(4, 3, 0.05)
    assert 0.35 < abs(good_view(plate, plate).towards[2]) < 0.8
    wall = plate[:, [0, 2, 1]]
    assert abs(good_view(wall, wall).towards[1]) > 0.5
