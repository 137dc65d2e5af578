"""The same models on any number of ranks: ``python -m ...tabulations_on_ranks FILE.npz``."""

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.analysis import Gravity, PointLoad, Traction, linear_modes
from fenics_defo.energy import Corotational, LinearElastic, NeoHookean
from fenics_defo.errors import MaterialError
from fenics_defo.fem import Solid
from fenics_defo.fem.compat import MPI
from fenics_defo.reduction import (
    basis_from_array,
    modal_derivative_basis,
    reduce,
    tabulate_cubic,
    taylor_force,
)
from fenics_defo.runtime import ReducedModel
from tests.unit.fem.fem_bodies import MODULI
from tests.unit.reduction.tabulated_bodies import (
    SOFT,
    bent_body,
    coordinates,
    end_node,
    smooth_shapes,
)

Array = NDArray[Any]
COMM = MPI.COMM_WORLD


def on_all_ranks(values: Any) -> Array:
    """The values, which must be the same on each rank."""
    array = np.asarray(values)
    for other in COMM.allgather(array):
        np.testing.assert_array_equal(other, array)
    return array


def numbers(model: ReducedModel) -> dict[str, Array]:
    found = {
        "mass": model.mass,
        "gravity": model.gravity_rows,
        "shapes": model.shapes,
        **{f"load {name}": load for name, load in model.loads.items()},
        **{f"probe {name}": probe.shapes for name, probe in model.probes.items()},
    }
    if model.law.kind != "direct":
        found |= {f"force {name}": array for name, array in model.law.arrays().items()}
    else:
        q = coordinates(np.moveaxis(model.shapes, 2, 0), 0.1)
        found |= {"f": model.force(q), "K": model.stiffness(q), "W": model.energy(q)}
    return {name: on_all_ranks(array) for name, array in found.items()}


def everything() -> dict[str, Array]:
    """Arrays of all models, by force and name."""
    laws = {
        "linear": SOFT,
        "cubic": {None: SOFT, "x>0.7": LinearElastic(**MODULI)},
        "taylor": NeoHookean(**MODULI),
        "direct": {None: SOFT, "x>0.7": Corotational(**MODULI)},
    }
    found = {}
    for force, law in laws.items():
        solid = bent_body(law)
        model = reduce(
            solid,
            basis_from_array(solid, smooth_shapes(solid, 5)),
            force,  # type: ignore[arg-type]
            loads={
                "weight": Gravity(),
                "pull": PointLoad(node=end_node(solid), vector=(1.0, 2.0, 3.0)),
                "side": Traction("x>=0", (1.0, 0.0, 2.0)),
            },
            probes={"end": solid.points[end_node(solid)]},
            mass="lumped" if force == "direct" else "consistent",
        )
        found |= {f"{force}/{name}": array for name, array in numbers(model).items()}
        if "reach_m" in model.certificate["force"]:
            found[f"{force}/reach"] = on_all_ranks(model.certificate["force"]["reach_m"])
    found["derivatives/f"] = own_basis()
    found["messages"] = np.array(COMM.allgather(messages()))
    return found


def own_basis() -> Array:
    """Forces of a model that is computed from the modes on: what no choice of a basis changes."""
    solid = bent_body(SOFT)
    basis = modal_derivative_basis(solid, linear_modes(solid, 3), size=9)
    model = reduce(solid, basis)
    load = PointLoad(point=tuple(solid.points[end_node(solid)]), vector=(0.0, 20.0, 10.0))
    force = reduce(solid, basis, loads=[load]).load("point")
    q = np.zeros(basis.size)
    for _ in range(20):
        q -= np.linalg.solve(model.stiffness(q), model.force(q) - force)
    assert np.abs(model.force(q) - force).max() < 1e-10 * np.abs(force).max()
    return on_all_ranks(model.displacement(q))


def messages() -> str:
    """What each rank hears where one rank alone may have the cells at fault."""
    solid: Solid = bent_body({None: SOFT, "x>1.1": NeoHookean(**MODULI)})
    try:
        tabulate_cubic(solid, smooth_shapes(solid, 2))
    except MaterialError as error:
        first = str(error)
    solid = bent_body({None: SOFT, "x>1.1": Corotational(**MODULI)})
    try:
        taylor_force(solid, smooth_shapes(solid, 2))
    except MaterialError as error:
        return f"{first} | {error}"
    return "no error"


if __name__ == "__main__":
    kept = everything()
    if COMM.rank == 0:
        np.savez(sys.argv[1], **kept)  # type: ignore[arg-type]
