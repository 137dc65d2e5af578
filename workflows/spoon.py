"""A spoon of 11,000 dofs, bent far and let go: the full simulation beside its reduced models.

    python workflows/spoon.py [--output DIR] [--quick]

The spoon of ``meshes/spoon.py``, of a soft plastic, is held at the handle's end and pushed down at
the bowl until its tip has moved by more than a third of its length, then let go. Reduced models:
the vibration modes alone with a linear force; the same with the exact cubic force of St.
Venant-Kirchhoff; and 12 columns of 6 modes and their derivatives with the cubic force, as in
Barbič's course (SIGGRAPH 2012, part 2), where a spoon of 11,094 dofs with k = 6 and r = 12 ran
50,000 times faster than the full simulation.

What is asserted: modes alone fail, with a linear force and with the exact one, as bending needs
what the derivatives add; with them the motion is the full one's within two per cent, at a small
part of the time.
"""

import sys
import time

import beside_full
import common
import numpy as np

from fenics_defo import analysis, energy, fem, reduction
from meshes.spoon import LENGTH, spoon

PLASTIC = energy.StVenantKirchhoff(young=2.0e8, poisson=0.35, density=1100.0)
MODES, SIZE = 6, 12
COURSE = "11,094 dofs, k = 6 and r = 12, 50,000 times faster than the full simulation"
PUSH, COARSE_PUSH = 180.0, 800.0  # [Pa]; coarse cells are stiffer


def story(*, quick: bool) -> beside_full.Story:
    """The spoon, pushed for a while and let go."""
    data = common.drawn(spoon, size=0.006 if quick else 0.0021)
    solid = fem.Solid(data, PLASTIC, fixed=["handle_end"])
    release = analysis.Table((0.0, 0.1, 0.12), (0.0, 1.0, 0.0))
    push = analysis.Traction("bowl", (0.0, 0.0, -(COARSE_PUSH if quick else PUSH)), history=release)
    return beside_full.Story(
        solid=solid,
        loads={"push": push},
        step=1e-3,
        steps=160 if quick else 260,
        newton=3,
        damping=(0.5, 2e-5),
        watched=tuple(solid.points[int(np.argmin(solid.points[:, 0]))]),
    )


def main(argv: list[str] | None = None) -> int:
    """Run all, print, draw and check."""
    options = common.parser(__doc__, "spoon").parse_args(argv)
    told = story(quick=options.quick)
    full = beside_full.run_full(told)
    begin = time.process_time()
    modes = analysis.linear_modes(told.solid, MODES, verify=False)
    linear = reduction.linear_basis(told.solid, modes)
    found = time.process_time() - begin
    curved = reduction.modal_derivative_basis(told.solid, modes, size=SIZE)
    both = time.process_time() - begin
    runs = []
    for name, basis, force, before in (
        (f"linear, {MODES} modes", linear, "linear", found),
        (f"cubic, {MODES} modes", linear, "cubic", found),
        (f"cubic, r = {SIZE} with derivatives", curved, "cubic", both),
    ):
        model, seconds = beside_full.model_of(told, basis, force)
        runs.append(beside_full.run_reduced(told, name, model, before + seconds, full))
    figure = beside_full.draw(full, runs, 2, "height of the bowl's tip")
    common.tell(options.output, "spoon", report(told, full, runs), figure)
    check(told, full, runs)
    return 0


def report(told: beside_full.Story, full: beside_full.Full, runs: list[beside_full.Reduced]) -> str:
    """The table as Markdown."""
    rest = 100 * beside_full.linearisation(told, runs[-1])
    return (
        "# A spoon, bent far and let go\n\n"
        + beside_full.setting(told)
        + f"With Newton's method converged in each step, the reduced motion changes by {rest:.2f} %"
        + ".\n\n"
        + beside_full.run_table(told, full, runs)
        + f"\nThe tip of the bowl of the spoon of {1e3 * LENGTH:.0f} mm moves by "
        + f"{1e3 * full.farthest:.0f} mm. The course has, for its spoon, {COURSE}. Made by "
        + "`workflows/spoon.py`.\n\n![Displacement and error over time](spoon.png)\n"
    )


def check(told: beside_full.Story, full: beside_full.Full, runs: list[beside_full.Reduced]) -> None:
    """What is asserted."""
    assert beside_full.linearisation(told, runs[-1]) < 0.01
    linear, stiff, curved = runs
    assert full.farthest > 0.25 * LENGTH, full.farthest
    assert linear.largest_error > 0.2, linear.largest_error
    assert stiff.largest_error > 0.2, stiff.largest_error
    assert curved.largest_error < 0.02, curved.largest_error
    assert full.step_seconds > 100.0 * curved.step_seconds, full.step_seconds


if __name__ == "__main__":
    sys.exit(main())
