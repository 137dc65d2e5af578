from collections.abc import Callable

import numpy as np
import pytest

from fenics_defo.runtime import Modes
from fenics_defo.view.captions import caption, field_names, frequency_text, omissions

Box = Callable[..., Modes]


@pytest.mark.parametrize(
    ("frequency", "text"),
    [
        (440.2345, "440.2"),
        (0.0123456, "0.01235"),
        (1.0, "1.000"),
        (1234567.8, "1234568"),
        (0.0, "0"),
        (1e-9, "0"),
    ],
)
def test_frequencies_have_four_digits_and_no_exponent(frequency: float, text: str) -> None:
    assert frequency_text(frequency) == text


@pytest.mark.parametrize("frequency", np.geomspace(1e-5, 1e7, 60))
def test_text_is_the_frequency_to_four_digits(frequency: float) -> None:
    assert float(frequency_text(frequency)) == pytest.approx(frequency, rel=6e-4)


def test_captions(box_modes: Box) -> None:
    modes = box_modes("tetra", [np.ones_like] * 2, frequencies=[1e-5, 440.2], rigid_modes=1)
    assert caption(modes, 0, "rigid") == "1 · rigid"
    assert caption(modes, 1, "bending y") == "2 · 440.2 Hz · bending y"
    assert caption(modes, 1) == "2 · 440.2 Hz"


def test_field_names_are_unique_and_sort_in_order(box_modes: Box) -> None:
    frequencies = np.sort(np.concatenate([[0.0], np.full(60, 99.96), np.geomspace(1, 1e6, 50)]))
    modes = box_modes("tetra", [np.ones_like] * 111, frequencies=frequencies, rigid_modes=1)
    names = field_names(modes)
    assert names[0] == "mode_001_rigid"
    assert "mode_030_99.96Hz" in names
    assert len(set(names)) == 111
    assert sorted(names) == list(names)
    assert field_names(modes.select([5]))[0].startswith("mode_01_")


def test_omissions() -> None:
    assert omissions(0, 0) == ""
    assert omissions(6, 0) == "6 rigid modes not shown"
    assert omissions(1, 1) == "1 rigid mode and 1 higher mode not shown"
