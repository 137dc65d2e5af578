"""What a time integrator is asked for, and what it may use."""

from typing import TYPE_CHECKING, Protocol, runtime_checkable

if TYPE_CHECKING:
    from fenics_defo.analysis.instant import Instant
    from fenics_defo.analysis.system import System


@runtime_checkable
class Integrator(Protocol):
    """A method that carries the motion from one time to the next.

    A new one is one file with a frozen record that has these members: an implicit method writes
    acceleration and velocity as linear functions of the new displacement (`Rule`) and lets
    ``system.solve`` find it; an explicit one uses ``system.explicit_acceleration``.
    """

    @property
    def explicit(self) -> bool:
        """Whether it lumps the mass and solves no equations."""

    @property
    def end_weight(self) -> float:
        """Weight in the work of a step of the forces at its end; 1 minus it, at its start."""

    @property
    def keeps_energy(self) -> bool:
        """Whether the method itself takes no energy from a vibration."""

    @property
    def hidden_energy(self) -> float:
        """Largest c with which the method keeps T + U + c h²/2 a·M a of a linear body; 0 if none.

        T + U of a start with large accelerations may grow by that part without any error.
        """

    def critical_step(self, omega: float, damping: tuple[float, float]) -> float:
        """Largest stable step [s]; infinite for an unconditionally stable method.

        Args:
            omega: largest angular frequency of the body [rad/s].
            damping: Rayleigh's (alpha [1/s], beta [s]).
        """

    def advance(self, system: "System", start: "Instant", step: float) -> "Instant":
        """The motion ``step`` [s] after ``start``; collective.

        Raises:
            StepFailure: the equations were not solved, or a number is not finite.
        """
