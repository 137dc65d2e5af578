"""Cross-sections of straight prismatic beams.

The beam's axis is x; y and z are the principal axes of the section through its centroid.
`second_moment_y` is I_y = integral of z^2 dA, the moment *about* y: it resists deflection along z.
"""

from dataclasses import dataclass
from math import exp, pi
from typing import Protocol

from scipy.special import zeta

from fenics_defo.beams.checks import (
    BeamError,
    require_choice,
    require_poisson,
    require_positive,
)

SHEAR_RULES = ("cowper", "timoshenko", "static")
"""Published rules for the shear coefficient; see `Section.shear_coefficient`."""


class Section(Protocol):
    """What a beam formula needs to know of a cross-section; users may write their own.

    Attributes:
        area: A [m^2].
        second_moment_y: I_y = integral of z^2 dA [m^4]; resists deflection along z.
        second_moment_z: I_z = integral of y^2 dA [m^4]; resists deflection along y.
        polar_moment: I_y + I_z [m^4], the torsional inertia per unit density.
        torsion_constant: St. Venant's J [m^4]; the torque is G J times the twist per length.
    """

    @property
    def area(self) -> float: ...  # noqa: D102

    @property
    def second_moment_y(self) -> float: ...  # noqa: D102

    @property
    def second_moment_z(self) -> float: ...  # noqa: D102

    @property
    def polar_moment(self) -> float: ...  # noqa: D102

    @property
    def torsion_constant(self) -> float: ...  # noqa: D102

    def shear_coefficient(self, poisson: float, *, rule: str = "cowper") -> float:
        """Timoshenko's kappa [-]: the shear force is kappa G A times the mean shear angle.

        Args:
            poisson: Poisson's ratio [-].
            rule: "cowper", the default, is Cowper's average over the exact St. Venant flexure
                solution of an end-loaded beam, hence right for statics and the rule most papers
                and programs compare with. "timoshenko" is the value that makes long waves agree
                with three-dimensional elastodynamics (Timoshenko 1922; Kaneko 1975 and Hutchinson
                2001 found it the best for vibration, for a rectangle when it is narrow).
                "static" is the value without Poisson effect: 5/6 of a rectangle (Reissner 1945),
                6/7 of a disc.

        References:
            Cowper, J. Appl. Mech. 33 (1966) 335; Kaneko, J. Phys. D 8 (1975) 1927; Hutchinson,
            J. Appl. Mech. 68 (2001) 87, with Stephen's discussion, ibid. 959.
        """
        ...


@dataclass(frozen=True, slots=True)
class RectangularSection:
    """Solid rectangle, ``width`` along y and ``height`` along z.

    Args:
        width: extent along y [m].
        height: extent along z [m].

    Raises:
        BeamError: a side is not positive and finite.
    """

    width: float
    height: float

    def __post_init__(self) -> None:
        require_positive("width", self.width, unit="m")
        require_positive("height", self.height, unit="m")

    @property
    def area(self) -> float:
        """A = b h [m^2]."""
        return self.width * self.height

    @property
    def second_moment_y(self) -> float:
        """I_y = b h^3 / 12 [m^4]; resists deflection along z."""
        return self.width * self.height**3 / 12.0

    @property
    def second_moment_z(self) -> float:
        """I_z = h b^3 / 12 [m^4]; resists deflection along y."""
        return self.height * self.width**3 / 12.0

    @property
    def polar_moment(self) -> float:
        """I_y + I_z [m^4]."""
        return self.second_moment_y + self.second_moment_z

    @property
    def torsion_constant(self) -> float:
        """St. Venant's J [m^4] by the series in tanh, to round-off.

        J = a b^3 [1/3 - (64/pi^5) (b/a) sum over odd n of tanh(n pi a / 2b) / n^5], a >= b. The
        sum is split into 31 zeta(5) / 32 and the rest, which falls like exp(-n pi a / b).

        References:
            Timoshenko and Goodier, Theory of Elasticity, chapter on torsion, rectangular bars.
        """
        long, short = max(self.width, self.height), min(self.width, self.height)
        decay = pi * long / short
        rest = sum(2.0 * _decayed(n * decay) / n**5 for n in range(1, 15, 2))
        tanh_sum = 31.0 / 32.0 * float(zeta(5.0)) - rest
        return long * short**3 * (1.0 / 3.0 - 64.0 / pi**5 * short / long * tanh_sum)

    def shear_coefficient(self, poisson: float, *, rule: str = "cowper") -> float:
        """Cowper 10(1+nu)/(12+11nu); Timoshenko 5(1+nu)/(6+5nu); static 5/6 [-].

        See `Section.shear_coefficient` for the choice and the sources.
        """
        nu = require_poisson(poisson)
        if require_choice("rule", rule, SHEAR_RULES) == "cowper":
            return 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
        if rule == "timoshenko":
            return 5.0 * (1.0 + nu) / (6.0 + 5.0 * nu)
        return 5.0 / 6.0


@dataclass(frozen=True, slots=True)
class CircularSection:
    """Solid disc.

    Args:
        radius: [m].

    Raises:
        BeamError: the radius is not positive and finite.
    """

    radius: float

    def __post_init__(self) -> None:
        require_positive("radius", self.radius, unit="m")

    @property
    def area(self) -> float:
        """A = pi a^2 [m^2]."""
        return pi * self.radius**2

    @property
    def second_moment_y(self) -> float:
        """I_y = pi a^4 / 4 [m^4]."""
        return 0.25 * pi * self.radius**4

    @property
    def second_moment_z(self) -> float:
        """I_z = I_y [m^4]."""
        return self.second_moment_y

    @property
    def polar_moment(self) -> float:
        """Pi a^4 / 2 [m^4]."""
        return 2.0 * self.second_moment_y

    @property
    def torsion_constant(self) -> float:
        """J = polar moment [m^4]: a round section does not warp."""
        return self.polar_moment

    def shear_coefficient(self, poisson: float, *, rule: str = "cowper") -> float:
        """Cowper 6(1+nu)/(7+6nu); Timoshenko 6(1+nu)^2/(7+12nu+4nu^2); static 6/7 [-].

        See `Section.shear_coefficient` for the choice and the sources.
        """
        return _round_shear_coefficient(0.0, poisson, rule)


@dataclass(frozen=True, slots=True)
class TubeSection:
    """Circular tube of any wall thickness.

    Args:
        radius: outer radius a [m].
        inner_radius: inner radius b [m], less than a.

    Raises:
        BeamError: a radius is not positive and finite, or the inner is not the smaller.
    """

    radius: float
    inner_radius: float

    def __post_init__(self) -> None:
        require_positive("radius", self.radius, unit="m")
        require_positive("inner_radius", self.inner_radius, unit="m")
        if not self.inner_radius < self.radius:
            raise BeamError(
                f"inner_radius must be less than radius = {self.radius!r} m, "
                f"got {self.inner_radius!r}; use CircularSection for a solid bar"
            )

    @property
    def area(self) -> float:
        """A = pi (a^2 - b^2) [m^2]."""
        return pi * (self.radius - self.inner_radius) * (self.radius + self.inner_radius)

    @property
    def second_moment_y(self) -> float:
        """I_y = pi (a^4 - b^4) / 4 = A (a^2 + b^2) / 4 [m^4]."""
        return 0.25 * self.area * (self.radius**2 + self.inner_radius**2)

    @property
    def second_moment_z(self) -> float:
        """I_z = I_y [m^4]."""
        return self.second_moment_y

    @property
    def polar_moment(self) -> float:
        """Pi (a^4 - b^4) / 2 [m^4]."""
        return 2.0 * self.second_moment_y

    @property
    def torsion_constant(self) -> float:
        """J = polar moment [m^4]: a round section does not warp."""
        return self.polar_moment

    def shear_coefficient(self, poisson: float, *, rule: str = "cowper") -> float:
        """Cowper's, Hutchinson's (rule "timoshenko") or the Poisson-free value of a tube [-].

        See `Section.shear_coefficient` for the choice and the sources.
        """
        return _round_shear_coefficient(self.inner_radius / self.radius, poisson, rule)


def _decayed(exponent: float) -> float:
    """1 / (exp(x) + 1) = (1 - tanh(x/2)) / 2 without overflow."""
    return exp(-exponent) / (1.0 + exp(-exponent))


def _round_shear_coefficient(hollowness: float, poisson: float, rule: str) -> float:
    """Shear coefficient [-] of a disc or tube; ``hollowness`` m = inner / outer radius."""
    nu = require_poisson(poisson)
    ring, cross = (1.0 + hollowness**2) ** 2, hollowness**2
    if require_choice("rule", rule, SHEAR_RULES) == "cowper":
        return 6.0 * (1.0 + nu) * ring / ((7.0 + 6.0 * nu) * ring + (20.0 + 12.0 * nu) * cross)
    if rule == "timoshenko":
        below = (7.0 + 12.0 * nu + 4.0 * nu**2) * ring + (20.0 + 24.0 * nu + 8.0 * nu**2) * cross
        return 6.0 * (1.0 + nu) ** 2 * ring / below
    return 6.0 * ring / (7.0 * ring + 20.0 * cross)


def second_moment(section: Section, direction: str) -> float:
    """Second moment [m^4] that resists deflection along ``direction`` ("y" or "z").

    Raises:
        BeamError: the direction is neither.
    """
    if require_choice("direction", direction, ("y", "z")) == "y":
        return section.second_moment_z
    return section.second_moment_y


def resolve_shear_coefficient(section: Section, poisson: float, shear: str | float) -> float:
    """Shear coefficient [-]: a rule of `SHEAR_RULES`, or the user's own positive number.

    Raises:
        BeamError: neither a known rule nor a positive finite number.
    """
    if isinstance(shear, str):
        return section.shear_coefficient(poisson, rule=require_choice("shear", shear, SHEAR_RULES))
    return require_positive("shear", shear, unit="-")
