"""Free vibrations of a homogeneous elastic solid sphere (Lamb 1882).

With xi = k_T a the shear and eta = k_L a the pressure wave number times the radius, the surface is
free of traction when, for spherical harmonics of degree n,

    torsional, n >= 1:   (n - 1) j_n(xi) - xi j_{n+1}(xi) = 0
    radial, n = 0:       xi^2 j_0(eta) - 4 eta j_1(eta) = 0
    spheroidal, n >= 1:  a d - b c = 0, where
        a = (n^2 - n - xi^2/2) j_n(eta) + 2 eta j_{n+1}(eta)
        b = n (n + 1) ((n - 1) j_n(xi) - xi j_{n+1}(xi))
        c = (n - 1) j_n(eta) - eta j_{n+1}(eta)
        d = (n^2 - 1 - xi^2/2) j_n(xi) + xi j_{n+1}(xi)

Each root belongs to 2 n + 1 modes.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar
from scipy.special import spherical_jn

from fenics_defo.beams.checks import (
    require_count,
    require_modulus,
    require_positive,
    shear_modulus,
)

type Array = NDArray[np.float64]

# Scan step in xi. Neighbouring roots of one degree and family are of the order of pi apart, except
# where a pressure and a shear overtone meet; a pair inside one step shows as an extremum.
_STEP = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class SphereModes:
    """Distinct frequencies of a free sphere, ascending.

    Args:
        frequencies: [Hz], (count,).
        families: "torsional" or "spheroidal" (radial modes are spheroidal of degree 0), (count,).
        degrees: n of the spherical harmonic, (count,).
        overtones: 0 for the lowest of its family and degree, (count,).
        wave_numbers: xi = omega a / c_T [-], (count,).
    """

    frequencies: Array
    families: tuple[str, ...]
    degrees: NDArray[np.int64]
    overtones: NDArray[np.int64]
    wave_numbers: Array

    @property
    def multiplicities(self) -> NDArray[np.int64]:
        """2 n + 1, the number of independent modes of each frequency, (count,)."""
        return 2 * self.degrees + 1

    def repeated(self) -> Array:
        """Each frequency as often as it has modes [Hz], (sum of multiplicities,), ascending."""
        return np.repeat(self.frequencies, self.multiplicities)


def sphere_frequencies(
    *, radius: float, young: float, poisson: float, density: float, count: int
) -> SphereModes:
    """Lowest distinct natural frequencies of a free homogeneous isotropic sphere.

    f = xi c_T / (2 pi a), c_T = sqrt(G / rho), with xi the roots of the equations in the module's
    description. The six rigid motions are left out.

    Args:
        radius: a [m].
        young: E [Pa].
        poisson: Poisson's ratio [-].
        density: rho [kg/m^3].
        count: how many distinct frequencies.

    Returns:
        Frequencies with their family, degree and overtone.

    Raises:
        BeamError: the radius or the count is not allowed.
        MaterialError: a material constant is out of range.

    References:
        Lamb, Proc. London Math. Soc. 13 (1882) 189; Eringen and Suhubi, Elastodynamics, vol. 2,
        chapter 8; Sato and Usami, Geophys. Mag. 31 (1962) 15.
    """
    size = require_positive("radius", radius, unit="m")
    speed = np.sqrt(
        shear_modulus(young, poisson) / require_modulus("density", density, unit="kg/m^3")
    )
    wanted = require_count(count)
    # c_T / c_L of an isotropic solid.
    slowness = float(np.sqrt((1.0 - 2.0 * poisson) / (2.0 - 2.0 * poisson)))
    # The roots below xi are about 0.3 xi^2 in number.
    limit = 4.0 + 1.7 * np.sqrt(wanted)
    while len(found := _modes_below(limit, slowness)) < wanted:
        limit *= 1.25
    lowest = sorted(found)[:wanted]
    wave_numbers = np.array([mode[0] for mode in lowest])
    return SphereModes(
        frequencies=wave_numbers * speed / (2.0 * np.pi * size),
        families=tuple(mode[1] for mode in lowest),
        degrees=np.array([mode[2] for mode in lowest], dtype=np.int64),
        overtones=np.array([mode[3] for mode in lowest], dtype=np.int64),
        wave_numbers=wave_numbers,
    )


def torsional_equation(degree: int, xi: Array) -> Array:
    """Left side of the torsional frequency equation, divided by the size of j_n(xi)."""
    value, ahead = _bessel(degree, xi)
    return (degree - 1) * value - xi * ahead


def spheroidal_equation(degree: int, xi: Array, *, slowness: float) -> Array:
    """Left side of the spheroidal frequency equation, divided by the size of the j_n.

    Args:
        degree: n, from 0.
        xi: omega a / c_T, positive.
        slowness: c_T / c_L, so that eta = slowness xi.
    """
    n, eta = degree, slowness * xi
    pressure, pressure_ahead = _bessel(n, eta)
    if n == 0:
        return xi**2 * pressure - 4.0 * eta * pressure_ahead
    shear, shear_ahead = _bessel(n, xi)
    a = (n * n - n - 0.5 * xi**2) * pressure + 2.0 * eta * pressure_ahead
    b = n * (n + 1) * ((n - 1) * shear - xi * shear_ahead)
    c = (n - 1) * pressure - eta * pressure_ahead
    d = (n * n - 1 - 0.5 * xi**2) * shear + xi * shear_ahead
    return a * d - b * c


def _bessel(degree: int, x: Array) -> tuple[Array, Array]:
    """j_n and j_{n+1} divided by their root of the sum of squares, which has no zero."""
    value, ahead = spherical_jn(degree, x), spherical_jn(degree + 1, x)
    size = np.hypot(value, ahead)
    return value / size, ahead / size


def _modes_below(limit: float, slowness: float) -> list[tuple[float, str, int, int]]:
    """(xi, family, degree, overtone) of every root below ``limit``.

    The lowest root of a family grows with the degree from n = 2 on, so that the first degree
    without any ends the search.
    """
    modes: list[tuple[float, str, int, int]] = []
    degree = 0
    while True:
        roots = {"spheroidal": _roots(_spheroidal(degree, slowness), degree, limit)}
        if degree > 0:
            roots["torsional"] = _roots(_torsional(degree), degree, limit)
        for family, values in roots.items():
            modes += [(xi, family, degree, overtone) for overtone, xi in enumerate(values)]
        if degree > 2 and not any(roots.values()):
            return modes
        degree += 1


def _torsional(degree: int) -> Callable[[Array], Array]:
    return lambda xi: torsional_equation(degree, xi)


def _spheroidal(degree: int, slowness: float) -> Callable[[Array], Array]:
    return lambda xi: spheroidal_equation(degree, xi, slowness=slowness)


def _roots(equation: Callable[[Array], Array], degree: int, limit: float) -> list[float]:
    """All roots in (0, limit) of a smooth equation, pairs closer than the step included."""
    # j_n(x) leaves the range of doubles for x << n; no root lies below about 0.6 n for n > 2.
    start = _STEP * max(1.0, np.floor(0.3 * max(degree - 2, 0) / _STEP))
    if start >= limit:
        return []
    grid = np.append(np.arange(start, limit, _STEP), limit)
    values = equation(grid)
    edges = list(grid)
    size = np.abs(values)
    turning = (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])
    same = (values[1:-1] * values[:-2] > 0.0) & (values[1:-1] * values[2:] > 0.0)
    for i in np.flatnonzero(turning & same) + 1:
        sign = np.sign(values[i])
        dip = minimize_scalar(
            lambda xi, sign=sign: float(sign * equation(np.array(xi))),
            bounds=(grid[i - 1], grid[i + 1]),
            method="bounded",
        )
        edges.append(float(dip.x))
    edges.sort()
    ends = equation(np.array(edges))
    return [
        float(brentq(lambda xi: float(equation(np.array(xi))), edges[i], edges[i + 1], xtol=1e-14))
        for i in np.flatnonzero(ends[:-1] * ends[1:] < 0.0)
    ]
