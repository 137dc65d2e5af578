"""The candidates that a scene is tried with."""

from dataclasses import dataclass

from fenics_defo.energy import LinearElastic, StVenantKirchhoff
from fenics_defo.fem import Solid
from fenics_defo.scene.records import Scene
from fenics_defo.scene.trade.records import FILTER, FULL, REDUCED, Candidate, ModelSpec

# Fewest steps that a motion is followed by where its step is made longer.
_FEWEST_STEPS = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Extent:
    """How far a ladder reaches.

    Args:
        modes: sizes of models of vibration modes with linear forces.
        sizes: sizes of models with the forces of the body's law.
        plain: size of one such model of vibration modes alone; 0: none.
        training: sizes of such models made from the reference itself.
        cubatures: tolerances of cubatures.
        cubature_sizes: sizes of models with cubatures.
        factors: of the scene's step.
        integrators: for one size in the middle, besides the scene's.
        laws: other laws of the body at full order.
    """

    modes: tuple[int, ...] = (5, 10, 20, 40)
    sizes: tuple[int, ...] = (10, 20, 30)
    plain: int = 20
    training: tuple[int, ...] = (5, 10, 20)
    cubatures: tuple[float, ...] = (0.05, 0.01)
    cubature_sizes: tuple[int, ...] = (10, 20)
    factors: tuple[int, ...] = (1, 2, 4)
    integrators: tuple[str, ...] = ("implicit-newmark", "backward-euler", "central-differences")
    laws: tuple[str, ...] = ("corotational", "linear")


#: What `reduce` looks at when it is given no options.
SMALL = Extent(
    modes=(10, 20),
    plain=0,
    training=(),
    cubatures=(0.02,),
    cubature_sizes=(20,),
    factors=(1,),
    integrators=(),
    laws=(),
)


def ladder(scene: Scene, solid: Solid, extent: Extent) -> tuple[Candidate, ...]:
    """All candidates, those of full order first, then model by model.

    Args:
        scene: scene.
        solid: its body.
        extent: how far to go.
    """
    time, flies = scene.time, not solid.held.any()
    found = [
        Candidate(kind=FULL, integrator=time.integrator, step=time.step, law=law)
        for law in ("", *_other_laws(solid, extent.laws))
    ]
    factors = step_factors(scene, extent.factors)
    for spec in _models(solid, extent):
        kinds = [REDUCED]
        if spec.force == "linear" and not time.is_static and not flies:
            kinds.insert(0, FILTER)
        for kind in kinds:
            found += [
                Candidate(
                    kind=kind,
                    model=spec,
                    integrator="exact" if kind == FILTER else time.integrator,
                    step=factor * time.step,
                    factor=factor,
                )
                for factor in factors
            ]
        if spec == _middle(solid, extent) and not time.is_static and not flies:
            found += [
                Candidate(kind=REDUCED, model=spec, integrator=name, step=time.step)
                for name in extent.integrators
                if name != time.integrator
            ]
    return tuple(found)


def step_factors(scene: Scene, wanted: tuple[int, ...]) -> tuple[int, ...]:
    """The factors of the step that leave a motion enough steps."""
    if scene.time.is_static:
        return (1,)
    return tuple(n for n in wanted if n == 1 or scene.time.steps // n >= _FEWEST_STEPS)


def exact_force(solid: Solid) -> str:
    """The polynomial force of a body's law: exact ones where there are."""
    if solid.is_linear:
        return "linear"
    laws = [region.material for region in solid.fields.regions]
    return (
        "cubic"
        if all(isinstance(m, StVenantKirchhoff | LinearElastic) for m in laws)
        else ("taylor")
    )


def _models(solid: Solid, extent: Extent) -> list[ModelSpec]:
    most = int((~solid.held).sum())
    models = [ModelSpec(basis="linear", size=r, force="linear") for r in extent.modes]
    if not solid.is_linear:
        force = exact_force(solid)
        models += [ModelSpec(basis="modal-derivatives", size=r, force=force) for r in extent.sizes]
        if extent.plain:
            models.append(ModelSpec(basis="linear", size=extent.plain, force=force))
        models += [ModelSpec(basis="snapshots", size=r, force=force) for r in extent.training]
        models += [
            ModelSpec(basis="modal-derivatives", size=r, force="cubature", tolerance=tolerance)
            for r in extent.cubature_sizes
            for tolerance in extent.cubatures
        ]
    return [model for model in models if model.size <= most]


def _middle(solid: Solid, extent: Extent) -> ModelSpec | None:
    """The model that other methods are tried with."""
    sizes = extent.modes if solid.is_linear else extent.sizes
    if not sizes:
        return None
    size = sizes[len(sizes) // 2]
    if solid.is_linear:
        return ModelSpec(basis="linear", size=size, force="linear")
    return ModelSpec(basis="modal-derivatives", size=size, force=exact_force(solid))


def _other_laws(solid: Solid, wanted: tuple[str, ...]) -> list[str]:
    """Laws that the body could have instead of its own."""
    if solid.is_linear or not solid.is_isotropic_at_rest:
        return []
    own = {type(region.material).__name__.lower() for region in solid.fields.regions}
    return [law for law in wanted if own != {law}]
