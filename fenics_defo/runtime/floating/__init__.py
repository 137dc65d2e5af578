"""Free-flying reduced bodies: a floating frame that turns and moves while the body deforms in it.

A point of the body lies at x = c + R (X + U q): centre of mass c, rotation R, place X in the rest
shape relative to its centre of mass, shapes U and their coordinates q. `FloatingFrame` holds the
integrals of mass that the inertia forces of this motion need, `FloatingBody` moves it.
"""

from fenics_defo.runtime.floating.body import Coupling, FloatingBody
from fenics_defo.runtime.floating.conserved import FloatingEnergies
from fenics_defo.runtime.floating.frame import FloatingFrame

__all__ = [
    "Coupling",
    "FloatingBody",
    "FloatingEnergies",
    "FloatingFrame",
]
