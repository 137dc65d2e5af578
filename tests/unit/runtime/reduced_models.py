"""Small reduced models with random contents, for the tests of the record and of its file."""

from typing import Any

import numpy as np

from fenics_defo.runtime import (
    CubicForce,
    FloatingFrame,
    LinearForce,
    Outputs,
    Probe,
    ReducedModel,
    TaylorForce,
)
from fenics_defo.runtime.forces import StoredLaw
from fenics_defo.runtime.forces.symmetric import unique_count

SIZE = 3


def make_law(kind: str = "cubic", seed: int = 1) -> StoredLaw:
    rng = np.random.default_rng(seed)
    linear = np.diag([1.0, 4.0, 9.0])
    if kind == "linear":
        return LinearForce(linear)
    law = {"cubic": CubicForce, "taylor": TaylorForce}[kind]
    third, fourth = (rng.normal(size=unique_count(SIZE, order)) for order in (3, 4))
    return law.from_unique(linear, third, fourth)


def make_frame(seed: int = 2) -> FloatingFrame:
    """Integrals of twelve particles."""
    rng = np.random.default_rng(seed)
    places, shapes = rng.normal(size=(12, 3)), rng.normal(size=(12, 3, SIZE))
    axes = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    return FloatingFrame(
        mass=12.0,
        centre=places.mean(axis=0),
        second_moment=places.T @ places,
        mean=shapes.mean(axis=0),
        linear=np.einsum("pa,pbi->abi", places, shapes),
        quadratic=np.stack([shapes[:, a].T @ shapes[:, b] for a, b in axes]),
    )


def make_model(kind: str = "cubic", **changes: Any) -> ReducedModel:
    """A model of five stored nodes; keywords replace fields."""
    rng = np.random.default_rng(7)
    root = rng.normal(size=(SIZE, SIZE))
    fields: dict[str, Any] = {
        "law": make_law(kind),
        "mass": root @ root.T + np.eye(SIZE),
        "outputs": Outputs(
            nodes=np.array([0, 2, 3, 7, 11]),
            points=rng.normal(size=(5, 3)),
            shapes=rng.normal(size=(5, 3, SIZE)),
            cells=np.array([[0, 1, 2, 3], [4, 1, 2, 3]]),
            cell_type="tetra",
        ),
        "gravity_rows": rng.normal(size=(3, SIZE)),
        "damping": (0.25, 1e-4),
        "probes": {
            "tip": Probe(point=rng.normal(size=3), shapes=rng.normal(size=(3, SIZE))),
            "Mitte – 中": Probe(point=rng.normal(size=3), shapes=rng.normal(size=(3, SIZE))),
        },
        "loads": {"push": rng.normal(size=SIZE), "wind 2": rng.normal(size=SIZE)},
        "provenance": {"mesh": "1f2e", "materials": [{"law": "st-venant-kirchhoff", "young": 1e7}]},
        "certificate": {"range": [0.1, 0.2], "held_out": None, "note": "größer"},
    }
    return ReducedModel(**(fields | changes))
