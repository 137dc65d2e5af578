"""Constants of the material laws whose homogeneous states are known, checked and completed."""

from collections.abc import Mapping
from dataclasses import dataclass

from fenics_defo.beams.checks import (
    require_choice,
    require_finite,
    require_modulus,
    require_poisson,
    shear_modulus,
)
from fenics_defo.errors import MaterialError

_HOOKES = ("young", "poisson")
LAWS = {
    "linear": _HOOKES,
    "corotational": _HOOKES,
    "st-venant-kirchhoff": _HOOKES,
    "neo-hookean": _HOOKES,
    "mooney-rivlin": ("c10", "c01", "bulk"),
}
"""Names of the laws, and of the constants of each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LawConstants:
    """One law and its constants; those that the law does not have are zero.

    Args:
        law: one of `LAWS`.
        poisson: Poisson's ratio at rest [-].
        mu: shear modulus at rest [Pa].
        lmbda: Lame's first constant at rest [Pa].
        c10: of Mooney and Rivlin [Pa].
        c01: of Mooney and Rivlin [Pa].
        bulk: of Mooney and Rivlin [Pa].
    """

    law: str
    poisson: float
    mu: float
    lmbda: float
    c10: float = 0.0
    c01: float = 0.0
    bulk: float = 0.0


def law_constants(law: str, given: Mapping[str, float]) -> LawConstants:
    """The checked constants of ``law``.

    Raises:
        BeamError: an unknown law.
        MaterialError: a constant is missing, unknown or out of range.
    """
    names = LAWS[require_choice("law", law, LAWS)]
    if set(given) != set(names):
        raise MaterialError(
            f"the law {law!r} has the constants {', '.join(names)}; "
            f"got {', '.join(sorted(given)) or 'none'}"
        )
    if law == "mooney-rivlin":
        return _of_mooney_rivlin(**given)
    young, poisson = given["young"], require_poisson(given["poisson"])
    mu = shear_modulus(young, poisson)
    lmbda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson)
    return LawConstants(law=law, poisson=poisson, mu=mu, lmbda=lmbda)


def _of_mooney_rivlin(c10: float, c01: float, bulk: float) -> LawConstants:
    first, second = require_finite("c10", c10, unit="Pa"), require_finite("c01", c01, unit="Pa")
    mu = 2.0 * require_modulus("c10 + c01", first + second, unit="Pa")
    volume = require_modulus("bulk", bulk, unit="Pa")
    return LawConstants(
        law="mooney-rivlin",
        poisson=(3.0 * volume - 2.0 * mu) / (2.0 * (3.0 * volume + mu)),
        mu=mu,
        lmbda=volume - 2.0 / 3.0 * mu,
        c10=first,
        c01=second,
        bulk=volume,
    )
