"""All natural frequencies of a uniform cantilever, by kind of motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_defo.beams.sections import Section
from fenics_defo.beams.stepped import (
    Segment,
    stepped_axial_frequencies,
    stepped_bending_frequencies,
    stepped_torsional_frequencies,
)

type Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class CantileverSpectrum:
    """Frequencies of a cantilever [Hz], each array (count,) and ascending.

    Args:
        bending_y: deflection along y, resisted by I_z.
        bending_z: deflection along z, resisted by I_y.
        torsion: twist about the axis.
        axial: extension along the axis.
    """

    bending_y: Array
    bending_z: Array
    torsion: Array
    axial: Array

    def lowest(self) -> tuple[Array, tuple[str, ...]]:
        """The ``count`` lowest frequencies of all kinds [Hz], (count,), and the kind of each."""
        kinds = ("bending_y", "bending_z", "torsion", "axial")
        merged = np.concatenate([getattr(self, kind) for kind in kinds])
        # Stable: equal frequencies of a square or round section keep the order of the kinds.
        order = np.argsort(merged, kind="stable")[: self.axial.size]
        return merged[order], tuple(kinds[i // self.axial.size] for i in order)


def cantilever_spectrum(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    density: float,
    count: int,
    theory: str = "timoshenko",
    shear: str | float = "cowper",
) -> CantileverSpectrum:
    """Frequencies of a cantilever in bending along y and z, torsion and extension.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].
        count: how many of each kind.
        theory: of bending, "timoshenko" or "euler-bernoulli".
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-].

    Returns:
        ``count`` frequencies [Hz] of each kind.

    Raises:
        BeamError: a length, theory, shear rule or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        As `timoshenko_frequencies`, `torsional_frequencies` and `axial_frequencies`.
    """
    bar = [Segment(length=length, section=section, young=young, poisson=poisson, density=density)]
    along_y, along_z = (
        stepped_bending_frequencies(
            bar, count=count, direction=direction, theory=theory, shear=shear
        )
        for direction in ("y", "z")
    )
    return CantileverSpectrum(
        bending_y=along_y,
        bending_z=along_z,
        torsion=stepped_torsional_frequencies(bar, count=count),
        axial=stepped_axial_frequencies(bar, count=count),
    )


def cantilever_frequencies(
    *,
    length: float,
    section: Section,
    young: float,
    poisson: float,
    density: float,
    count: int,
    theory: str = "timoshenko",
    shear: str | float = "cowper",
) -> Array:
    """Bending frequencies of a cantilever in both principal planes, merged.

    A square or round section gives each frequency twice. Twist and extension are not among them:
    `cantilever_spectrum` has those.

    Args:
        length: L [m].
        section: cross-section.
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].
        count: how many.
        theory: "timoshenko" or "euler-bernoulli".
        shear: rule of `Section.shear_coefficient`, or your own coefficient [-].

    Returns:
        Frequencies [Hz], (count,), ascending.

    Raises:
        BeamError: a length, theory, shear rule or count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        As `timoshenko_frequencies` and `euler_bernoulli_frequencies`.
    """
    spectrum = cantilever_spectrum(
        length=length,
        section=section,
        young=young,
        poisson=poisson,
        density=density,
        count=count,
        theory=theory,
        shear=shear,
    )
    return np.sort(np.concatenate([spectrum.bending_y, spectrum.bending_z]))[:count]
