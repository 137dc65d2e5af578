"""A spoon of 11,000 dofs, bent far and let go: the full simulation beside its reduced models.

    python workflows/spoon.py [--output DIR] [--quick]

The spoon of ``meshes/spoon.py``, of a soft plastic, is held at the handle's end and pushed down at
the bowl until it has bent far, then let go. Reduced models: the vibration modes with a linear
force; the same with the exact cubic force of St. Venant-Kirchhoff; and 12 columns of 6 modes and
their derivatives with the cubic force, as in Barbič's course (SIGGRAPH 2012, part 2), where a spoon
of 11,094 dofs with k = 6 and r = 12 ran 50,000 times faster than the full simulation.

What is asserted: modes alone fail, with a linear force and with the exact one, as bending needs
what the derivatives add; with them the motion is the full one's within a few per cent.
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
COURSE = "11,094 dofs, k = 6, r = 12: 50,000 times faster than the full simulation"


def story(*, quick: bool) -> beside_full.Story:
    """The spoon, pushed for a while and let go."""
    data = common.drawn(spoon, size=0.006 if quick else 0.0021)
    solid = fem.Solid(data, PLASTIC, fixed=["handle_end"])
    release = analysis.Table((0.0, 0.1, 0.12), (0.0, 1.0, 0.0))
    push = analysis.Traction("bowl", (0.0, 0.0, -PUSH), history=release)
    return beside_full.Story(
        solid=solid,
        loads={"push": push},
        step=1e-3,
        steps=200 if quick else 400,
        damping=(0.5, 2e-5),
        watched=tuple(solid.points[int(np.argmin(solid.points[:, 0]))]),
    )


PUSH = 800.0  # [Pa]


def main(argv: list[str] | None = None) -> int:
    """Run all, print, draw and check."""
    options = common.parser(__doc__, "spoon").parse_args(argv)
    told = story(quick=options.quick)
    every = 4
    full = beside_full.run_full(told, every)
    begin = time.perf_counter()
    modes = analysis.linear_modes(told.solid, MODES, verify=False)
    found = time.perf_counter() - begin
    linear = reduction.linear_basis(told.solid, modes)
    begin = time.perf_counter()
    curved = reduction.modal_derivative_basis(told.solid, modes, size=SIZE)
    derived = time.perf_counter() - begin
    runs = []
    for name, basis, force, before in (
        (f"linear, {MODES} modes", linear, "linear", found),
        (f"cubic, {MODES} modes", linear, "cubic", found),
        (f"cubic, r = {SIZE} with derivatives", curved, "cubic", found + derived),
    ):
        model, seconds = beside_full.model_of(told, basis, force)
        runs.append(beside_full.run_reduced(told, name, model, before + seconds, full, every))
    tip = np.abs(full.watched).max()
    remark = (
        f"The spoon of {1e3 * LENGTH:.0f} mm bends by {1e3 * tip:.0f} mm at the tip of its bowl. "
        f"The course has, for its spoon, {COURSE}."
    )
    text = "# A spoon, bent and let go\n\n" + beside_full.report(told, full, runs, remark)
    text += "\n![Displacement and error over time](spoon.png)\n"
    figure = beside_full.draw(full, runs, 2, "height of the bowl's tip")
    common.tell(options.output, "spoon", text, figure)
    check(runs, tip)
    return 0


def check(runs: list[beside_full.Reduced], tip: float) -> None:
    """Check what the spoon is there to show."""
    linear, stiff, curved = (run.largest_error for run in runs)
    assert tip > 0.25 * LENGTH, f"the spoon bends by {tip:.3g} m only"
    assert linear > 0.1, f"a linear force errs by {linear:.2g} only"
    assert stiff > 3.0 * curved, f"modes alone err by {stiff:.2g}, derivatives by {curved:.2g}"
    assert curved < 0.05, f"with derivatives the error is {curved:.2g}"


if __name__ == "__main__":
    sys.exit(main())
