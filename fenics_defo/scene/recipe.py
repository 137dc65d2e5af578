"""How a model is made of a scene's body: what was asked for, and what that means for the body."""

from dataclasses import dataclass, replace

from fenics_defo.energy import LinearElastic, StVenantKirchhoff
from fenics_defo.errors import SceneError
from fenics_defo.fem import Solid
from fenics_defo.reduction.reducing import check_force
from fenics_defo.scene.records import Scene

BASES = ("linear", "modal-derivatives", "snapshots")
FORCES = ("linear", "cubic", "taylor", "cubature")

LINEAR_MODES = 20
DERIVED_MODES = 8
SIZE = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """How a model is made; what is None is settled by the law of the body.

    Args:
        basis: one of `BASES`; modal derivatives for laws that are not linear, else modes.
        snapshots: folder of the results of `simulate` that the basis "snapshots" is made from.
        modes: number of elastic vibration modes that the basis is made from.
        size: number of fields r to keep; with ``share``, the most of them; of linear modes all, of
            others 20 if neither is given.
        share: share of the squares of all singular values to keep [-].
        force: one of `FORCES`; if not given, "linear" or "cubic" where the law is linear or St.
            Venant-Kirchhoff's, and "cubature" for all others.
        tolerance: relative error of the force at the poses that a cubature is trained at [-].

    Raises:
        SceneError: what does not go together.
    """

    basis: str | None = None
    snapshots: str | None = None
    modes: int | None = None
    size: int | None = None
    share: float | None = None
    force: str | None = None
    tolerance: float = 0.01

    def __post_init__(self) -> None:
        for name, options in (("basis", BASES), ("force", FORCES)):
            given = getattr(self, name)
            if given is not None and given not in options:
                raise SceneError(f"{name} must be one of {', '.join(options)}, got {given!r}")
        if (self.basis == "snapshots") != (self.snapshots is not None):
            raise SceneError(
                "a basis of snapshots and the folder that holds them belong together; write "
                "snapshots=DIR"
            )
        if self.snapshots is not None and self.modes is not None:
            raise SceneError("modes have no part in a basis of snapshots; leave --modes out")
        if not 0.0 < self.tolerance < 1.0:
            raise SceneError(f"tolerance must lie between 0 and 1, got {self.tolerance!r}")
        if self.share is not None and not 0.0 < self.share <= 1.0:
            raise SceneError(f"share must be above 0 and at most 1, got {self.share!r}")

    def settled(self, scene: Scene, solid: Solid) -> "Recipe":
        """The recipe for a body, with nothing left open.

        Raises:
            SceneError: what was asked for does not go with its law.
        """
        basis = self.basis or ("linear" if solid.is_linear else "modal-derivatives")
        if basis == "linear" and self.share is not None:
            raise SceneError(
                "linear modes are kept all or by their number, not by a share; give --size or "
                "--modes"
            )
        modes = self.modes
        if modes is None and basis != "snapshots":
            modes = DERIVED_MODES if basis == "modal-derivatives" else self.size or LINEAR_MODES
        size, share = self.size, self.share
        if size is None and share is None and basis != "linear":
            # All that is not round-off, but no more than that.
            size, share = SIZE, 1.0
        force = _force(scene, solid, self.force)
        return replace(self, basis=basis, modes=modes, size=size, share=share, force=force)


def _force(scene: Scene, solid: Solid, asked: str | None) -> str:
    """The force law, checked before anything is computed."""
    if asked is not None:
        check_force(asked)
    if asked is None and solid.is_linear:
        return "linear"
    laws = solid.materials.values() if isinstance(solid.materials, dict) else [solid.materials]
    others = [law for law in laws if not isinstance(law, StVenantKirchhoff | LinearElastic)]
    if not others:
        return asked or "cubic"
    if asked == "cubic":
        raise SceneError(
            f"{scene.path}: [[material]]: cubic forces are not exact for "
            f"{type(others[0]).__name__}; choose --force cubature, or --force taylor, the "
            'third-order Taylor polynomial at rest, or the law "st-venant-kirchhoff"'
        )
    return asked or "cubature"
