"""Numbers and tables as people read them."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.cli.modes_table import table_lines
from fenics_defo.cli.number_text import constants_text, period_text, short_number, six_digits
from fenics_defo.runtime import Modes

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


@given(st.floats(1e-12, 1e12))
def test_six_digits_are_six(value: float) -> None:
    text = six_digits(value)
    assert float(text) == pytest.approx(value, rel=5.1e-6)
    digits = re.sub(r"e.*|\.", "", text).lstrip("0")
    assert len(digits) in (6, 7)  # seven before the point are all written
    assert len(text) <= 13


@given(st.floats(1e-8, 1e4))
def test_periods_have_four_digits_and_a_unit_that_suits(value: float) -> None:
    number, unit = period_text(value).split()
    assert float(number) * UNITS[unit] == pytest.approx(value, rel=5.1e-4)
    assert len(number.replace(".", "").lstrip("0")) in (4, 5)
    assert float(number) >= 1.0
    assert unit == "s" or float(number) < 1000.0


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (440.0, "440.000"), (999.9996, "1000.00"), (0.0123456789, "0.0123457")],
)
def test_frequencies(value: float, text: str) -> None:
    assert six_digits(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(2.1e11, "2.1e11"), (7850.0, "7850"), (0.3, "0.3"), (1e-9, "1e-9")]
)
def test_short_numbers(value: float, text: str) -> None:
    assert short_number(value) == text


def test_constants_have_units_and_say_what_was_assumed() -> None:
    text = constants_text({"c10": 1e5, "poisson": 0.3, "density": 1000.0}, assumed={"density"})
    assert text == "c10 100000 Pa, poisson 0.3, density 1000 kg/m3 (default)"


@pytest.fixture
def modes() -> Modes:
    shares = np.array([[1.0, 0, 0, 0, 0, 0], [0, 0.25, 4e-4, 0, 0, 0.996]])
    return Modes(
        frequencies=np.array([0.0, 12345.678]),
        shapes=np.ones((2, 4, 3)),
        points=np.eye(4, 3),
        cells=np.array([[0, 1, 2, 3]]),
        cell_type="tetra",
        node_numbers=np.arange(1, 5),
        node_mass=np.ones(4),
        residuals=np.zeros(2),
        rigid_modes=1,
        complete=True,
        participation=np.sqrt(2.0 * shares),
        total_mass=2.0,
        centre=np.zeros(3),
        inertia=np.full(6, 2.0),
    )


def test_rows(modes: Modes) -> None:
    lines = table_lines(modes, ("rigid", "bending y"))
    assert [line.split() for line in lines[2:]] == [
        ["1", "0", "-", "rigid", "100.0", "-", "-", "-", "-", "-"],
        ["2", "12345.7", "81.00", "us", "bending", "y", "-", "25.0", "-", "-", "-", "99.6"],
        ["sum", "100.0", "25.0", "-", "-", "-", "99.6"],
    ]
    assert max(map(len, lines)) < 80
    ends = {len(line) for line in lines[1:]}
    assert len(ends) == 1, "the columns do not end together"


def test_no_word_for_the_motion_no_column(modes: Modes) -> None:
    assert "motion" not in "".join(table_lines(modes, ("", "")))


def test_style_changes_no_column(modes: Modes) -> None:
    words = ("rigid", "bending y")
    styled = table_lines(modes, words, style=True)
    assert any("\x1b[2m" in line for line in styled)
    plain = [re.sub(r"\x1b\[\d*m", "", line).rstrip() for line in styled]
    assert plain == table_lines(modes, words)
