import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fenics_defo.errors import FileFormatError
from fenics_defo.runtime import CubicForce, LinearForce, Outputs, ReducedModel, TaylorForce, load
from fenics_defo.runtime.forces import StoredLaw
from fenics_defo.runtime.forces.symmetric import unique_count
from tests.unit.runtime.reduced_models import SIZE, make_frame, make_law, make_model

KINDS = ("linear", "cubic", "taylor")

Members = dict[str, NDArray[Any]]


def saved(path: Path, **changes: Any) -> Path:
    make_model(**changes).save(path)
    return path


def members_of(path: Path) -> Members:
    with np.load(path) as archive:
        return {name: archive[name] for name in archive.files}


def forge(path: Path, changes: Members, kind: str = "cubic", **fields: Any) -> Path:
    """A file that is sound as an archive, with members replaced."""
    members = members_of(saved(path, kind=kind, **fields)) | changes
    np.savez(path, **members)
    return path


def arrays_of(law: Any) -> Members:
    """The arrays of a law that came from or goes to a file."""
    found: Members = law.arrays()
    return found


def bits(model: ReducedModel) -> dict[str, Any]:
    """All that a model holds, to the last bit."""
    outputs, arrays = model.outputs, arrays_of(model.law)
    arrays |= {"mass": model.mass, "gravity": model.gravity_rows, "nodes": model.nodes}
    arrays |= {"points": model.points, "shapes": model.shapes, "cells": outputs.cells}
    arrays |= {f"load {name}": load for name, load in model.loads.items()}
    for name, probe in model.probes.items():
        arrays |= {f"probe {name}": probe.point, f"shapes of {name}": probe.shapes}
    arrays |= {} if model.frame is None else model.frame.arrays()
    found: dict[str, Any] = {
        name: (array.dtype.str, array.shape, array.tobytes()) for name, array in arrays.items()
    }
    found["names"] = (list(model.loads), list(model.probes))
    found["kinds"] = (type(model.law), outputs.cell_type, model.damping)
    found["words"] = (dict(model.provenance), dict(model.certificate))
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("flies", [False, True])
def test_round_trip_is_bitwise(tmp_path: Path, kind: str, flies: bool) -> None:
    model = make_model(kind, frame=make_frame() if flies else None)
    model.save(tmp_path / "model.npz")
    again = load(tmp_path / "model.npz")
    assert bits(again) == bits(model)
    q = np.random.default_rng(3).normal(size=SIZE)
    assert again.force(q).tobytes() == model.force(q).tobytes()


def test_a_model_without_anything_to_see_comes_back(tmp_path: Path) -> None:
    model = ReducedModel(law=make_law(), mass=np.eye(SIZE))
    model.save(tmp_path / "model.npz")
    assert bits(load(tmp_path / "model.npz")) == bits(model)


@pytest.mark.parametrize("kind", KINDS)
def test_same_model_gives_same_bytes(tmp_path: Path, kind: str) -> None:
    first = saved(tmp_path / "a.npz", kind=kind, provenance={"a": 1, "b": [2.5, None]})
    second = saved(tmp_path / "b.npz", kind=kind, provenance={"b": (2.5, None), "a": 1})
    assert first.read_bytes() == second.read_bytes()
    load(first).save(tmp_path / "c.npz")
    assert (tmp_path / "c.npz").read_bytes() == first.read_bytes()


def test_only_unique_coefficients_are_stored(tmp_path: Path) -> None:
    members = members_of(saved(tmp_path / "model.npz"))
    assert members["force_quadratic"].shape == (10,)  # 3 * 4 * 5 / 6
    assert members["force_cubic"].shape == (15,)  # 3 * 4 * 5 * 6 / 24


def test_plain_numpy_reads_what_the_file_says_of_itself(tmp_path: Path) -> None:
    members = members_of(saved(tmp_path / "model.npz", frame=make_frame()))
    assert int(members["format_version"]) == 1
    header = json.loads(str(members["header"]))
    assert header["kind"] == "reduced model"
    assert header["units"]["points"] == "m"
    assert header["units"]["frame_mass"] == "kg"
    assert json.loads(str(members["provenance"]))["mesh"] == "1f2e"
    assert json.loads(str(members["certificate"]))["note"] == "größer"
    assert members["probe_names"].tolist() == ["tip", "Mitte – 中"]


def refusal(path: Path) -> str:
    """The message of the refusal to load a file: one sentence that names the file."""
    with pytest.raises(FileFormatError) as caught:
        load(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert message.endswith(".")
    assert not message.endswith("..")
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"format_version": np.array(2)}, "has version 2 .* reads up to version 1; update it"),
        ({"format_version": np.array(0)}, "impossible version 0"),
        ({"format_version": np.array(2**64 - 1, dtype=np.uint64)}, "has version 1844674"),
        ({"format_version": np.array(1.0)}, "'format_version' has type float64"),
        ({"force": np.array("spectral")}, "law of the unknown kind 'spectral'; .* knows linear, "),
        ({"force": np.array("taylor\n\x1b[2J")}, r"unknown kind 'taylor\\n\\x1b\[2J'"),
        ({"force": np.array("linear")}, "'force_stiffness' is missing"),
        ({"frame": np.array("spinning")}, "frame of the unknown kind 'spinning'"),
        ({"frame": np.array("floating")}, "'frame_mass' is missing"),
        ({"mass": np.eye(4)}, r"mass must have the shape \(3, 3\), got \(4, 4\)"),
        ({"mass": -np.eye(3)}, "mass must be positive definite"),
        ({"mass": np.full((3, 3), np.nan)}, "'mass' holds values that are not finite"),
        ({"mass": np.triu(np.full((3, 3), 1e308))}, "mass must be symmetric"),
        ({"mass": np.zeros((0, 0))}, "mass must have the shape"),
        ({"damping": np.array([-1.0, 0.0])}, "damping must not be negative"),
        ({"damping": np.zeros(3)}, "damping must have the shape"),
        ({"force_cubic": np.zeros(16)}, r"cubic must have the shape \(15,\), got \(16,\)"),
        ({"force_quadratic": np.zeros(0)}, r"quadratic must have the shape \(10,\)"),
        ({"force_cubic": np.full(15, np.inf)}, "'force_cubic' holds values that are not finite"),
        ({"force_linear": np.zeros((0, 0))}, "linear must have the shape"),
        ({"force_linear": np.ones((3, 3), dtype=">i4")}, "'force_linear' has type"),
        ({"nodes": np.array([4, 3, 2, 1, 0])}, "nodes must ascend"),
        ({"nodes": np.array([0, 1, 2, 3, 2**63], dtype=np.uint64)}, "too large"),
        ({"shapes": np.zeros((5, 3, 4))}, "outputs has 4 coordinates, the force law has 3"),
        ({"cells": np.full((2, 4), 5)}, "cells name nodes outside"),
        ({"cells": np.full((2, 4), -(2**63))}, "cells name nodes outside"),
        ({"cell_type": np.array("tetra" * 999)}, "cell_type 'tetratetra"),
        ({"load_names": np.array(["push", "push"])}, "a name occurs twice"),
        ({"load_names": np.array(["push"])}, "is inconsistent: "),
        ({"load_names": np.array(["", "a"])}, "printable"),
        ({"load_names": np.array(["\x07", "a"])}, "printable"),
        ({"probe_shapes": np.zeros((2, 2, 3))}, "shapes of a probe must have the shape"),
        ({"probe_points": np.zeros((1, 3))}, "is inconsistent: "),
        ({"gravity": np.zeros((3, 4))}, "gravity_rows must have the shape"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(
    tmp_path: Path, changes: Members, expected: str
) -> None:
    message = refusal(forge(tmp_path / "model.npz", changes))
    assert re.search(expected, message), message


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[]",
        '"text"',
        "{",
        '{"a": NaN}',
        '{"a": -Infinity}',
        '{"a": 1e999}',
        '{"a": ' + "9" * 5000 + "}",
        '{"a": ' + "[" * 100_000 + "]" * 100_000 + "}",
        '{"a": "\\ud800"}',
        '{"\\udfff": 1}',
        "{'a': 1}",
        '{"a": 1} {}',
        '__import__("os")',
    ],
)
@pytest.mark.parametrize("name", ["provenance", "certificate"])
def test_hostile_words_are_refused(tmp_path: Path, name: str, text: str) -> None:
    assert name in refusal(forge(tmp_path / "model.npz", {name: np.array(text)}))


def test_letters_that_do_not_exist_are_refused(tmp_path: Path) -> None:
    """NumPy stores letters as 32-bit numbers, of which most are none."""
    path = forge(tmp_path / "model.npz", {"provenance": np.array("{}QQQQ")})
    data = path.read_bytes()
    letters = "QQQQ".encode("utf-32-le")
    assert letters in data
    broken = data.replace(letters, b"\xff\xff\xff\x7f" * 4)
    path.write_bytes(with_checksums(broken))
    refusal(path)


def with_checksums(data: bytes) -> bytes:
    """The archive with the checksums that its members' bytes have now."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(out, "w") as copy:
        for info in archive.infolist():
            info.CRC = zipfile.crc32(b"")  # type: ignore[attr-defined]
            begin = info.header_offset + 30 + len(info.filename.encode())
            begin += int.from_bytes(data[info.header_offset + 28 :][:2], "little")
            copy.writestr(info.filename, data[begin : begin + info.file_size])
    return out.getvalue()


def test_files_of_modes_and_of_others_are_refused(tmp_path: Path, make_modes: Any) -> None:
    make_modes().save(tmp_path / "modes.npz")
    assert "holds 'modes', expected 'reduced model'" in refusal(tmp_path / "modes.npz")
    np.savez(tmp_path / "other.npz", mass=np.eye(3))
    assert "not written by fenics_defo" in refusal(tmp_path / "other.npz")
    (tmp_path / "text.npz").write_text("model")
    refusal(tmp_path / "text.npz")
    assert "No such file" in refusal(tmp_path / "absent.npz")


def test_each_array_is_missed(tmp_path: Path) -> None:
    members = members_of(saved(tmp_path / "model.npz", frame=make_frame()))
    for absent in members:
        np.savez(tmp_path / "part.npz", **{n: a for n, a in members.items() if n != absent})
        message = refusal(tmp_path / "part.npz")
        assert absent == "header" or f"'{absent}' is missing" in message


def outcome(path: Path) -> ReducedModel | None:
    """The model, or None after a refusal by one sentence; no other exception passes."""
    message = ""
    try:
        return load(path)
    except FileFormatError as error:
        message = str(error)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return None


def test_no_truncated_file_is_loaded(tmp_path: Path) -> None:
    """Lengths around the ends of every member and of the directory, and many between."""
    path = saved(tmp_path / "model.npz", frame=make_frame())
    data = path.read_bytes()
    with zipfile.ZipFile(path) as archive:
        marks = [info.header_offset for info in archive.infolist()] + [archive.start_dir]
    lengths = {mark + shift for mark in marks for shift in (-1, 0, 1, 4, 30, 64)}
    lengths |= set(range(0, len(data), 97)) | {len(data) - n for n in range(1, 30)}
    for length in sorted(lengths):
        path.write_bytes(data[:length])
        refusal(path)


def test_flipped_bytes_are_found_or_harmless(tmp_path: Path) -> None:
    path = saved(tmp_path / "model.npz", frame=make_frame())
    intact = bits(load(path))
    data = path.read_bytes()
    rng = np.random.default_rng(11)
    refused = 0
    positions = range(0, len(data), 37)
    for position in positions:
        damaged = bytearray(data)
        damaged[position] ^= int(rng.integers(1, 256))
        path.write_bytes(damaged)
        found = outcome(path)
        refused += found is None
        assert found is None or bits(found) == intact
    assert refused > len(positions) // 2


def test_flipped_bytes_with_right_checksums_give_no_nan(tmp_path: Path) -> None:
    """An attacker mends the checksums: the model that is loaded then is finite all the same."""
    path = saved(tmp_path / "model.npz", kind="linear")
    data = path.read_bytes()
    rng = np.random.default_rng(12)
    loaded = 0
    for position in rng.choice(len(data), size=120, replace=False):
        damaged = bytearray(data)
        damaged[position] ^= int(rng.integers(1, 256))
        try:
            path.write_bytes(with_checksums(bytes(damaged)))
        except (zipfile.BadZipFile, NotImplementedError, ValueError, OSError):
            continue  # the directory itself was hit
        model = outcome(path)
        if model is not None:
            loaded += 1
            q = np.ones(SIZE)
            for array in (model.mass, model.force(q), model.displacement(q), model.gravity_rows):
                assert np.isfinite(array).all()
    assert loaded > 10


words = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.text()
    | st.floats(allow_nan=False, allow_infinity=False),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    r=st.integers(1, 4),
    nodes=st.sets(st.integers(0, 2**40), max_size=4),
    kind=st.sampled_from(KINDS),
    scale=st.floats(1e-12, 1e12),
    word=words,
    names=st.sets(st.text(min_size=1).filter(str.isprintable), max_size=3),
    seed=st.integers(0, 2**16),
)
def test_any_model_comes_back_bit_by_bit(
    tmp_path: Path,
    r: int,
    nodes: set[int],
    kind: str,
    scale: float,
    word: Any,
    names: set[str],
    seed: int,
) -> None:
    rng = np.random.default_rng(seed)
    law = random_law(kind, r, scale, rng)
    outputs = Outputs(
        nodes=np.array(sorted(nodes), dtype=np.int64),
        points=scale * rng.normal(size=(len(nodes), 3)),
        shapes=scale * rng.normal(size=(len(nodes), 3, r)),
    )
    model = ReducedModel(
        law=law,
        mass=scale * np.diag(rng.uniform(0.5, 1.0, r)),
        outputs=outputs,
        loads={name: rng.normal(size=r) for name in sorted(names)},
        provenance={"word": word},
    )
    model.save(tmp_path / "model.npz")
    assert bits(load(tmp_path / "model.npz")) == bits(model)


def random_law(kind: str, r: int, scale: float, rng: np.random.Generator) -> StoredLaw:
    if kind == "linear":
        return LinearForce(scale * np.eye(r))
    third, fourth = (scale * rng.normal(size=unique_count(r, order)) for order in (3, 4))
    law = {"cubic": CubicForce, "taylor": TaylorForce}[kind]
    return law.from_unique(scale * np.eye(r), third, fourth)
