"""The file of a reduced model: an archive whose force law decides which arrays it holds.

A law or a floating frame is read by the class of its kind: it names the arrays it needs, writes
them and takes them back. A new law is one more class in `FORCE_LAWS`.
"""

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.errors import DefoError, FileFormatError
from fenics_defo.runtime.archive import ArraySpec, read_archive, write_archive
from fenics_defo.runtime.floating.frame import FloatingFrame
from fenics_defo.runtime.forces import (
    CubatureForce,
    CubicForce,
    LinearForce,
    StoredLaw,
    TaylorForce,
)
from fenics_defo.runtime.metadata import json_text, parse_mapping
from fenics_defo.runtime.outputs import Outputs, Probe

KIND = "reduced model"
VERSION = 1

FORCE_LAWS: Mapping[str, type[StoredLaw]] = {
    law.kind: law for law in (LinearForce, CubicForce, TaylorForce, CubatureForce)
}
"""The laws that a file can hold, by the name that it gives."""

_FLOATING, _HELD = "floating", "none"
_UNITS = {
    "mass": "M = U^T M_full U; unit of shapes squared times kg",
    "damping": "1/s, s",
    "points": "m",
    "shapes": "m per unit of q",
    "gravity": "N per m/s^2, by unit of q",
    "loads": "J per unit of q",
    "probe_points": "m",
    "probe_shapes": "m per unit of q",
    "force_stiffness": "J per unit of q squared",
    "force_linear": "J per unit of q squared",
    "force_quadratic": "J per unit of q cubed",
    "force_cubic": "J per unit of q to the fourth",
    "force_weights": "m^3",
    "force_gradients": "1 per unit of q",
    "force_correction": "J per unit of q squared",
}
_CHOICES = {
    "format_version": ArraySpec("iu", 0),
    "force": ArraySpec("U", 0),
    "frame": ArraySpec("U", 0),
}
_ARRAYS = {
    "mass": ArraySpec("f", 2),
    "damping": ArraySpec("f", 1),
    "nodes": ArraySpec("iu", 1),
    "points": ArraySpec("f", 2),
    "shapes": ArraySpec("f", 3),
    "cells": ArraySpec("iu", 2),
    "cell_type": ArraySpec("U", 0),
    "gravity": ArraySpec("f", 2),
    "load_names": ArraySpec("U", 1),
    "loads": ArraySpec("f", 2),
    "probe_names": ArraySpec("U", 1),
    "probe_points": ArraySpec("f", 2),
    "probe_shapes": ArraySpec("f", 3),
    "provenance": ArraySpec("U", 0),
    "certificate": ArraySpec("U", 0),
}


def write_model(path: str | os.PathLike[str], fields: Mapping[str, Any]) -> None:
    """Write the fields of a `ReducedModel`: the same ones give the same bytes.

    Raises:
        DefoError: the file cannot be written, or the force law cannot be stored.
    """
    law, frame, outputs = fields["law"], fields["frame"], fields["outputs"]
    if type(law) is not FORCE_LAWS.get(law.kind):
        raise DefoError(
            f"{path}: a force law of the kind {law.kind!r} cannot be stored; the kinds that can "
            f"are {', '.join(FORCE_LAWS)}."
        )
    probes, loads, r = fields["probes"], fields["loads"], law.size
    arrays: dict[str, NDArray[Any]] = {
        "format_version": np.array(VERSION),
        "force": np.array(law.kind),
        "frame": np.array(_HELD if frame is None else _FLOATING),
        "mass": fields["mass"],
        "damping": np.array(fields["damping"]),
        "nodes": outputs.nodes,
        "points": outputs.points,
        "shapes": outputs.shapes,
        "cells": outputs.cells,
        "cell_type": np.array(outputs.cell_type),
        "gravity": fields["gravity_rows"],
        "load_names": np.array(list(loads), dtype=np.str_),
        "loads": np.array(list(loads.values())).reshape(-1, r),
        "probe_names": np.array(list(probes), dtype=np.str_),
        "probe_points": np.array([probe.point for probe in probes.values()]).reshape(-1, 3),
        "probe_shapes": np.array([probe.shapes for probe in probes.values()]).reshape(-1, 3, r),
        "provenance": np.array(json_text(fields["provenance"])),
        "certificate": np.array(json_text(fields["certificate"])),
    }
    arrays |= {f"force_{name}": array for name, array in law.arrays().items()}
    arrays |= {} if frame is None else frame.arrays()
    units = {
        name: unit for name, unit in {**_UNITS, **FloatingFrame.UNITS}.items() if name in arrays
    }
    write_archive(path, arrays, kind=KIND, version=VERSION, units=units)


def read_model(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the fields of a `ReducedModel`; nothing of the file is executed or unpickled.

    Raises:
        FileFormatError: the file is missing, damaged, from a newer version, or not of a model.
    """
    chosen = read_archive(path, kind=KIND, version=VERSION, required=_CHOICES)
    _check_version(path, int(chosen["format_version"]))
    law = _law(path, str(chosen["force"]))
    frame = str(chosen["frame"])
    if frame not in (_HELD, _FLOATING):
        raise FileFormatError(
            f"{path}: has a frame of the unknown kind {frame!r}; this package knows "
            f"{_HELD!r} and {_FLOATING!r}; update it, or write the file again."
        )
    required = _ARRAYS | {f"force_{name}": spec for name, spec in law.ARRAYS.items()}
    required |= FloatingFrame.ARRAYS if frame == _FLOATING else {}
    arrays = read_archive(path, kind=KIND, version=VERSION, required=required)
    try:
        return _fields(arrays, law, floats=frame == _FLOATING)
    except ValueError as error:
        raise FileFormatError(f"{path}: is inconsistent: {str(error).rstrip('.')}.") from error


def _check_version(path: str | os.PathLike[str], version: int) -> None:
    if version > VERSION:
        raise FileFormatError(
            f"{path}: has version {version} of the format of a reduced model, this package reads "
            f"up to version {VERSION}; update it."
        )
    if version < 1:
        raise FileFormatError(f"{path}: has the impossible version {version}; write it again.")


def _law(path: str | os.PathLike[str], kind: str) -> type[StoredLaw]:
    if kind not in FORCE_LAWS:
        raise FileFormatError(
            f"{path}: has a force law of the unknown kind {kind!r}; this package knows "
            f"{', '.join(FORCE_LAWS)}; update it, or write the file again."
        )
    return FORCE_LAWS[kind]


def _fields(
    arrays: Mapping[str, NDArray[Any]], law: type[StoredLaw], *, floats: bool
) -> dict[str, Any]:
    """Return the fields; ValueError if the arrays do not fit together."""
    outputs = {name: arrays[name] for name in ("nodes", "points", "shapes", "cells")}
    stored = {name: arrays[f"force_{name}"] for name in law.ARRAYS}
    probes = zip(arrays["probe_points"], arrays["probe_shapes"], strict=True)
    return {
        "law": law.from_arrays(stored),
        "mass": arrays["mass"],
        "outputs": Outputs(**outputs, cell_type=str(arrays["cell_type"])),
        "gravity_rows": arrays["gravity"],
        "damping": arrays["damping"],
        "probes": _by_name(
            arrays["probe_names"], (Probe(point=point, shapes=shapes) for point, shapes in probes)
        ),
        "loads": _by_name(arrays["load_names"], arrays["loads"]),
        "frame": FloatingFrame.from_arrays(arrays) if floats else None,
        "provenance": parse_mapping("provenance", str(arrays["provenance"])),
        "certificate": parse_mapping("certificate", str(arrays["certificate"])),
    }


def _by_name[T](names: NDArray[np.str_], values: Iterable[T]) -> dict[str, T]:
    found = dict(zip(names.tolist(), values, strict=True))
    if len(found) < names.size:
        raise ValueError(f"a name occurs twice in {names.tolist()}")
    return found
