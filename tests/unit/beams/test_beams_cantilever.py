"""The cantilever's merged frequencies and its spectrum by kind."""

import numpy as np
import pytest

from fenics_defo import beams

STEEL = {"young": 2.1e11, "poisson": 0.3, "density": 7800.0}
BEAM = {"length": 0.5, "section": beams.RectangularSection(0.05, 0.04), **STEEL}


@pytest.mark.parametrize("theory", ["timoshenko", "euler-bernoulli"])
def test_frequencies_are_those_of_both_planes(theory):
    found = beams.cantilever_frequencies(**BEAM, count=7, theory=theory)
    spectrum = beams.cantilever_spectrum(**BEAM, count=7, theory=theory)
    assert found.shape == (7,)
    assert np.all(np.diff(found) > 0.0)
    planes = np.concatenate([spectrum.bending_y, spectrum.bending_z])
    assert np.isin(found, planes).all()
    assert np.count_nonzero(planes < found[-1]) == 6


def test_spectrum_agrees_with_the_functions_of_each_kind():
    spectrum = beams.cantilever_spectrum(**BEAM, count=4, shear=0.8)
    for direction in ("y", "z"):
        np.testing.assert_allclose(
            getattr(spectrum, f"bending_{direction}"),
            beams.timoshenko_frequencies(**BEAM, count=4, direction=direction, shear=0.8),
            rtol=1e-13,
        )
    np.testing.assert_allclose(
        spectrum.torsion, beams.torsional_frequencies(**BEAM, count=4), rtol=1e-12
    )
    axial = beams.axial_frequencies(length=0.5, young=2.1e11, density=7800.0, count=4)
    np.testing.assert_allclose(spectrum.axial, axial, rtol=1e-12)


def test_lowest_names_each_kind_and_misses_none():
    spectrum = beams.cantilever_spectrum(**BEAM, count=10)
    frequencies, kinds = spectrum.lowest()
    assert frequencies.shape == (10,)
    assert kinds[:2] == ("bending_z", "bending_y")  # the lower side bends first
    assert set(kinds) == {"bending_y", "bending_z", "torsion", "axial"}
    for kind in set(kinds):
        own = [f for f, k in zip(frequencies, kinds, strict=True) if k == kind]
        np.testing.assert_array_equal(own, getattr(spectrum, kind)[: len(own)])
        assert np.all(getattr(spectrum, kind)[len(own) :] >= frequencies[-1])


def test_a_square_section_has_every_bending_frequency_twice():
    square = {**BEAM, "section": beams.RectangularSection(0.04, 0.04)}
    pairs = beams.cantilever_frequencies(**square, count=8).reshape(4, 2)
    np.testing.assert_array_equal(pairs[:, 0], pairs[:, 1])


def test_thompson_table_value_of_the_slender_cantilever():
    # (beta L)^2 = 3.5160 for the first mode (Thomson, Theory of Vibration, appendix D).
    first = beams.cantilever_frequencies(**BEAM, count=1, theory="euler-bernoulli")[0]
    section = BEAM["section"]
    unit = np.sqrt(2.1e11 * section.second_moment_y / (7800.0 * section.area)) / 0.5**2
    assert 2.0 * np.pi * first / unit == pytest.approx(3.5160, abs=5e-5)


def test_refusals_name_the_argument():
    with pytest.raises(beams.BeamError, match="theory"):
        beams.cantilever_frequencies(**BEAM, count=1, theory="bernoulli")
    with pytest.raises(beams.BeamError, match="count"):
        beams.cantilever_spectrum(**BEAM, count=0)
