"""Statics and dynamics on two MPI ranks are those on one."""

from pathlib import Path

import numpy as np
import pytest
from moving_bodies import NEO, STVK, TIP, bar, cube

from fenics_defo.analysis import (
    BackwardEuler,
    CentralDifferences,
    Gravity,
    ImplicitNewmark,
    Impulse,
    PointLoad,
    Prescribed,
    Pressure,
    QuasiStatic,
    Ramp,
    Simulation,
    Sine,
    SymplecticEuler,
    Traction,
    static_equilibrium,
)
from fenics_defo.errors import DefoError

HERE = Path(__file__).parent
LOADS = [
    Gravity((0.0, 0.0, -5.0), history=Sine(2.0)),
    Pressure("x==1", 300.0),
    Traction("z==0.2", (0.0, 20.0, 0.0), history=Ramp(0.05)),
    PointLoad(point=TIP, vector=(1.0, 0.0, 0.0)),
    Impulse(region="x>0.6", vector=(0.0, 0.5, 0.0), time=0.011),
    Impulse(point=(0.4, 0.1, 0.1), vector=(0.0, 0.0, 0.5)),
]
SHAKEN = [Prescribed("x==0", (None, 0.0, 0.05), history=Sine(3.0))]
CONVERGED = {"newton": None, "newton_tolerance": 1e-10}
CASES = {
    "newmark": (ImplicitNewmark(), CONVERGED),
    "euler": (BackwardEuler(), {"newton": 1}),
    "central": (CentralDifferences(), {}),
    "symplectic": (SymplecticEuler(), {}),
    "jacobi": (ImplicitNewmark(), {"linear": "pcg-jacobi", "linear_tolerance": 1e-12}),
    "multigrid": (ImplicitNewmark(), {"linear": "pcg-amg", "linear_tolerance": 1e-12}),
}
STATIC = [Gravity((0.0, 0.0, -2.0)), Pressure("x==1", 2.0e3)]


def moved(case):
    """All that a simulation gives after ten steps, in an array."""
    integrator, options = CASES[case]
    with Simulation(
        bar(STVK, held=None),
        LOADS,
        integrator,
        step=4e-3,
        damping=(0.1, 1e-4),
        prescribed=SHAKEN,
        probes={"tip": TIP},
        **options,
    ) as simulation:
        for _ in range(10):
            simulation.advance()
        energies = simulation.energies
        parts = [
            simulation.state.displacement.ravel(),
            simulation.state.velocity.ravel(),
            simulation.reactions().ravel(),
            simulation.probe("tip"),
            *simulation.momentum(),
            [energies.kinetic, energies.strain, energies.external, energies.dissipated],
            [min(simulation.critical_step, 1.0)],
        ]
    return [np.asarray(part) for part in parts]


def rested():
    """The same of equilibria, and how many tries they took."""
    hung = static_equilibrium(bar(STVK), STATIC)
    squeeze = [Prescribed("z==1", (0.0, 0.0, -0.9))]
    squeezed = static_equilibrium(cube(NEO), [], prescribed=squeeze)
    counts = [hung.iterations, squeezed.iterations, squeezed.inverted_cells]
    return [
        hung.displacement.ravel(),
        hung.reactions.ravel(),
        squeezed.displacement.ravel(),
        np.asarray(counts, float),
    ]


#: Newton's method is stopped before it can be done with so long a step.
IMPATIENT = {
    "newton": None,
    "newton_iterations": 1,
    "max_halvings": 0,
    "step": 2.0,
}


def failed():
    """The sentences of failures, which all ranks must raise alike."""
    told = []
    for integrator, options in (
        (QuasiStatic(), {}),
        (CentralDifferences(), {}),
        (BackwardEuler(), {"probes": {"a": (9.0, 9.0, 9.0)}}),
        (ImplicitNewmark(), IMPATIENT),
    ):
        try:
            with Simulation(
                bar(STVK, held=None), LOADS[:2], integrator, **{"step": 0.1} | options
            ) as simulation:
                simulation.advance()
        except DefoError as error:
            told.append(f"{type(error).__name__} {error}")
    return told


def write_all(folder):
    comm = bar(STVK).comm
    for name, parts in {**{case: moved(case) for case in CASES}, "static": rested()}.items():
        same = comm.bcast(parts, root=0)
        for mine, first in zip(parts, same, strict=True):
            np.testing.assert_array_equal(mine, first)
        if comm.rank == 0:
            np.savez(Path(folder, f"{name}.npz"), *parts)
    told = failed()
    assert told == comm.bcast(told, root=0)
    assert len(told) == 4


@pytest.fixture(scope="module")
def folder(mpirun, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two_ranks_dynamics")
    code = f"import sys; sys.path.insert(0, {str(HERE)!r})\n" + (
        "from test_two_ranks_dynamics import write_all; write_all(sys.argv[1])"
    )
    done = mpirun("-c", code, folder)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.mpi
@pytest.mark.parametrize("case", [*CASES, "static"])
def test_two_ranks_move_bodies_as_one_does(case, folder):
    one = rested() if case == "static" else moved(case)
    with np.load(folder / f"{case}.npz") as two:
        for number, part in enumerate(one):
            scale = np.abs(part).max()
            assert two[f"arr_{number}"] == pytest.approx(part, abs=2e-8 * scale)
