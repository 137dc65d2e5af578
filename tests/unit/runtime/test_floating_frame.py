"""The record of a floating frame."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mass_clouds import cloud

from fenics_defo.runtime import read_archive, write_archive
from fenics_defo.runtime.floating import FloatingFrame


def test_inertia_at_rest() -> None:
    body = cloud()
    arm = body.points - body.frame.centre
    square = (arm**2).sum(axis=1)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None]
    inertia = np.tensordot(body.masses, square, 1)
    assert body.frame.inertia == pytest.approx(inertia, rel=1e-13)
    assert body.frame.size == 4


def test_axis_defect() -> None:
    """None for mean axes, all for a shape that is a rotation, between for others."""
    assert cloud().frame.axis_defect < 1e-14
    assert 0.01 < cloud(tisserand=False).frame.axis_defect < 1.0
    body = cloud(1)
    turn = np.cross([0.2, -0.5, 0.4], body.points - body.frame.centre)
    assert replace(body, shapes=turn[..., None]).frame.axis_defect == pytest.approx(1.0, rel=1e-12)


def test_there_and_back_through_a_file(tmp_path: Path) -> None:
    frame, path = cloud(tisserand=False).frame, tmp_path / "frame.npz"
    write_archive(path, frame.arrays(), kind="frame", version=1, units=FloatingFrame.UNITS)
    arrays = read_archive(path, kind="frame", version=1, required=FloatingFrame.ARRAYS)
    again = FloatingFrame.from_arrays(arrays)
    for name, array in frame.arrays().items():
        assert np.array_equal(array, again.arrays()[name]), name
    assert set(FloatingFrame.UNITS) == set(FloatingFrame.ARRAYS) == set(frame.arrays())


def test_arrays_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        cloud().frame.linear[0, 0, 0] = 1.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": 0.0}, "mass of a floating frame must be positive"),
        ({"mass": np.nan}, "mass of a floating frame must be positive"),
        ({"centre": np.zeros(2)}, "centre has the shape"),
        ({"linear": np.zeros((3, 3, 3))}, "linear has the shape"),
        ({"mean": np.zeros(3)}, "mean has the shape"),
        ({"linear": np.full((3, 3, 4), np.inf)}, "not finite"),
        ({"second_moment": np.diag([1.0, 0.0, 0.0])}, "not positive definite"),
        ({"second_moment": np.triu(np.ones((3, 3)))}, "not symmetric"),
        ({"quadratic": np.arange(96.0).reshape(6, 4, 4)}, "not symmetric"),
    ],
)
def test_what_does_not_fit_is_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        replace(cloud().frame, **change)
