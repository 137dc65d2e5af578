"""How Newton's method ends unless the scene says it."""

from fenics_defo.scene.records import TimeTable

# An equilibrium may be far from the one before, and is the result itself.
_STATIC = 1e-8, 50
_DYNAMIC = 1e-6, 20


def newton_limits(time: TimeTable) -> tuple[float, int]:
    """Relative residual and most iterations of Newton's method."""
    tolerance, iterations = _STATIC if time.is_static else _DYNAMIC
    return time.tolerance or tolerance, iterations
