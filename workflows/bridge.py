"""A soft bridge of 36,000 dofs over 2,000 steps under a train, and its reduced models beside it.

    python workflows/bridge.py [--output DIR] [--quick]

The bridge and the train are those of ``workflows/travelling_load.py``, the bridge 300 times softer
and the train slower as the periods are longer: the deck gives way by more than its own thickness.
Each place of a wheel on the deck is a named load of the model. Reduced models: modes alone, with a
linear and with the exact cubic force; modes and their derivatives, weighed at the size of this
motion; and fewer of them joined with what an axle does statically at some places of the deck, as no
few modes hold the dent under a wheel. The course (Barbič, SIGGRAPH 2012, part 2) reports a bridge
that ran 108,000 times faster than its full simulation.

What is asserted: modes alone fail, with a linear force and with the exact one; with derivatives and
the axle's own fields the motion is the full one's within some per cent. On the coarse mesh that
holds; at full size it does not yet: the last model errs by 29 %, and the script ends with that.
"""

import sys
import time
from dataclasses import dataclass

import beside_full
import common
import numpy as np
import travelling_load
from travelling_load import CROWN, SPEED, Crossing, axle

from fenics_defo import analysis, energy, fem, reduction
from meshes.bridge import DECK_DEPTH, DECK_LENGTH, bridge

SOFTER = 300.0  # times
RUBBER = energy.StVenantKirchhoff(young=2e9 / SOFTER, poisson=0.35, density=1000.0)
SLOWER = np.sqrt(SOFTER)
APART = 15.84  # distance of the axles [m]
AMPLITUDE = 0.5  # of the first mode, at which derivatives are weighed against modes [m]
COURSE = 108_000


@dataclass(frozen=True, slots=True)
class Size:
    """How much is computed.

    Args:
        mesh: target edge length [m].
        places: along the deck, see `Crossing`.
        steps: of the crossing and of what follows.
        duration: of both, for the stiff bridge [s].
        axles: of the train.
        modes: k of them.
        r: columns of all bases.
        statics: places of the axle whose static fields join the basis.
    """

    mesh: float
    places: int
    steps: int
    duration: float
    axles: int
    modes: int
    r: int
    statics: int


FULL = Size(0.22, 97, 2000, 1.1, 4, 12, 30, 10)
QUICK = Size(1.2, 25, 90, 0.54, 2, 8, 24, 8)


def story(size: Size) -> beside_full.Story:
    """The bridge and the train."""
    solid = fem.Solid(common.drawn(bridge, size=size.mesh), RUBBER, fixed=["abutments"])
    x = np.linspace(-0.5 * DECK_LENGTH, 0.5 * DECK_LENGTH, size.places)
    wheels = Crossing(x, SPEED / SLOWER, size.axles, APART).loads()
    alpha, beta = travelling_load.rayleigh()
    return beside_full.Story(
        solid=solid,
        loads={f"wheel {number}": wheel for number, wheel in enumerate(wheels)},
        step=size.duration * SLOWER / size.steps,
        steps=size.steps,
        damping=(alpha / SLOWER, beta * SLOWER),
        watched=CROWN,
        linear="pcg-jacobi",
        every=10 if size is FULL else 2,
    )


def bases(solid: fem.Solid, size: Size) -> list[reduction.Basis]:
    """Modes; modes and derivatives; the axle's static fields and fewer of these; the last of r."""
    modes = analysis.linear_modes(solid, size.modes, verify=False)
    farthest = float(np.linalg.norm(modes.shapes[0], axis=1).max())
    derivatives = reduction.modal_derivatives(solid, modes)
    curved, fewer = (
        reduction.modal_derivative_basis(
            solid, modes, size=r, derivatives=derivatives, amplitude=AMPLITUDE / farthest
        )
        for r in (size.r, size.r - size.statics)
    )
    x = np.linspace(-0.5 * DECK_LENGTH, 0.5 * DECK_LENGTH, size.statics + 2)[1:-1]
    fields = [analysis.static_equilibrium(solid, axle(place)).displacement for place in x]
    dents = reduction.snapshot_basis(solid, np.array(fields), size=size.statics)
    return [reduction.linear_basis(solid, modes), curved, reduction.join(solid, dents, fewer)]


def main(argv: list[str] | None = None) -> int:
    """Run all, print, draw and check."""
    options = common.parser(__doc__, "bridge").parse_args(argv)
    size = QUICK if options.quick else FULL
    told = story(size)
    begin = time.process_time()
    modes, curved, joined = bases(told.solid, size)
    made = time.process_time() - begin
    full = beside_full.run_full(told)
    runs = []
    for name, basis, force in (
        (f"linear, {size.modes} modes", modes, "linear"),
        (f"cubic, {size.modes} modes", modes, "cubic"),
        (f"cubic, r = {curved.size} with derivatives", curved, "cubic"),
        (f"cubic, r = {joined.size} with derivatives and static fields", joined, "cubic"),
    ):
        model, seconds = beside_full.model_of(told, basis, force)
        offline = seconds + (made if basis is joined else 0.0)
        runs.append(beside_full.run_reduced(told, name, model, offline, full))
    figure = beside_full.draw(full, runs, 2, "height of the crown")
    common.tell(options.output, "bridge", report(told, full, runs), figure)
    check(told, full, runs)
    return 0


def report(told: beside_full.Story, full: beside_full.Full, runs: list[beside_full.Reduced]) -> str:
    """The table as Markdown."""
    rest = 100 * beside_full.linearisation(told, runs[-1])
    return (
        "# A train crosses a soft bridge\n\n"
        + beside_full.setting(told)
        + f"With Newton's method converged in each step, the motion of the last model changes by "
        f"{rest:.2g} %.\n\n"
        + beside_full.run_table(told, full, runs)
        + f"\nThe crown moves by {full.farthest:.2f} m. The seconds offline of the last are those "
        + "of all bases. The course's bridge ran "
        + f"{COURSE:,} times faster than its full simulation. Made by `workflows/bridge.py`.\n\n"
        + "![Height of the crown and error over time](bridge.png)\n"
    )


def check(told: beside_full.Story, full: beside_full.Full, runs: list[beside_full.Reduced]) -> None:
    """What is asserted."""
    linear, stiff, curved, joined = (run.largest_error for run in runs)
    assert beside_full.linearisation(told, runs[-1]) < 0.02
    assert full.farthest > DECK_DEPTH, full.farthest
    assert linear > 0.15, linear
    assert stiff > 0.15, stiff
    assert curved < 0.7 * stiff, (curved, stiff)
    assert joined < 0.08, joined


if __name__ == "__main__":
    sys.exit(main())
