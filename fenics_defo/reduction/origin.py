"""What a model was made of, in plain values that travel with it."""

import hashlib
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from fenics_defo import __version__
from fenics_defo.energy import Invertible, Law
from fenics_defo.fem import Solid
from fenics_defo.reduction.basis import Basis

# The names under which DOLFINx is installed: a wheel's, and its own.
_PACKAGES = ("dolfinx-solver-real", "fenics-dolfinx", "fenics-ufl", "numpy", "scipy")


def provenance(solid: Solid, basis: Basis, force: str, mass: str) -> dict[str, Any]:
    """Body, laws, basis and packages of a model.

    Args:
        solid: body.
        basis: its coordinates.
        force: name of the force law.
        mass: "consistent" or "lumped".
    """
    laws = solid.materials if isinstance(solid.materials, Mapping) else {None: solid.materials}
    return {
        "mesh": {
            "sha256": mesh_digest(solid),
            "nodes": len(solid.points),
            "cells": len(solid.cells),
            "cell_type": solid.nodes.cell_type,
            "order": solid.order,
        },
        "units": "SI: m, kg, s, N, Pa",
        "materials": [{"region": region, **_told(law)} for region, law in laws.items()],
        "held_components": int(solid.held.sum()),
        "basis": {
            "kind": basis.kind,
            "size": basis.size,
            "kept": basis.kept,
            "singular_values": None
            if basis.singular_values is None
            else basis.singular_values.tolist(),
            **basis.origin,
        },
        "force": force,
        "mass": mass,
        "packages": {"fenics-defo": __version__, **_versions()},
    }


def mesh_digest(solid: Solid) -> str:
    """SHA-256 of the nodes' places and the cells' nodes in the order of the user's file."""
    digest = hashlib.sha256()
    for array in (solid.points.astype("<f8"), solid.cells.astype("<i8")):
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _told(law: Law) -> dict[str, Any]:
    """A law by its name and its constants; of a field of cells, its ends."""
    inner: Any = law.material if isinstance(law, Invertible) else law
    told: dict[str, Any] = {"law": type(inner).__name__}
    if isinstance(law, Invertible):
        told["invertible_below"] = law.threshold
    for name, value in {**law.parameters, "density": law.density}.items():
        values = np.asarray(value)
        told[name] = (
            float(values)
            if values.ndim == 0
            else {"cells": len(values), "from": float(values.min()), "to": float(values.max())}
        )
    return told


def _versions() -> dict[str, str]:
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found
