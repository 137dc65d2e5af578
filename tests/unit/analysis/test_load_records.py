"""Histories, loads, prescribed motions and initial states as records."""

import math

import numpy as np
import pytest
from moving_bodies import bar

from fenics_defo import analysis
from fenics_defo.analysis import (
    Gravity,
    Impulse,
    Initial,
    PointLoad,
    Prescribed,
    Pressure,
    Pulse,
    Ramp,
    Sine,
    Step,
    Table,
    Traction,
)
from fenics_defo.errors import DefoError, LoadError

NAN, INF = math.nan, math.inf


def test_every_public_name_is_there():
    for name in analysis.__all__:
        assert getattr(analysis, name) is not None


@pytest.mark.parametrize(
    ("history", "values"),
    [
        (Step(), {-1e-9: 0.0, 0.0: 1.0, 5.0: 1.0}),
        (Step(start=2.0), {1.999: 0.0, 2.0: 1.0}),
        (Ramp(2.0, start=1.0), {0.0: 0.0, 1.0: 0.0, 1.5: 0.25, 3.0: 1.0, 9.0: 1.0}),
        (Sine(0.5), {0.0: 0.0, 0.5: 1.0, 1.0: 0.0, 1.5: -1.0}),
        (Sine(1.0, phase=math.pi / 2), {0.0: 1.0, 0.5: -1.0}),
        (Pulse(1.0, 0.5), {0.99: 0.0, 1.0: 1.0, 1.49: 1.0, 1.5: 0.0}),
        (Table([0.0, 1.0, 3.0], [1.0, 2.0, 0.0]), {-1.0: 1.0, 0.5: 1.5, 1.0: 2.0, 2.0: 1.0, 4: 0}),
        (Table([1.0], [3.0]), {0.0: 3.0, 2.0: 3.0}),
    ],
)
def test_histories(history, values):
    for time, value in values.items():
        assert history(time) == pytest.approx(value, abs=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Step(start=NAN), "start of Step"),
        (lambda: Ramp(0.0), "duration of Ramp must be positive"),
        (lambda: Ramp(-1.0), "positive"),
        (lambda: Ramp(NAN), "finite"),
        (lambda: Sine(0.0), "frequency of Sine"),
        (lambda: Pulse(0.0, INF), "duration of Pulse"),
        (lambda: Table([], []), "at least one"),
        (lambda: Table([0.0, 1.0], [1.0]), "as many times as values"),
        (lambda: Table([0.0, 0.0], [1.0, 2.0]), "must ascend"),
        (lambda: Table([0.0, 1.0], [1.0, NAN]), "values of Table"),
        (lambda: Gravity((0.0, 1.0)), "three finite numbers"),
        (lambda: Gravity((0.0, 0.0, NAN)), "three finite numbers"),
        (lambda: Gravity("down"), "three finite numbers"),
        (lambda: Traction("x==1", (1.0, 2.0, INF)), "Traction"),
        (lambda: Traction("x==1", (1.0, 2.0, 3.0), history=1.0), "history of Traction"),
        (lambda: Pressure("x==1", NAN), "value of Pressure"),
        (lambda: PointLoad(vector=(1.0, 0.0, 0.0)), "exactly one of 'point' and 'node', got none"),
        (lambda: PointLoad(point=(0, 0, 0), node=1, vector=(1, 0, 0)), "got point and node"),
        (lambda: PointLoad(point=(0, 0), vector=(1, 0, 0)), "point of PointLoad"),
        (lambda: Impulse(region="x==1", vector=(1, 0, 0), time=-1.0), "0 or later"),
        (lambda: Impulse(vector=(1, 0, 0)), "exactly one"),
        (lambda: Prescribed("x==1", (None, None, None)), "one number at least"),
        (lambda: Prescribed("x==1", (1.0, None)), "three entries"),
        (lambda: Prescribed("x==1", (1.0, None, NAN)), "three finite numbers"),
        (lambda: Prescribed("x==1", (1.0, None, 2.0), history="ramp"), "history of Prescribed"),
        (lambda: Initial(displacement=[1.0, 2.0]), "initial displacement"),
        (lambda: Initial(velocity=[[1.0, 2.0, NAN]]), "initial velocity"),
        (lambda: Initial(velocity=np.zeros((2, 3))).fields(3), r"shape \(3, 3\)"),
    ],
)
def test_what_is_not_well_formed_is_refused(make, words):
    with pytest.raises(LoadError, match=words):
        make()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"loads": ["gravity"]}, "a load must be Gravity"),
        ({"loads": [PointLoad(node=1000, vector=(1, 0, 0))]}, "from 0 to 29"),
        ({"loads": [PointLoad(point=(2, 0, 0), vector=(1, 0, 0))]}, "outside of the body"),
        ({"loads": [Traction("x==7", (1, 0, 0))]}, "matches no facet"),
        ({"loads": [Gravity(history=lambda time: NAN)]}, "gave nan at 0 s"),
        ({"prescribed": [Prescribed("x==0", (0.1, None, None))]}, "both held .* and prescribed"),
        ({"probes": {"a": (9, 9, 9)}}, "probe 'a' lies outside"),
        ({"probes": {"a": (9, 9)}}, "three finite numbers"),
        ({"step": 0.0}, "time step must be positive"),
        ({"step": NAN}, "time step must be positive"),
        ({"damping": (0.0, -1.0)}, "two numbers from 0"),
        ({"damping": 0.1}, "two numbers from 0"),
        ({"newton": 0}, "newton must be"),
        ({"newton_tolerance": 0.0}, "newton_tolerance"),
        ({"newton_iterations": 0}, "newton_iterations"),
        ({"max_halvings": -1}, "max_halvings"),
        ({"linear": "lu"}, "linear solver must be one of"),
        ({"linear": "pcg-jacobi", "linear_tolerance": 2.0}, "tolerance must lie between"),
        ({"integrator": "newmark"}, "an integrator must be"),
        ({"integrator": analysis.BackwardEuler}, "an integrator must be"),
    ],
)
def test_requests_that_cannot_be_met_are_refused(options, words):
    whole = {"loads": [], "integrator": analysis.BackwardEuler(), "step": 0.01, **options}
    loads, integrator = whole.pop("loads"), whole.pop("integrator")
    with (
        pytest.raises(DefoError, match=words),
        analysis.Simulation(bar(), loads, integrator, **whole) as simulation,
    ):
        simulation.advance()


def test_newmark_refuses_what_is_not_stable():
    with pytest.raises(LoadError, match=r"beta = 0\.1"):
        analysis.ImplicitNewmark(beta=0.1)
    with pytest.raises(LoadError, match=r"gamma = 0\.4"):
        analysis.ImplicitNewmark(gamma=0.4)
    with pytest.raises(LoadError, match="nan"):
        analysis.ImplicitNewmark(beta=NAN)
