"""Statics for ``validation.py``: homogeneous states, large bending, meshes, locking."""

from pathlib import Path

import numpy as np
import test_homogeneous_equilibria as homogeneous
import test_large_bending as bending
import test_static_spaces as spaces
import test_turek_hron as bar
from scipy.integrate import solve_ivp
from validation_figures import drawn
from validation_report import Chapter, Check

from fenics_defo.beams import (
    compressive_limit,
    equibiaxial_tension,
    simple_shear,
    uniaxial_tension,
)

type Array = np.ndarray
COLOURS = ("C0", "C1", "C2", "C3", "C4")
STRETCHES = {"x": (0.7, 0.85, 1.15, 1.3, 1.45), "xy": (0.75, 0.85, 1.1, 1.2, 1.3)}


def homogeneous_states(figures: Path) -> Chapter:
    """Nominal stress against stretch of each law, on a mesh of uneven second-order tetrahedra."""
    checks = []
    with drawn(figures / "homogeneous.png", 2) as (left, right):
        for law, colour in zip(homogeneous.LAWS, COLOURS, strict=True):
            constants = homogeneous.LAWS[law][1]
            for axis, axes, closed in (
                (left, "x", uniaxial_tension),
                (right, "xy", equibiaxial_tension),
            ):
                fine = np.linspace(0.95 * STRETCHES[axes][0], 1.03 * STRETCHES[axes][-1], 60)
                curve = [closed(law, stretch=float(s), **constants).stress for s in fine]
                style = "--" if law == "corotational" else "-"
                axis.plot(fine, curve, style, color=colour, label=law)
                found = [pulled_stress(law, s, axes) for s in STRETCHES[axes]]
                axis.plot(STRETCHES[axes], found, "o", color=colour, markersize=4)
                worst = worst_ratio(
                    found, [closed(law, stretch=s, **constants).stress for s in STRETCHES[axes]]
                )
                kind = "uniaxial" if axes == "x" else "equibiaxial"
                checks.append(Check(f"{law}, {kind}: stress over closed form", worst, 1.0, 1e-8))
            checks.append(
                Check(f"{law}, simple shear by 0.4: largest error of u", shear(law), 0.0, 1e-8)
            )
        left.set(xlabel="stretch", ylabel="nominal stress [Pa]", title="uniaxial")
        right.set(xlabel="stretch", title="equibiaxial")
    text = """
A block of second-order tetrahedra of uneven shapes is stretched by its ends with free sides, and
sheared by the tractions that simple shear needs. Lines: closed forms; dots: the simulator.
E = 2.6 Pa, nu = 0.3; c10 = 0.3, c01 = 0.2, bulk = 4 Pa.

![nominal stresses](validation/homogeneous.png)
"""
    return Chapter("Homogeneous states of each law", text, tuple(checks))


def worst_ratio(found: list[float], expected: list[float]) -> float:
    """The quotient that is farthest from one."""
    ratios = np.array(found) / np.array(expected)
    return float(ratios[np.abs(ratios - 1.0).argmax()])


def pulled_stress(law: str, stretch: float, axes: str) -> float:
    """Nominal stress on the far end along x."""
    solid = homogeneous.uneven(law, "tetrahedron", 2, homogeneous.ROLLERS)
    found = homogeneous.pulled(solid, stretch, axes)
    area = homogeneous.SIDES[1] * homogeneous.SIDES[2]
    return homogeneous.end_force(solid, found, 0) / area


def shear(law: str) -> float:
    """Largest error of the displacement of a block that its tractions shear."""
    stress = simple_shear(law, amount=0.4, **homogeneous.LAWS[law][1])
    solid, found = homogeneous.sheared(law, "tetrahedron", 2, stress)
    exact = np.zeros_like(found)
    exact[:, 0] = 0.4 * solid.points[:, 1]
    return float(np.abs(found - exact).max())


def limit_point(figures: Path) -> Chapter:
    """Force of a St. Venant-Kirchhoff column whose end is moved."""
    young = homogeneous.HOOKE["young"]
    limit = compressive_limit(young=young)
    stretches, forces = homogeneous.compressed(np.linspace(0.3, 1.0, 29))
    with drawn(figures / "limit_point.png") as axes:
        s = np.linspace(0.3, 1.0, 100)
        axes.plot(s, young * s * (s**2 - 1.0) / 2.0, "-", label="E s (s² - 1) / 2")
        axes.plot(stretches, forces, "o", markersize=4, label="simulator")
        axes.axvline(limit.stretch, color="k", linestyle=":", label="1 / sqrt(3)")
        axes.set(xlabel="stretch", ylabel="nominal stress [Pa]")
    checks = (
        Check("stretch of the largest resistance", homogeneous.peak(), limit.stretch, 1e-6),
        Check(
            "nominal stress there [Pa]",
            float(homogeneous.compressed(np.array([limit.stretch]))[1][0]),
            limit.stress,
            1e-8,
        ),
    )
    text = """
A column of one cell pressed together by its moved end. Below the stretch 1 / sqrt(3) the law has
less and less resistance: use another law, or its invertible form, for strong compression.

![limit point](validation/limit_point.png)
"""
    return Chapter("St. Venant-Kirchhoff's limit in compression", text, checks)


def elastica_curve(load: float) -> Array:
    """(k, 2) points of the unit elastica under a dead end force, from its tip's rotation."""
    tip = bending.elastica(load, 0.02)

    def slopes(_: float, state: Array) -> list[float]:
        angle, bend = state[:2]
        return [bend, -load * np.cos(angle), np.cos(angle), np.sin(angle)]

    # First integral: the curvature at the clamp.
    clamp = np.sqrt(2.0 * load * np.sin(tip.rotation))
    curve = solve_ivp(
        slopes, (0.0, 1.0), [0.0, clamp, 0.0, 0.0], rtol=1e-9, atol=1e-10, max_step=0.02
    )
    return curve.y[2:].T


def large_bending(figures: Path) -> Chapter:
    """Cantilevers under dead end forces, and rolled up by an end moment."""
    checks = []
    side = 0.02
    with drawn(figures / "large_bending.png", 2) as (left, right):
        for load in (1.0, 2.0, 4.0, 10.0):
            solid, found = bending.bent("corotational", load, 32, side)
            left.plot(*elastica_curve(load).T, "k-", linewidth=1)
            left.plot(*bending.axis_line(solid, found, side).T, "o", markersize=3)
            mine, theirs = bending.tip(solid, found, side), bending.elastica(load, side)
            name = f"end force F L² / (E I) = {load:g}"
            checks += [
                Check(f"{name}: x of the tip / L", mine.x, theirs.x, 4e-3),
                Check(f"{name}: y of the tip / L", mine.y, theirs.y, 4e-3),
            ]
        left.set(xlabel="x / L", ylabel="y / L", title="dead end force", aspect="equal")
        solid, way = bending.rolled("corotational", 48, side, 1.0)
        for turns in (0.25, 0.5, 0.75, 1.0):
            found = way[round(turns * (len(way) - 1))]
            angle = 2.0 * np.pi * turns * np.linspace(0.0, 1.0, 100)
            radius = 0.5 / (np.pi * turns)
            right.plot(radius * np.sin(angle), radius * (1.0 - np.cos(angle)), "k-", linewidth=1)
            line = bending.axis_line(solid, found, side)
            right.plot(*line.T, "o", markersize=3)
            force, moment = bending.end_loads(solid, found, side)
            theory = 2.0 * np.pi * turns * bending.bending_stiffness(side)
            off = np.abs(np.hypot(line[:, 0], line[:, 1] - radius) - radius).max()
            name = f"{turns:g} turns"
            checks += [
                Check(f"{name}: end moment over 2 pi E I / L x turns", moment / theory, 1.0, 5e-3),
                Check(f"{name}: end force x L / moment", np.linalg.norm(force) / theory, 0.0, 1e-3),
                Check(f"{name}: axis off its circle / L", float(off), 0.0, 1e-4),
            ]
        right.set(xlabel="x / L", title="rolled up", aspect="equal")
    text = """
A cantilever of the slenderness 50, 32 x 1 x 2 second-order hexahedra, nu = 0. Lines: the elastica
(Bisshopp and Drucker 1945) and circles; dots: nodes on the beam's axis. To roll it up, its end
section is carried along the way of the elastica's tip: were that not the way of this beam, a force
would be needed beside the moment. What is left of the difference is shear and extension, which the
elastica neglects: it falls with the square of the thickness.

![large bending](validation/large_bending.png)
"""
    return Chapter("Large bending", text, tuple(checks))


def gravity(figures: Path) -> Chapter:
    """Turek and Hron's CSM1 and CSM2."""
    checks = []
    for name, young, published in (("CSM1", 1.4e6, bar.CSM1), ("CSM2", 5.6e6, bar.CSM2)):
        found = bar.at_rest(70, 4, young)
        for component, value, reference in zip("xy", found, published, strict=False):
            checks.append(Check(f"{name}: u{component} of A [mm]", value, reference, 3e-3))
    text = """
The structural tests of Turek and Hron (Proposal for numerical benchmarking of fluid-structure
interaction, 2006; figures of the finest adaptive grid from TU Dortmund's page of the benchmark): a
St. Venant-Kirchhoff bar in plane strain, clamped on a circle, under gravity. Here 70 x 4
second-order hexahedra without refinement at the clamp, whose corners are singular.
"""
    return Chapter("A bar under gravity: Turek and Hron's static tests", text, tuple(checks))


def refinement(figures: Path) -> Chapter:
    """Work of the weight of a hanging column and of a clamped stub, against the number of dofs."""
    checks = []
    with drawn(figures / "refinement.png", 2) as panels:
        for axes, case in zip(panels, spaces.CASES, strict=True):
            limit = spaces.limit_of_sag(case)
            for kind, order in spaces.SPACES:
                finer = (1, 2, 4, 8) if order == 1 else (1, 2, 4)
                if (kind, order) == ("hexahedron", 2):
                    finer = (1, 2)
                errors = np.array([1.0 - spaces.sag(case, kind, order, n) / limit for n in finer])
                axes.loglog(
                    [spaces.dofs_of_sag(case, kind, order, n) for n in finer],
                    np.abs(errors),
                    "o-" if kind == "hexahedron" else "s--",
                    label=f"{kind}, order {order}",
                )
                if case == "column":
                    observed = float(np.log2(errors[-2] / errors[-1]))
                    what = f"column, {kind}, order {order}: observed order in h"
                    checks.append(Check(what, observed, 2.0 * order, 0.3))
                else:
                    what = f"stub, {kind}, order {order}, {2 * finer[-1]} cells: error of the sag"
                    bound = {1: {"tetrahedron": 0.1, "hexahedron": 0.05}[kind], 2: 0.03}[order]
                    checks.append(Check(what, float(errors[-1]), 0.0, bound))
            axes.set(xlabel="degrees of freedom", title=case)
        panels[0].set(ylabel="relative error of the mean displacement")
    text = """
A neo-Hookean column that hangs from its end (nothing is singular: the error falls with h^(2 order),
for hexahedra and tetrahedra alike, to one limit extrapolated from second-order hexahedra), and a
clamped stub, 2.5 times as long as thick, that bends under its weight (the clamp's edges are
singular; reference: second-order hexahedra of 8 x 4 x 4 cells). Order 1 is much too stiff in
bending, tetrahedra about twice as much as hexahedra; for the same number of unknowns order 2 is
better by one to three orders of magnitude.

![refinement](validation/refinement.png)
"""
    return Chapter("Hexahedra against tetrahedra", text, tuple(checks))


RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499, 0.4999)


def locking(figures: Path) -> Chapter:
    """The thick-walled cylinder of MacNeal and Harder."""
    rows = []
    with drawn(figures / "locking.png") as axes:
        for kind, order in spaces.SPACES:
            for finer, style in ((1, "o-"), (2, "s--")):
                found = [spaces.widening(kind, order, ratio, finer) for ratio in RATIOS]
                rows.append((f"{kind}, order {order}, {5 * finer} cells", found))
                gap = [0.5 - ratio for ratio in RATIOS]
                axes.semilogx(gap, found, style, label=rows[-1][0], markersize=4)
        axes.set(xlabel="1/2 - nu", ylabel="widening, over Lamé's")
        axes.invert_xaxis()
    checks = [
        Check(f"{name}, nu = {ratio}", value, 1.0, bound)
        for name, found in rows
        if "order 2" in name
        for ratio, value, bound in zip(
            RATIOS, found, (4e-3, 4e-3, 4e-3, 6e-3, 2e-2, 2e-1), strict=True
        )
        if ratio in (0.3, 0.49, 0.499) or "10 cells" in name
    ]
    head = "| cells through the wall | " + " | ".join(f"nu = {ratio}" for ratio in RATIOS) + " |"
    lines = [head, "| --- " * (len(RATIOS) + 1) + "|"]
    lines += [
        f"| {name} | " + " | ".join(f"{value:.3f}" for value in found) + " |"
        for name, found in rows
    ]
    text = """
The thick-walled cylinder in plane strain under pressure (MacNeal and Harder, Finite Elements in
Analysis and Design 1 (1985) 3): displacement of the inner wall over Lamé's solution. One means
right, zero means locked.

![locking](validation/locking.png)
"""
    notes = (
        "\n".join(lines)
        + """

Which to use: **order 2** from nu = 0.4 on, tetrahedra or hexahedra; up to 0.49 any mesh of order 2
does, beyond it refine until the answer stands still. Order 1 is off by a tenth at 0.45 (tetrahedra)
or 0.48 (hexahedra) on such a mesh, and useless beyond 0.49; refining it hardly helps. There is no
mixed or selectively integrated element of order 1.
"""
    )
    return Chapter("Volumetric locking", text, tuple(checks), notes)


CASES = {
    "homogeneous": homogeneous_states,
    "limit": limit_point,
    "bending": large_bending,
    "gravity": gravity,
    "refinement": refinement,
    "locking": locking,
}
