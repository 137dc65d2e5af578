"""Several material laws and their points as a few flat arrays."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.runtime.archive import ArraySpec
from fenics_defo.runtime.laws import MaterialLaw

Array = NDArray[np.float64]

#: What `unpack_laws` needs in an archive.
LAW_ARRAYS: Mapping[str, ArraySpec] = {
    "law_points": ArraySpec("iu", 1),
    "law_kinds": ArraySpec("U", 1),
    "law_tangents": ArraySpec("U", 1),
    "law_thresholds": ArraySpec("f", 1),
    "law_parameters": ArraySpec("f", 1),
    "law_inputs": ArraySpec("iu", 1),
    "law_names": ArraySpec("U", 1),
    "law_constants": ArraySpec("f", 1),
    "law_codes": ArraySpec("iu", 1),
    "law_operands": ArraySpec("iu", 2),
    "law_outputs": ArraySpec("iu", 1),
    "law_lengths": ArraySpec("iu", 2),
}

#: What a law has a number of, the columns of ``law_lengths``.
_PARTS = ("names", "constants", "codes", "operands", "outputs")


def pack_laws(
    laws: Sequence[MaterialLaw], counts: Sequence[int], parameters: Sequence[Array]
) -> dict[str, NDArray[Any]]:
    """The arrays of `LAW_ARRAYS`: those of the laws, one after the other, and their lengths."""
    tables = [law.arrays() for law in laws]
    packed: dict[str, NDArray[Any]] = {
        "law_points": np.array(counts, np.int64),
        "law_kinds": np.array([law.kind for law in laws]),
        "law_tangents": np.array([law.tangent for law in laws]),
        "law_thresholds": np.array([law.threshold for law in laws], np.float64),
        "law_parameters": np.concatenate([values.ravel() for values in parameters]),
        "law_inputs": np.array([int(table["inputs"]) for table in tables], np.int64),
        "law_lengths": np.array([[len(t[p]) for p in _PARTS] for t in tables], np.int64),
    }
    names = [name for law in laws for name in law.names]
    packed["law_names"] = np.array(names, dtype="U1" if not any(names) else None)
    for part in _PARTS[1:]:
        packed[f"law_{part}"] = np.concatenate([table[part] for table in tables])
    return {name: packed[name] for name in LAW_ARRAYS}


def unpack_laws(
    arrays: Mapping[str, NDArray[Any]],
) -> tuple[tuple[MaterialLaw, ...], tuple[int, ...], tuple[Array, ...]]:
    """Laws, number of points and parameters of each, from the arrays of `pack_laws`.

    Raises:
        ValueError: they do not fit together.
        FileFormatError: a law is not known, or not fit to run.
    """
    number = len(arrays["law_points"])
    per_law = ("law_kinds", "law_tangents", "law_thresholds", "law_inputs", "law_lengths")
    lengths = np.asarray(arrays["law_lengths"], np.int64)
    if any(len(arrays[name]) != number for name in per_law) or lengths.shape[1:] != (len(_PARTS),):
        raise ValueError("the tables of the material laws have different lengths")
    pieces = {
        part: _split(arrays[f"law_{part}"], lengths[:, column])
        for column, part in enumerate(_PARTS)
    }
    laws = tuple(
        MaterialLaw.from_arrays(
            {
                "kind": arrays["law_kinds"][row],
                "tangent": arrays["law_tangents"][row],
                "threshold": arrays["law_thresholds"][row],
                "inputs": arrays["law_inputs"][row],
                **{part: pieces[part][row] for part in _PARTS},
            }
        )
        for row in range(number)
    )
    counts = tuple(int(count) for count in arrays["law_points"])
    sizes = [len(law.names) * count for law, count in zip(laws, counts, strict=True)]
    parameters = _split(arrays["law_parameters"], np.array(sizes, np.int64))
    shaped = tuple(
        values.reshape(len(law.names), count)
        for law, count, values in zip(laws, counts, parameters, strict=True)
    )
    return laws, counts, shaped


def _split(array: NDArray[Any], lengths: NDArray[np.int64]) -> list[NDArray[Any]]:
    if (lengths < 0).any() or lengths.sum() != len(array):
        raise ValueError("a table of the material laws has not the length that it should have")
    return np.split(array, np.cumsum(lengths)[:-1])
