"""Static formulas against the unit-load theorem, reciprocity and limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fenics_defo.beams import (
    BeamError,
    CircularSection,
    RectangularSection,
    axial_elongation,
    bending_roots,
    buckling_load,
    cantilever_tip,
    midspan_deflection,
    twist_angle,
)
from fenics_defo.errors import MaterialError

BEAM = {
    "length": 0.8,
    "section": RectangularSection(0.05, 0.09),
    "young": 7.0e10,
    "poisson": 0.33,
}
LOADS = {"force": 130.0, "moment": -45.0, "line_load": 210.0}
EI = 7.0e10 * BEAM["section"].second_moment_y
GA = BEAM["section"].shear_coefficient(0.33) * 7.0e10 / 2.66 * BEAM["section"].area
X, W = np.polynomial.legendre.leggauss(8)


def along(start, stop):
    return 0.5 * (stop - start) * X + 0.5 * (start + stop), 0.5 * (stop - start) * W


def test_cantilever_tip_obeys_the_unit_load_theorem():
    length = BEAM["length"]
    x, w = along(0.0, length)
    shear = LOADS["force"] + LOADS["line_load"] * (length - x)
    moment = (
        LOADS["force"] * (length - x)
        + LOADS["moment"]
        + 0.5 * LOADS["line_load"] * (length - x) ** 2
    )
    tip = cantilever_tip(**BEAM, **LOADS)
    assert tip.deflection == pytest.approx(w @ (moment * (length - x) / EI + shear / GA))
    assert tip.rotation == pytest.approx(w @ (moment / EI))
    slender = cantilever_tip(**BEAM, **LOADS, theory="euler-bernoulli")
    assert slender.deflection == pytest.approx(w @ (moment * (length - x) / EI))
    assert slender.rotation == tip.rotation


def test_maxwell_reciprocity():
    by_force = cantilever_tip(**BEAM, force=1.0)
    by_moment = cantilever_tip(**BEAM, moment=1.0)
    assert by_force.rotation == pytest.approx(by_moment.deflection, rel=1e-14)


@given(scale=st.floats(1e-3, 1e3) | st.floats(-1e3, -1e-3))
def test_loads_superpose(scale):
    parts = [cantilever_tip(**BEAM, **{name: scale * load}) for name, load in LOADS.items()]
    whole = cantilever_tip(**BEAM, **{name: scale * load for name, load in LOADS.items()})
    total = sum(abs(part.deflection) for part in parts)
    assert whole.deflection == pytest.approx(
        sum(part.deflection for part in parts), abs=1e-14 * total
    )


@pytest.mark.parametrize("supports", ["pinned-pinned", "clamped-clamped"])
def test_midspan_obeys_the_unit_load_theorem(supports):
    length, half = BEAM["length"], 0.5 * BEAM["length"]
    force, load = 130.0, 210.0
    x, w = along(0.0, half)
    moment = 0.5 * force * x + 0.5 * load * x * (length - x)
    unit = 0.5 * x
    if supports == "clamped-clamped":
        # The end couples keep the end slopes, hence the integrals of both moments, at zero.
        moment = moment - (w @ moment) / half
        unit = unit - (w @ unit) / half
    shear = 0.5 * force + load * (half - x)
    expected = 2.0 * w @ (moment * unit / EI + 0.5 * shear / GA)
    found = midspan_deflection(**BEAM, supports=supports, force=force, line_load=load)
    assert found == pytest.approx(expected, rel=1e-12)
    slender = midspan_deflection(
        **BEAM, supports=supports, force=force, line_load=load, theory="euler-bernoulli"
    )
    assert slender == pytest.approx(2.0 * w @ (moment * unit / EI), rel=1e-12)


def test_two_half_cantilevers_make_a_clamped_beam():
    # By symmetry the middle section does not turn: each half is a cantilever of length L/2 with
    # F/2 at its tip and a couple that undoes the rotation.
    half = {**BEAM, "length": 0.5 * BEAM["length"]}
    couple = (
        -cantilever_tip(**half, force=50.0).rotation / cantilever_tip(**half, moment=1).rotation
    )
    tip = cantilever_tip(**half, force=50.0, moment=couple)
    whole = midspan_deflection(**BEAM, supports="clamped-clamped", force=100.0)
    assert tip.deflection == pytest.approx(whole, rel=1e-13)


def test_direction_picks_the_second_moment():
    options = {"force": 1.0, "theory": "euler-bernoulli"}
    ratio = (
        cantilever_tip(**BEAM, **options, direction="y").deflection
        / cantilever_tip(**BEAM, **options, direction="z").deflection
    )
    assert ratio == pytest.approx((0.09 / 0.05) ** 2)


def test_extension_and_twist_of_a_round_bar():
    rod = {"length": 2.0, "section": CircularSection(0.01), "young": 2e11}
    assert axial_elongation(**rod, force=1e4) == pytest.approx(1e4 * 2.0 / (2e11 * np.pi * 1e-4))
    # Twist from the energy of the linear shear strain over the disc.
    radius, w = along(0.0, 0.01)
    torque_per_twist = 2e11 / 2.6 * (2.0 * np.pi * w @ radius**3) / 2.0
    assert twist_angle(**rod, poisson=0.3, torque=5.0) == pytest.approx(5.0 / torque_per_twist)


def test_buckling_loads():
    column = {"length": 3.0, "section": RectangularSection(0.05, 0.03), "young": 2e11}
    weak = 2e11 * column["section"].second_moment_y
    loads = {
        supports: buckling_load(**column, supports=supports)
        for supports in ("clamped-free", "pinned-pinned", "clamped-pinned", "clamped-clamped")
    }
    assert loads["pinned-pinned"] == pytest.approx(weak * (np.pi / 3.0) ** 2)
    assert loads["clamped-free"] == pytest.approx(loads["pinned-pinned"] / 4.0)
    assert loads["clamped-clamped"] == pytest.approx(loads["pinned-pinned"] * 4.0)
    root = 3.0 * np.sqrt(loads["clamped-pinned"] / weak)
    assert np.sin(root) == pytest.approx(root * np.cos(root), abs=1e-12)
    assert root == pytest.approx(4.4934, abs=1e-4)  # Timoshenko and Gere, chapter 2
    # A pinned column's load and frequency share one sine shape.
    assert root > bending_roots(1, supports="clamped-pinned")[0]
    strong = buckling_load(**column, direction="y")
    assert strong == pytest.approx(buckling_load(**column) * (5.0 / 3.0) ** 2)


def test_refusals():
    with pytest.raises(BeamError, match="force must be a finite number"):
        cantilever_tip(**BEAM, force=float("nan"))
    with pytest.raises(BeamError, match="supports must be one of pinned-pinned, clamped-clamped"):
        midspan_deflection(**BEAM, supports="clamped-free", force=1.0)
    with pytest.raises(BeamError, match="direction must be one of y, z"):
        buckling_load(length=1.0, section=CircularSection(1.0), young=1.0, direction="x")
    with pytest.raises(BeamError, match="length"):
        axial_elongation(length=-1.0, section=CircularSection(1.0), young=1.0, force=1.0)
    with pytest.raises(MaterialError, match="poisson"):
        twist_angle(length=1.0, section=CircularSection(1.0), young=1.0, poisson=0.5, torque=1.0)
