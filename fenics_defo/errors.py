"""The errors that a user can cause; every message names the thing, the value and the next step."""


class DefoError(Exception):
    """Base of every error of this package that the user can mend."""


class MeshError(DefoError, ValueError):
    """A mesh cannot be read, or cannot carry a finite-element computation."""


class SelectionError(DefoError, LookupError):
    """A selection is not well formed, or matches nothing of the mesh."""


class MaterialError(DefoError, ValueError):
    """A material's constants are outside their range, or do not cover the mesh."""


class FileFormatError(DefoError, ValueError):
    """A file of ours is damaged, incomplete or of an unknown version."""


class SolverError(DefoError, RuntimeError):
    """A linear, nonlinear or eigenvalue solver did not deliver what was asked."""


class EigenSolveError(SolverError):
    """Eigenpairs are missing, unconverged or less accurate than required."""


class DivergenceError(SolverError):
    """A step or an equilibrium was not found; the last good state stands.

    Args:
        message: what the user reads.
        time: start of the step that failed [s], or the load factor reached.
        step: length of the last attempt [s].
        residuals: relative residuals of the last attempt.
        reason: a clause that says what went wrong in it.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float,
        step: float,
        residuals: tuple[float, ...] = (),
        reason: str = "",
    ) -> None:
        super().__init__(message)
        self.time = time
        self.step = step
        self.residuals = residuals
        self.reason = reason


class LoadError(DefoError, ValueError):
    """A load, a history, a prescribed motion or an initial state is not well formed."""


class StepSizeError(DefoError, ValueError):
    """A time step is not positive, or beyond what an explicit integrator stands."""


class MissingDependencyError(DefoError, ImportError):
    """A part of the package needs a library that is not installed."""
