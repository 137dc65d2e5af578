"""Vibration about a stressed state: tension tunes a bar, compression softens it to Euler's load.

A pinned or sliding bar keeps its shapes under an axial load T = A P(s), and to first order in T

    omega² = omega0² + T k² (1 + c r) / (rho A (1 + r)),   k = n pi / L,   r = k² I / A.

T does work on the slope of the deflection, which carries rotary inertia with it; and the strain
changes the stiffness in bending by the factor P'(s) t² / s² = 1 + c (s - 1), with t the lateral
stretch: fibres are s long, their distance is t, and the curvature is taken over the rest length.
So c = P''(1) / E - 2 nu - 2. Left out are terms in r², the first that shear has a part in.
"""

import numpy as np
import pytest
from bodies import Array, box
from scipy.optimize import brentq

from fenics_defo.analysis import describe_motion, linear_modes
from fenics_defo.beams import RectangularSection, buckling_load, timoshenko_frequencies
from fenics_defo.energy import NeoHookean, StVenantKirchhoff
from fenics_defo.errors import EigenSolveError
from fenics_defo.fem import Fixed, Solid

LENGTH, WIDTH, HEIGHT = 1.0, 0.05, 0.04
STRAIN = 2.0e-4
SECTION = RectangularSection(WIDTH, HEIGHT)
MIDDLE = np.array([LENGTH, WIDTH, HEIGHT]) / 2.0
BAR = {"length": LENGTH, "section": SECTION, "young": 1.0}
# Without Poisson's effect the pins' grip on the section does not hinder the uniform stretch.
PINNED = StVenantKirchhoff(young=1.0, poisson=0.0, density=1.0)
SLIDING = NeoHookean(young=1.0, poisson=0.3, density=1.0)


def bar(material: StVenantKirchhoff | NeoHookean, fixed: list[Fixed]) -> Solid:
    mesh = box("hexahedron", (16, 1, 1), (LENGTH, WIDTH, HEIGHT))
    return Solid(mesh, material, order=2, fixed=fixed)


@pytest.fixture(scope="module")
def pinned() -> Solid:
    """Both ends held sideways; one node on the axis, which bending leaves at rest, holds along."""
    node = f"x==0.5 and y=={MIDDLE[1]} and z=={MIDDLE[2]}"
    return bar(PINNED, [Fixed("x==0 or x==1", "yz"), Fixed(node, "x")])


@pytest.fixture(scope="module")
def sliding() -> Solid:
    """Ends that cannot tilt but slide sideways, and free sides: three rigid motions remain."""
    return bar(SLIDING, [Fixed("x==0 or x==1", "x")])


def stretched(solid: Solid, strain: float) -> tuple[Array, float]:
    """Displacement of the uniaxial state and its tension T [N], in closed form."""
    s, t, area = 1.0 + strain, 1.0, SECTION.area
    if solid.materials is PINNED:
        tension = area * s * (s**2 - 1.0) / 2.0
    else:
        lmbda, mu = SLIDING.parameters["lmbda"], SLIDING.parameters["mu"]
        t = brentq(lambda t: mu * (t**2 - 1.0) + lmbda * np.log(s * t**2), 0.9, 1.1, xtol=1e-15)
        tension = area * mu * (s - t**2 / s)
    return (solid.points - MIDDLE) * (np.array([s, t, t]) - 1.0), float(tension)


@pytest.mark.parametrize("name", ["pinned", "sliding"])
@pytest.mark.parametrize("strain", [0.01, -0.01])
def test_state_is_in_equilibrium(name: str, strain: float, request: pytest.FixtureRequest) -> None:
    """The prescribed state needs T at its ends and nothing elsewhere."""
    solid = request.getfixturevalue(name)
    displacement, tension = stretched(solid, strain)
    force = solid.internal_force(displacement)
    end = solid.points[:, 0] > LENGTH - 1e-9
    assert force[end].sum(axis=0) == pytest.approx([tension, 0.0, 0.0], rel=1e-11, abs=1e-15)
    start = solid.points[:, 0] < 1e-9
    assert np.abs(force[~(end | start)]).max() < 1e-12 * abs(tension)
    assert np.abs(force[:, 1:]).max() < 1e-12 * abs(tension)


@pytest.mark.parametrize(
    ("name", "supports"), [("pinned", "pinned-pinned"), ("sliding", "sliding-sliding")]
)
def test_tension_raises_the_pitch(name: str, supports: str, request: pytest.FixtureRequest) -> None:
    """Slope of omega² in T, for two modes in each plane; and the unloaded bar is Timoshenko's."""
    solid = request.getfixturevalue(name)
    rigid = {"pinned": 0, "sliding": 3}[name]
    rest = linear_modes(solid, rigid + 4)
    assert rest.rigid_modes == rigid
    poisson = solid.materials.poisson
    squares, tensions = [], []
    for strain in (STRAIN, -STRAIN):
        displacement, tension = stretched(solid, strain)
        modes = linear_modes(solid, rigid + 4, displacement=displacement)
        assert modes.rigid_modes == rigid
        assert describe_motion(modes) == describe_motion(rest)
        squares.append((2.0 * np.pi * modes.frequencies[rigid:]) ** 2)
        tensions.append(tension)
    slopes = (squares[0] - squares[1]) / (tensions[0] - tensions[1])
    curvature = sum(tensions) / (STRAIN**2 * SECTION.area)
    bending = curvature - 2.0 * poisson - 2.0
    for word, direction, inertia in (
        ("bending y", "y", SECTION.second_moment_z),
        ("bending z", "z", SECTION.second_moment_y),
    ):
        mine = np.array([w == word for w in describe_motion(rest)[rigid:]])
        theory = timoshenko_frequencies(
            count=2, poisson=poisson, density=1.0, direction=direction, supports=supports, **BAR
        )
        assert rest.frequencies[rigid:][mine] == pytest.approx(theory, rel=0.003)
        k2 = (np.arange(1, 3) * np.pi / LENGTH) ** 2
        slenderness = k2 * inertia / SECTION.area
        expected = k2 / SECTION.area * (1.0 + bending * slenderness) / (1.0 + slenderness)
        assert (np.abs(slopes[mine] / expected - 1.0) < 50.0 * slenderness**2).all()


def test_compression_down_to_the_buckling_load(pinned: Solid) -> None:
    """omega² falls in a line to zero at Euler's load, less what shear and shortening take."""

    def lowest(strain: float) -> float:
        displacement, _ = stretched(pinned, strain)
        return float(linear_modes(pinned, 1, displacement=displacement).frequencies[0] ** 2)

    euler = buckling_load(**BAR, supports="pinned-pinned")
    guess = -euler / SECTION.area
    near, far = 0.9 * guess, 0.8 * guess
    critical = near + lowest(near) * (near - far) / (lowest(far) - lowest(near))
    _, load = stretched(pinned, critical)
    rigidity = 5.0 / 6.0 * 0.5 * SECTION.area  # kappa G A
    engesser = euler / (1.0 + euler / rigidity)
    assert -load == pytest.approx(engesser, rel=3.0 * euler / SECTION.area)
    rest = linear_modes(pinned, 1).frequencies[0]
    assert np.sqrt(lowest(0.999 * critical)) < 0.04 * rest
    with pytest.raises(EigenSolveError, match="not a stable state"):
        lowest(1.0001 * critical)


@pytest.mark.parametrize("beyond", [1.02, 1.5])
def test_buckled_bar_with_rigid_motions_has_no_modes(sliding: Solid, beyond: float) -> None:
    """Free bodies are solved about a negative shift: unstable modes above it are not rigid."""
    euler = buckling_load(**BAR, supports="pinned-pinned")
    displacement, _ = stretched(sliding, -beyond * euler / SECTION.area)
    with pytest.raises(EigenSolveError):
        linear_modes(sliding, 5, displacement=displacement)
