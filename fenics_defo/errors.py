"""The errors that a user can cause; every message names the thing, the value and the next step."""


class DefoError(Exception):
    """Base of every error of this package that the user can mend."""


class MeshError(DefoError, ValueError):
    """A mesh cannot be read, or cannot carry a finite-element computation."""


class SelectionError(DefoError, LookupError):
    """A selection is not well formed, or matches nothing of the mesh."""


class MaterialError(DefoError, ValueError):
    """A material's constants are outside their range, or do not cover the mesh."""


class SceneError(DefoError, ValueError):
    """A scene file is not as the schema wants it, or asks for what its mesh cannot give."""


class FileFormatError(DefoError, ValueError):
    """A file of ours is damaged, incomplete or of an unknown version."""


class SolverError(DefoError, RuntimeError):
    """A linear, nonlinear or eigenvalue solver did not deliver what was asked."""


class EigenSolveError(SolverError):
    """Eigenpairs are missing, unconverged or less accurate than required."""


class MissingDependencyError(DefoError, ImportError):
    """A part of the package needs a library that is not installed."""
