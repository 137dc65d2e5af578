"""Beams and bars of several segments."""

import itertools

import numpy as np
import pytest
from beam_models import hermite_frequencies
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_defo.beams import (
    BeamError,
    CircularSection,
    RectangularSection,
    Segment,
    axial_frequencies,
    euler_bernoulli_frequencies,
    stepped_axial_frequencies,
    stepped_bending_frequencies,
    stepped_torsional_frequencies,
    timoshenko_frequencies,
    torsional_frequencies,
)
from fenics_defo.beams.stepped import beam_piece
from fenics_defo.beams.supports import beam_supports
from fenics_defo.errors import MaterialError

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7800.0}
RUBBER = {"young": 5.0e8, "poisson": 0.45, "density": 1100.0}
BOX, ROD = RectangularSection(0.05, 0.04), CircularSection(0.02)
WORDS = ("clamped", "pinned", "sliding", "free")
SUPPORTS = ["-".join(pair) for pair in itertools.product(WORDS, repeat=2)]


def cut(*lengths, section=BOX, **material):
    return [Segment(length=x, section=section, **(material or STEEL)) for x in lengths]


@pytest.mark.parametrize("supports", SUPPORTS)
def test_equal_segments_are_the_uniform_euler_bernoulli_beam(supports):
    found = stepped_bending_frequencies(
        cut(0.5, 0.5), count=12, supports=supports, theory="euler-bernoulli"
    )
    whole = euler_bernoulli_frequencies(
        length=1.0, section=BOX, young=2.1e11, density=7800.0, count=12, supports=supports
    )
    np.testing.assert_allclose(found, whole, rtol=2e-9)


@pytest.mark.parametrize("supports", ["clamped-free", "pinned-pinned", "free-free"])
def test_equal_segments_are_the_uniform_timoshenko_beam(supports):
    found = stepped_bending_frequencies(cut(0.07, 0.2, 0.03), count=12, supports=supports)
    whole = timoshenko_frequencies(length=0.3, section=BOX, **STEEL, count=12, supports=supports)
    np.testing.assert_allclose(found, whole, rtol=1e-9)


@pytest.mark.parametrize("ends", ["fixed-free", "fixed-fixed", "free-free", "free-fixed"])
def test_equal_segments_are_the_uniform_bar(ends):
    bar = cut(0.2, 0.5, 0.3)
    whole = {"length": 1.0, "young": 2.1e11, "density": 7800.0, "count": 9, "ends": ends}
    np.testing.assert_allclose(
        stepped_axial_frequencies(bar, count=9, ends=ends), axial_frequencies(**whole), rtol=1e-9
    )
    np.testing.assert_allclose(
        stepped_torsional_frequencies(bar, count=9, ends=ends),
        torsional_frequencies(**whole, section=BOX, poisson=0.3),
        rtol=1e-9,
    )


def test_two_material_bar_satisfies_the_classical_equation():
    # Fixed-free: Z1 cot(w l1 / c1) = Z2 tan(w l2 / c2), Z = A sqrt(E rho).
    bar = [
        Segment(length=0.6, section=BOX, **STEEL),
        Segment(length=0.4, section=ROD, **RUBBER),
    ]
    omega = 2.0 * np.pi * stepped_axial_frequencies(bar, count=8)
    phases = [omega * s.length * np.sqrt(s.density / s.young) for s in bar]
    impedances = [s.section.area * np.sqrt(s.density * s.young) for s in bar]
    one, two = phases
    residual = impedances[0] * np.cos(one) * np.cos(two) - impedances[1] * np.sin(one) * np.sin(two)
    np.testing.assert_allclose(residual / sum(impedances), 0.0, atol=1e-12)
    # None is missing: the residual changes sign eight times up to the eighth root.
    grid = np.linspace(0.0, omega[-1] * 1.0001, 20001)
    one, two = (s.length * np.sqrt(s.density / s.young) * grid for s in bar)
    values = impedances[0] * np.cos(one) * np.cos(two) - impedances[1] * np.sin(one) * np.sin(two)
    assert np.count_nonzero(np.diff(np.sign(values))) == 8


@pytest.mark.parametrize("supports", SUPPORTS)
def test_two_material_beam_agrees_with_cubic_elements(supports):
    beam = [
        Segment(length=0.7, section=BOX, **STEEL),
        Segment(length=0.3, section=ROD, **RUBBER),
    ]
    options = {"direction": "y", "theory": "euler-bernoulli"}
    found = stepped_bending_frequencies(beam, count=6, supports=supports, **options)
    pieces = [beam_piece(segment, shear="cowper", **options) for segment in beam]
    ends = beam_supports(supports)
    coarse, fine = (
        hermite_frequencies(pieces, ends.held, elements=n)[ends.rigid :][:6] for n in (8, 16)
    )
    # Conforming elements lie above and converge with order four.
    assert np.all(coarse > found * (1.0 - 1e-7))
    np.testing.assert_allclose(fine, found, rtol=3e-4)
    # Round-off in the elements' lowest frequencies hides their order.
    orders = np.log2((coarse - found)[2:] / (fine - found)[2:])
    np.testing.assert_allclose(orders, 4.0, atol=0.3)


@settings(max_examples=8, deadline=None)
@given(
    lengths=st.lists(st.floats(0.05, 1.0), min_size=2, max_size=4),
    supports=st.sampled_from(SUPPORTS),
    theory=st.sampled_from(["euler-bernoulli", "timoshenko"]),
)
def test_a_beam_turned_round_has_the_same_frequencies(lengths, supports, theory):
    kinds = itertools.cycle([(BOX, STEEL), (ROD, RUBBER), (ROD, STEEL)])
    beam = [Segment(length=x, section=s, **m) for x, (s, m) in zip(lengths, kinds, strict=False)]
    turned = "-".join(reversed(supports.split("-")))
    there = stepped_bending_frequencies(beam, count=5, supports=supports, theory=theory)
    back = stepped_bending_frequencies(beam[::-1], count=5, supports=turned, theory=theory)
    assert np.all(np.diff(there) >= 0.0)
    np.testing.assert_allclose(there, back, rtol=1e-7)


def test_a_short_heavy_end_is_a_tip_mass():
    head = Segment(length=1e-4, section=ROD, young=1e16, poisson=0.3, density=1e9)
    mass = head.density * head.section.area * head.length
    rod = Segment(length=1.0, section=ROD, young=2.1e11, poisson=0.3, density=1e-3)
    found = stepped_bending_frequencies([rod, head], count=1, theory="euler-bernoulli")[0]
    spring = 3.0 * rod.young * ROD.second_moment_y
    assert found == pytest.approx(np.sqrt(spring / mass) / (2.0 * np.pi), rel=1e-3)


def test_stiffening_one_segment_raises_every_frequency():
    soft = stepped_bending_frequencies(cut(0.5, 0.5), count=8)
    harder = {**STEEL, "young": 4.2e11}
    stiff = stepped_bending_frequencies([*cut(0.5), *cut(0.5, **harder)], count=8)
    assert np.all(stiff > soft)
    assert np.all(stiff < np.sqrt(2.0) * soft)


def test_refusals():
    with pytest.raises(BeamError, match="at least one Segment"):
        stepped_axial_frequencies([], count=1)
    with pytest.raises(BeamError, match="euler-bernoulli, timoshenko"):
        stepped_bending_frequencies(cut(1.0), count=1, theory="rayleigh")
    with pytest.raises(BeamError, match="length"):
        cut(float("nan"))
    with pytest.raises(MaterialError, match="density"):
        Segment(length=1.0, section=BOX, young=1.0, poisson=0.0, density=0.0)
