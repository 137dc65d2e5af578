"""The Taylor law is the series of any energy about rest, and its range is measured."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import ufl
from ufl.core.expr import Expr

from fenics_defo.energy import (
    Corotational,
    HyperelasticEnergy,
    Invertible,
    LinearElastic,
    MassSpring,
    MooneyRivlin,
    NeoHookean,
    StVenantKirchhoff,
    right_cauchy_green,
)
from fenics_defo.errors import DefoError, MaterialError
from fenics_defo.reduction import (
    DirectForce,
    measure_range,
    tabulate_cubic,
    tabulate_linear,
    taylor_force,
)
from tests.unit.fem.fem_bodies import MODULI
from tests.unit.reduction.tabulated_bodies import (
    ELEMENTS,
    SOFT,
    bent_body,
    coordinates,
    relative,
    smooth_shapes,
)

NEO = NeoHookean(**MODULI)


def fibres(F: Expr, c: Mapping[str, Expr]) -> Expr:
    """Neo-Hookean with stiff fibres along x, of an exponential energy."""
    stretch = right_cauchy_green(F)[0, 0] - 1
    return NEO.strain_energy(F, c) + c["k"] * (ufl.exp(2 * stretch**2) - 1)


FIBRES = HyperelasticEnergy(fibres, {**NEO.parameters, "k": 4.0e4}, density=1.2e3)
SMOOTH: dict[str, Any] = {
    "neo-hookean": NEO,
    "mooney-rivlin": MooneyRivlin(c10=2e4, c01=5e3, bulk=9e4, density=1.2e3),
    "fibres": FIBRES,
    "invertible": Invertible(NEO, tangent="exact"),
    "two laws": {None: NEO, "x>0.7": LinearElastic(**MODULI)},
    "field": NeoHookean(young=np.geomspace(1e4, 1e6, 48), poisson=0.3, density=1e3),
}


@pytest.mark.parametrize("element", ELEMENTS[:4])
def test_of_st_venant_kirchhoff_it_is_the_exact_law(element: tuple[str, int, int]) -> None:
    """Two ways to the same coefficients: UFL's fourth derivatives, and the Gram matrix."""
    solid = bent_body(element=element)
    shapes = smooth_shapes(solid, 6)
    exact, taylor = tabulate_cubic(solid, shapes), taylor_force(solid, shapes)
    assert taylor.kind == "taylor"
    assert relative([taylor.linear], exact.linear[None]) < 1e-14
    assert relative([taylor.quadratic], exact.quadratic[None]) < 1e-14
    assert relative([taylor.cubic], exact.cubic[None]) < 1e-14


@pytest.mark.parametrize("law", SMOOTH.values(), ids=SMOOTH.keys())
def test_what_it_lacks_is_of_fourth_order(law: Any) -> None:
    solid = bent_body(law)
    shapes = smooth_shapes(solid, 4)
    taylor, direct = taylor_force(solid, shapes), DirectForce(solid, shapes)
    (q,) = coordinates(shapes, 1.0, 1)
    sizes = np.array([0.02, 0.01])
    for measure, order in (("energy", 5.0), ("force", 4.0), ("stiffness", 3.0)):
        coarse, fine = (
            np.linalg.norm(getattr(taylor, measure)(size * q) - getattr(direct, measure)(size * q))
            for size in sizes
        )
        assert np.log2(coarse / fine) == pytest.approx(order, abs=0.25)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (Corotational(**MODULI), "needs an energy in UFL, which Corotational does not have"),
        (MassSpring(young=1e5, density=1e3), "which MassSpring does not have"),
        (
            HyperelasticEnergy(lambda F, c: c["k"] * ufl.inner(F, F), {"k": 1e5}, density=1e3),
            "HyperelasticEnergy is stressed at rest",
        ),
        (
            HyperelasticEnergy(
                lambda F, c: SOFT.strain_energy(F, c) + c["mu"] * abs(ufl.tr(F) - 3) ** 3.5,
                SOFT.parameters,
                density=1e3,
            ),
            "HyperelasticEnergy has no finite derivatives up to the fourth",
        ),
    ],
)
def test_what_has_no_series_is_refused(law: Any, words: str) -> None:
    solid = bent_body(law)
    with pytest.raises(MaterialError, match=words):
        taylor_force(solid, smooth_shapes(solid, 2))


def test_the_range_of_an_exact_law_has_no_end() -> None:
    solid = bent_body()
    shapes = smooth_shapes(solid, 3)
    found = measure_range(solid, tabulate_cubic(solid, shapes), shapes, tolerance=1e-10, rays=2)
    assert found.directions.shape == (4, 3)
    assert found.reach == found.amplitudes[-1]
    size = np.ptp(solid.points, axis=0).max()
    assert found.reach == pytest.approx(0.5 * size)
    for q in found.directions:
        farthest = np.linalg.norm(np.tensordot(q, shapes, 1), axis=1).max()
        assert farthest == pytest.approx(1.0)


def test_the_range_ends_where_the_error_passes_the_tolerance() -> None:
    solid = bent_body(NEO)
    shapes = smooth_shapes(solid, 3)
    laws = {
        "linear": tabulate_linear(solid, shapes),
        "taylor": taylor_force(solid, shapes),
    }
    reach = {}
    for name, law in laws.items():
        found = measure_range(solid, law, shapes, tolerance=0.02, rays=3)
        within = found.amplitudes <= found.reach
        assert (found.errors[:, within] <= 0.02).all()
        (beyond,) = found.errors[:, np.flatnonzero(~within)[:1]].T
        assert np.nanmax(beyond) > 0.02
        reach[name] = found.reach
        told = json.loads(json.dumps(found.certificate(), allow_nan=False))
        assert told["reach_m"] == found.reach
        assert len(told["largest_errors"]) == within.sum()
    assert reach["taylor"] > 5.0 * reach["linear"] > 0.0
    # The wider the tolerance, the farther: errors of the linear law are of first order.
    wide = measure_range(solid, laws["linear"], shapes, tolerance=0.04, rays=3).reach
    assert 1.4 < wide / reach["linear"] < 2.9


def test_errors_do_not_depend_on_the_unit_of_a_coordinate() -> None:
    solid = bent_body(NEO)
    shapes = smooth_shapes(solid, 1)
    one, other = (
        measure_range(solid, taylor_force(solid, scale * shapes), scale * shapes, rays=1)
        for scale in (1.0, 7.0)
    )
    np.testing.assert_allclose(other.errors, one.errors, rtol=1e-6, atol=1e-11)
    assert other.reach == one.reach > 0.0


@pytest.mark.parametrize("options", [{"tolerance": 0.0}, {"tolerance": float("nan")}, {"rays": 0}])
def test_settings_of_the_measurement_are_checked(options: Mapping[str, Any]) -> None:
    solid = bent_body(StVenantKirchhoff(**MODULI))
    shapes = smooth_shapes(solid, 1)
    with pytest.raises(DefoError, match=next(iter(options))):
        measure_range(solid, tabulate_linear(solid, shapes), shapes, **options)
