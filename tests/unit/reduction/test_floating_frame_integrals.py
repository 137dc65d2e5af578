"""Integrals of mass of free bodies against their mass matrices."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fenics_defo import fem
from fenics_defo.energy import LinearElastic
from fenics_defo.errors import DefoError
from fenics_defo.fem import Solid
from fenics_defo.reduction.floating_frame import inertia_integrals

type Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent
POINTS = np.array([(0, 0, 0), (2, 0, 0), (0.3, 1, 0), (0, 0.1, 0.7), (2, 1.5, 1), (0.5, 1, 1.9)])
CELLS = np.array([(0, 1, 2, 3), (1, 2, 3, 4), (2, 3, 4, 5)])
NAMES = ("mass", "centre", "second_moment", "mean", "linear", "quadratic")


def body(order: int = 1, **options: Any) -> Solid:
    """Three tetrahedra, one of them heavier."""
    light, heavy = (LinearElastic(young=1.0, poisson=0.0, density=d) for d in (1.3, 5.0))
    mesh = fem.build_mesh(POINTS, CELLS)
    return Solid(mesh, {"x<0.8": light, None: heavy}, order=order, **options)


def some_shapes(solid: Solid, size: int = 3) -> Array:
    return np.random.default_rng(5).normal(size=(size, *solid.points.shape))


def by_the_mass_matrix(solid: Solid, shapes: Array) -> dict[str, Array]:
    """The integrals from the whole mass matrix, whose blocks are those of one scalar matrix."""
    m = solid.mass().toarray()[::3, ::3]
    total = m.sum()
    centre = m.sum(axis=0) @ solid.points / total
    mean = np.einsum("n,rnc->cr", m.sum(axis=0), shapes) / total
    x, u = solid.points - centre, shapes - mean.T[:, None]
    pairs = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    return {
        "mass": total,
        "centre": centre,
        "second_moment": x.T @ m @ x,
        "mean": mean,
        "linear": np.einsum("na,nm,rmb->abr", x, m, u),
        "quadratic": np.stack([u[:, :, a] @ m @ u[:, :, b].T for a, b in pairs]),
    }


@pytest.mark.parametrize("order", [1, 2])
def test_integrals(order: int) -> None:
    solid = body(order)
    shapes = some_shapes(solid)
    frame = inertia_integrals(solid, shapes)
    for name, expected in by_the_mass_matrix(solid, shapes).items():
        scale = np.abs(expected).max()
        assert getattr(frame, name) == pytest.approx(expected, abs=1e-13 * scale), name
    assert frame.mass == pytest.approx(solid.total_mass(), rel=1e-13)


def test_a_box_is_a_box() -> None:
    """m (b² + c²) / 12 and so on about the centre, wherever it is."""
    corners = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    points = np.array([5.0, -1.0, 2.0]) + corners * (1.0, 2.0, 3.0)
    mesh = fem.build_mesh(points, np.arange(8)[None], kind="hexahedron")
    solid = Solid(mesh, LinearElastic(young=1.0, poisson=0.0, density=2.0))
    frame = inertia_integrals(solid, np.zeros((0, 8, 3)))
    assert frame.mass == pytest.approx(12.0, rel=1e-13)
    assert frame.centre == pytest.approx([5.5, 0.0, 3.5], rel=1e-13)
    assert frame.inertia == pytest.approx(np.diag([13.0, 10.0, 5.0]), abs=1e-12)


@pytest.mark.parametrize("kind", ["translation", "rotation", "combination", "zero"])
def test_rigid_motions_are_refused(kind: str) -> None:
    solid = body()
    shapes = some_shapes(solid)
    turn = np.cross([0.3, -0.2, 0.5], solid.points - [7.0, 0.0, 1.0])
    extra = {
        "translation": np.broadcast_to([0.0, 1.0, 0.0], turn.shape),
        "rotation": turn,
        "combination": turn + 0.5 * shapes[0] - shapes[2],
        "zero": np.zeros_like(turn),
    }[kind]
    with pytest.raises(DefoError, match="is zero" if kind == "zero" else "rigid motion"):
        inertia_integrals(solid, np.concatenate([shapes, extra[None]]))
    # A translation beside a deformation is none of the shapes' own: it is taken out.
    mixed = shapes.copy()
    mixed[0] += (0.0, 1.0, 0.0)
    same = inertia_integrals(solid, shapes), inertia_integrals(solid, mixed)
    assert same[1].quadratic == pytest.approx(same[0].quadratic, abs=1e-12)
    assert same[1].mean[:, 0] == pytest.approx(same[0].mean[:, 0] + [0.0, 1.0, 0.0], rel=1e-12)


def test_what_cannot_fly() -> None:
    with pytest.raises(DefoError, match=r"3 displacement components .* held"):
        inertia_integrals(body(fixed=["z>1.5"]), POINTS[None])
    with pytest.raises(DefoError, match=r"shape \(r, 6, 3\), got \(1, 5, 3\)"):
        inertia_integrals(body(), np.zeros((1, 5, 3)))
    with pytest.raises(DefoError, match="finite"):
        inertia_integrals(body(), np.full((1, 6, 3), np.nan))


def write(path: str) -> None:
    """For two ranks: the integrals, the same on each of them."""
    solid = body(2)
    frame = inertia_integrals(solid, some_shapes(solid))
    first = solid.comm.bcast(frame.arrays(), root=0)
    for name, array in frame.arrays().items():
        assert np.array_equal(array, first[name]), name
    if solid.comm.rank == 0:
        np.savez(path, **{name: getattr(frame, name) for name in NAMES})


@pytest.mark.mpi
def test_two_ranks_integrate_as_one_does(mpirun: Any, tmp_path: Path) -> None:
    code = (
        f"import sys; sys.path.insert(0, {str(HERE)!r})\n"
        "import fenics_defo.fem.compat\n"
        "from test_floating_frame_integrals import write; write(sys.argv[1])"
    )
    done = mpirun("-c", code, tmp_path / "frame.npz")
    assert done.returncode == 0, done.stderr
    solid = body(2)
    one = inertia_integrals(solid, some_shapes(solid))
    with np.load(tmp_path / "frame.npz") as two:
        for name in NAMES:
            expected = np.asarray(getattr(one, name))
            scale = np.abs(expected).max()
            assert two[name] == pytest.approx(expected, abs=1e-12 * scale), name
