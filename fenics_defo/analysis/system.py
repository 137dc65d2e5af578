"""The equations of motion of a body on this rank's own nodes."""

from fenics_defo.analysis.instant import Instant, Rule


class System:
    """M a + C v + f(u) = g(t, u), evaluated and solved."""

    def solve(self, start: Instant, step: float, rule: Rule) -> Instant:
        """The instant at which the equations hold."""
        raise NotImplementedError
