"""Materials as data that a model file keeps, see `fenics_defo.runtime.laws.MaterialLaw`."""

from fenics_defo.energy.corotational import Corotational
from fenics_defo.energy.invertible import Invertible
from fenics_defo.energy.law import Law
from fenics_defo.energy.lowering import lower_general, lower_isotropic
from fenics_defo.energy.material import IsotropicMaterial, Material
from fenics_defo.errors import MaterialError
from fenics_defo.runtime.laws import MaterialLaw


def material_law(material: Law) -> MaterialLaw:
    """The law of a material, its parameters left open: as data, without UFL.

    Raises:
        MaterialError: springs have no energy at a point, and a law of the user's own kind that
            answers at points has no formula to store.
    """
    if isinstance(material, Corotational):
        return MaterialLaw(kind="corotational", names=("mu", "lmbda"), tangent=material.tangent)
    if isinstance(material, Invertible):
        lowered = lower_isotropic(material.material)
        return MaterialLaw(
            kind="invertible",
            names=lowered.names,
            listing=lowered.listing,
            tangent=material.tangent,
            threshold=material.threshold,
        )
    if isinstance(material, IsotropicMaterial):
        lowered = lower_isotropic(material)
        return MaterialLaw(kind="isotropic", names=lowered.names, listing=lowered.listing)
    if isinstance(material, Material):
        lowered = lower_general(material)
        return MaterialLaw(kind="general", names=lowered.names, listing=lowered.listing)
    raise MaterialError(
        f"{type(material).__name__} has no energy that a model file could hold; use a law with a "
        "strain energy, Corotational or Invertible"
    )
