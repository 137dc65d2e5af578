"""The triangular product against NumPy, and MUMPS's use of it."""

import ctypes
import ctypes.util
import itertools
import os
import subprocess
import sys
from pathlib import Path

import dolfinx_solver
import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo.fem import compat, gemmt

Array = NDArray[np.float64]
Gemmt = ctypes.CDLL

OPENBLAS = Path(dolfinx_solver.__file__).with_name("lib") / "libopenblas.so.0"


@pytest.fixture(scope="module")
def fast() -> Gemmt:
    return gemmt.load(gemmt.build(), OPENBLAS)


def update(
    fast: Gemmt, uplo: str, trans: str, alpha: float, beta: float, a: Array, b: Array, c: Array
) -> Array:
    """C with its triangle updated; ``a`` and ``b`` as stored, a row of padding below each."""
    n = len(c)
    k = a.shape[1] if trans[0] in "Nn" else a.shape[0]

    def padded(x: Array) -> Array:
        return np.asfortranarray(np.vstack([x, np.full((1, x.shape[1]), np.nan)]))

    stored = [padded(a), padded(b), padded(c)]
    integers = {"n": n, "k": k} | {f"ld{i}": len(x) for i, x in enumerate(stored)}
    i = {name: ctypes.byref(ctypes.c_int(value)) for name, value in integers.items()}
    p = [x.ctypes.data_as(ctypes.c_void_p) for x in stored]
    flags = [ctypes.c_char_p(letter.encode()) for letter in (uplo, *trans)]
    scale = [ctypes.byref(ctypes.c_double(value)) for value in (alpha, beta)]
    fast.dgemmt_(
        *flags, i["n"], i["k"], scale[0], p[0], i["ld0"], p[1], i["ld1"], scale[1], p[2], i["ld2"]
    )
    assert np.isnan(stored[2][n]).all()
    return stored[2][:n]


@pytest.mark.parametrize(
    ("n", "k"), [(1, 1), (7, 3), (95, 5), (96, 5), (97, 0), (97, 5), (200, 130)]
)
def test_equals_numpy_and_leaves_the_other_triangle(fast: Gemmt, n: int, k: int) -> None:
    rng = np.random.default_rng(n + k)
    left, right, start = (rng.standard_normal(s) for s in ((n, k), (k, n), (n, n)))
    cases = itertools.product("UuLl", "NTc", "nTC", (0.0, 1.0, -0.7), (0.0, 1.0, 0.3))
    for uplo, ta, tb, alpha, beta in cases:
        a = left if ta in "Nn" else left.T
        b = right if tb in "Nn" else right.T
        c = start.copy()
        mine = np.triu if uplo in "Uu" else np.tril
        if beta == 0.0:  # C need not be set then
            c[mine(np.ones((n, n), bool))] = np.nan
        got = update(fast, uplo, ta + tb, alpha, beta, a, b, c)
        triangle = mine(np.ones((n, n), bool))
        wanted = alpha * left @ right + (0.0 if beta == 0.0 else beta * start)
        np.testing.assert_allclose(got[triangle], wanted[triangle], atol=1e-12)
        np.testing.assert_array_equal(got[~triangle], start[~triangle])


def test_an_empty_matrix_is_left_alone(fast: Gemmt) -> None:
    empty = np.zeros((0, 0))
    assert update(fast, "U", "NN", 1.0, 0.0, np.zeros((0, 3)), np.zeros((3, 0)), empty).size == 0


def test_petsc_binds_to_it() -> None:
    assert compat.FAST_GEMMT
    address = ctypes.cast(ctypes.CDLL(None).dgemmt_, ctypes.c_void_p).value
    ours = gemmt.load(gemmt.build(), OPENBLAS)
    assert address == ctypes.cast(ours.dgemmt_, ctypes.c_void_p).value


@pytest.mark.parametrize(("setting", "used"), [("0", False), ("1", True)])
def test_mumps_calls_it_unless_switched_off(setting: str, used: bool) -> None:
    """A factorisation that the routine's own ``dgemm`` pointer counts."""
    code = f"""
import ctypes, numpy as np
from fenics_defo.fem import compat, gemmt
from fenics_defo.fem.compat import PETSc
assert compat.FAST_GEMMT is {used}
calls = []
if {used}:
    library = gemmt.load(gemmt.build(), __import__("pathlib").Path({str(OPENBLAS)!r}))
    plain = ctypes.CDLL({str(OPENBLAS)!r}).dgemm_
    kind = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 13)
    counted = kind(lambda *a: (calls.append(1), plain(*map(ctypes.c_void_p, a)))[0] and None)
    library.fenics_defo_set_dgemm(ctypes.cast(counted, ctypes.c_void_p))
n = 300
dense = np.eye(n) * n + np.ones((n, n))
K = PETSc.Mat().createAIJ((n, n), nnz=n)
K.setValues(range(n), range(n), dense)
K.assemble()
K.setOption(PETSc.Mat.Option.SPD, True)
solver = PETSc.KSP().create()
solver.setOperators(K)
solver.setType("preonly")
solver.getPC().setType("cholesky")
solver.getPC().setFactorSolverType("mumps")
x, b = K.createVecs()
b.set(2.0 * n)
solver.solve(b, x)
assert np.allclose(x.array, 1.0), x.array
assert bool(calls) is {used}, len(calls)
"""
    subprocess.run(
        [sys.executable, "-c", code], check=True, env={**os.environ, "FENICS_DEFO_GEMMT": setting}
    )


def test_it_is_built_once(tmp_path: Path) -> None:
    first = gemmt.build(tmp_path / "cache")
    written = first.stat().st_mtime_ns
    assert gemmt.build(tmp_path / "cache").stat().st_mtime_ns == written
    assert list(first.parent.iterdir()) == [first]


@pytest.mark.parametrize("compiler", ["no-such-compiler-anywhere", "false"])
def test_without_a_compiler_openblas_stays(
    compiler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", compiler)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert gemmt.install(OPENBLAS.parent) is False
    assert list((tmp_path / "fenics").iterdir()) == []


def test_without_a_writable_cache_openblas_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder can be made here")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert gemmt.install(OPENBLAS.parent) is False


def test_a_damaged_library_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    gemmt.build().write_bytes(b"cut off")
    assert gemmt.install(OPENBLAS.parent) is False


def test_a_folder_without_openblas_changes_nothing(tmp_path: Path) -> None:
    assert gemmt.install(tmp_path) is False


def test_nothing_is_loaded_where_dgemm_is_missing(tmp_path: Path) -> None:
    other = ctypes.util.find_library("m")
    with pytest.raises(AttributeError):
        gemmt.load(tmp_path / "never-looked-at.so", Path(str(other)))
