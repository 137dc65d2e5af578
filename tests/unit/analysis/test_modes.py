import logging
from typing import Any

import numpy as np
import pytest
from modal_bodies import (
    STEEL,
    box,
    box_arrays,
    dense_pairs,
    gram,
    joined,
    moved,
    residuals,
)

from fenics_defo import beams
from fenics_defo.analysis import Phases, linear_modes
from fenics_defo.energy import LinearElastic, StVenantKirchhoff
from fenics_defo.errors import DefoError, EigenSolveError, SolverError
from fenics_defo.fem import Fixed, Solid, build_mesh
from fenics_defo.runtime import mac

SOLVERS: list[Any] = ["davidson", "krylov-schur", "iterative"]
RUBBER = StVenantKirchhoff(young=1.0e7, poisson=0.0, density=1000.0)

CONSTRAINTS: dict[str, list[Any]] = {
    "free": [],
    "clamped": ["x==0"],
    "hinge": ["x==0 and z==0"],
    "slider": [Fixed("x==0", "yz"), Fixed("x==1", "yz")],
    "table": [Fixed("z==0", "z")],
    "ball": ["x==0 and y==0 and z==0"],
    "point by point": [Fixed("x==0", "x"), Fixed("y==0", "y"), Fixed("z==0", "z")],
}
STRAINLESS = {"free": 6, "clamped": 0, "hinge": 1, "slider": 1, "table": 3, "ball": 3}


def thread(**options: Any) -> Solid:
    """A bar, 20 times as long as thick, of a law that knows large rotations."""
    return box(
        (10, 1, 1), (1.0, 0.05, 0.05), kind="hexahedron", order=2, material=RUBBER, **options
    )


def stretched(solid: Solid, strain: float) -> Any:
    return strain * solid.points * [1.0, 0.0, 0.0]


@pytest.mark.parametrize("name", CONSTRAINTS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_all_modes_of_a_small_body_match_the_dense_solver(name: str, solver: Any) -> None:
    solid = box((2, 1, 1), fixed=CONSTRAINTS[name])
    expected, _ = dense_pairs(solid)
    strainless = STRAINLESS.get(name, 0)
    modes = linear_modes(solid, len(expected), solver=solver)
    assert modes.rigid_modes == strainless
    assert modes.omega[strainless:] ** 2 == pytest.approx(expected[strainless:], rel=1e-8)
    assert (modes.frequencies[:strainless] == 0.0).all()
    assert gram(solid, modes) == pytest.approx(np.eye(len(expected)), abs=1e-9)
    assert residuals(solid, modes).max() < 1e-8
    assert (modes.shapes[:, solid.held] == 0.0).all()
    assert modes.complete == (solver != "iterative")


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
@pytest.mark.parametrize(("kind", "order"), [("tetrahedron", 2), ("hexahedron", 1)])
def test_the_solvers_agree(kind: str, order: int, fixed: list[str]) -> None:
    solid = box((5, 2, 2), kind=kind, order=order, fixed=fixed)
    first, *others = [linear_modes(solid, 12, solver=solver) for solver in SOLVERS]
    _, shapes = dense_pairs(solid)
    assert mac(first, shapes[:12]).diagonal()[first.rigid_modes :] == pytest.approx(1.0, abs=1e-8)
    for other in others:
        assert other.frequencies == pytest.approx(first.frequencies, rel=1e-9)
        assert mac(first, other).diagonal() == pytest.approx(1.0, abs=1e-8)
    assert residuals(solid, first) == pytest.approx(first.residuals, abs=1e-9)


@pytest.mark.parametrize("name", ["free", "clamped", "slider", "point by point"])
def test_effective_masses_of_all_modes_sum_to_the_part_that_moves(name: str) -> None:
    solid = box((2, 1, 1), fixed=CONSTRAINTS[name])
    modes = linear_modes(solid, int(np.count_nonzero(~solid.held)))
    centre, mass = modes.centre, solid.mass().toarray()
    arm = solid.points - centre
    motions = [np.broadcast_to(e, arm.shape) for e in np.eye(3)]
    motions += [np.cross(e, arm) for e in np.eye(3)]
    free = ~solid.held.ravel()
    of_free = np.linalg.inv(mass[np.ix_(free, free)])
    for direction, motion in enumerate(motions):
        momentum = mass @ motion.ravel()
        expected = momentum[free] @ of_free @ momentum[free] / (motion.ravel() @ momentum)
        total = modes.effective_mass[:, direction].sum()
        assert total == pytest.approx(expected, rel=1e-9)
        if name == "free":
            assert total == pytest.approx(1.0, rel=1e-9)


def test_the_rigid_modes_of_a_free_body_are_pure_motions_in_order() -> None:
    modes = linear_modes(box((3, 2, 1)), 8)
    assert modes.effective_mass[:3, :3] == pytest.approx(np.eye(3), abs=1e-9)
    assert modes.effective_mass[:6].sum(axis=0) == pytest.approx(1.0, abs=1e-9)
    assert modes.effective_mass[6:] == pytest.approx(0.0, abs=1e-9)


def test_the_inertia_is_that_of_a_block() -> None:
    a, b, c = size = (1.0, 0.5, 0.4)
    modes = linear_modes(box((2, 1, 1), size), 6)
    mass = 7800.0 * a * b * c
    moments = mass / 12.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert modes.total_mass == pytest.approx(mass, rel=1e-12)
    assert modes.centre == pytest.approx(np.array(size) / 2.0, rel=1e-12)
    assert modes.inertia == pytest.approx([mass] * 3 + list(moments), rel=1e-12)
    assert modes.node_mass.sum() == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
def test_frequencies_scale_with_stiffness_density_and_size(fixed: list[str]) -> None:
    size = np.array([1.0, 0.5, 0.4])

    def elastic(young: float, density: float, scale: float) -> Any:
        material = LinearElastic(young=young, poisson=0.3, density=density)
        solid = box((3, 1, 1), tuple(size * scale), material=material, fixed=fixed)
        return linear_modes(solid, 4, keep_rigid=False).frequencies

    base = elastic(2.0e11, 7800.0, 1.0)
    assert elastic(8.0e11, 7800.0, 1.0) == pytest.approx(2.0 * base, rel=1e-9)
    assert elastic(2.0e11, 4 * 7800.0, 1.0) == pytest.approx(0.5 * base, rel=1e-9)
    for young, scale in [(1.0, 1e-6), (1e13, 1e-6), (1.0, 1e4), (1e13, 1e4)]:
        expected = base * np.sqrt(young / 2.0e11) / scale
        assert elastic(young, 7800.0, scale) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("ratio", [1e6, 1e-6])
def test_materials_of_very_different_stiffness(solver: Any, ratio: float) -> None:
    points, cells = box_arrays((4, 1, 1), (1.0, 0.3, 0.2))
    soft = LinearElastic(young=2.0e11 * ratio, poisson=0.3, density=7800.0)
    solid = Solid(build_mesh(points, cells), {None: STEEL, "x<0.5": soft}, fixed=["x==0"])
    expected = np.sqrt(dense_pairs(solid)[0][:4])
    assert linear_modes(solid, 4, solver=solver).omega[:4] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("fixed", [[], ["x==0"]])
def test_a_nearly_incompressible_body(fixed: list[str]) -> None:
    material = LinearElastic(young=1.0e6, poisson=0.4999, density=1000.0)
    solid = box((2, 1, 1), order=2, material=material, fixed=fixed)
    expected = np.sqrt(dense_pairs(solid)[0][6:10])
    assert linear_modes(solid, 10).omega[6:10] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("count", "size"), [(1, 6), (5, 6), (6, 6), (7, 7)])
def test_the_rigid_modes_are_never_cut(solver: Any, count: int, size: int) -> None:
    modes = linear_modes(box(), count, solver=solver)
    assert (modes.size, modes.rigid_modes) == (size, 6)


def test_without_rigid_modes_the_count_is_of_elastic_ones() -> None:
    solid = box()
    whole, elastic = linear_modes(solid, 9), linear_modes(solid, 3, keep_rigid=False)
    assert elastic.size == 3
    assert elastic.rigid_modes == 0
    assert elastic.complete
    assert elastic.frequencies == pytest.approx(whole.frequencies[6:], rel=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_pair_of_a_square_section_is_whole_and_along_the_axes(solver: Any) -> None:
    solid = box((4, 2, 2), (1.0, 0.1, 0.1), kind="hexahedron", fixed=["x==0"])
    modes = linear_modes(solid, 1, solver=solver)
    assert modes.size == 2
    assert modes.frequencies[0] == pytest.approx(modes.frequencies[1], rel=1e-9)
    sideways = np.abs(modes.participation[:, 1:3])
    assert sideways[0, 1] < 1e-6 * sideways[0, 0]
    assert sideways[1, 0] < 1e-6 * sideways[1, 1]
    assert linear_modes(solid, 2, solver=solver).size == 2


@pytest.mark.parametrize("solver", SOLVERS)
def test_many_equal_pieces_are_one_large_cluster(solver: Any) -> None:
    part = box_arrays((1, 1, 1))
    arrays = joined(*(moved(part, 3.0 * i, 0.0, 0.0) for i in range(8)))
    modes = linear_modes(Solid(build_mesh(*arrays), STEEL), 1, solver=solver)
    assert (modes.size, modes.rigid_modes) == (48, 48)
    held = Solid(build_mesh(*arrays), STEEL, fixed=["z==0"])
    modes = linear_modes(held, 1, solver=solver)
    assert (modes.size, modes.rigid_modes) == (8, 0)
    alone = linear_modes(box((1, 1, 1), (1.0, 1.0, 1.0), fixed=["z==0"]), 1).frequencies
    assert modes.frequencies == pytest.approx(np.full(8, alone[0]), rel=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("shift", "fixed", "strainless"),
    [
        ((1.0, 1.0, 1.0), [], 9),
        ((1.0, 1.0, 1.0), ["x==0"], 3),
        ((1.0, 1.0, 0.0), [], 7),
        ((1.0, 1.0, 0.0), ["x==0"], 1),
    ],
)
def test_parts_that_hang_together_by_a_node_or_an_edge(
    solver: Any, shift: tuple[float, ...], fixed: list[str], strainless: int, caplog: Any
) -> None:
    part = box_arrays((2, 2, 2))
    solid = Solid(build_mesh(*joined(part, moved(part, *shift))), STEEL, fixed=fixed)
    with caplog.at_level(logging.WARNING):
        modes = linear_modes(solid, strainless + 4, solver=solver)
    assert modes.rigid_modes == strainless
    expected = np.sqrt(dense_pairs(solid)[0][strainless : strainless + 4])
    assert modes.omega[strainless : strainless + 4] == pytest.approx(expected, rel=1e-8)
    assert "2 blocks of cells hang together" in caplog.text


@pytest.mark.parametrize("solver", ["davidson", "krylov-schur"])
def test_a_free_spring_whose_first_frequency_no_simple_field_estimates(solver: Any) -> None:
    points, cells = box_arrays((120, 1, 1), kind="hexahedron")
    angle = 6.0 * np.pi * points[:, 0]
    radius = 0.02 + 0.002 * (points[:, 1] - 0.5)
    height = 0.006 * angle / (2.0 * np.pi) + 0.002 * (0.5 - points[:, 2])
    coil = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    solid = Solid(build_mesh(coil, cells, kind="hexahedron"), STEEL)
    modes = linear_modes(solid, 10, solver=solver)
    assert modes.rigid_modes == 6
    assert modes.complete
    expected = np.sqrt(dense_pairs(solid)[0][6:10])
    assert modes.omega[6:10] == pytest.approx(expected, rel=1e-5)


def test_round_off_does_not_refuse_a_long_thin_wire(caplog: Any) -> None:
    solid = box((300, 1, 1), (0.3, 0.001, 0.001), kind="hexahedron", fixed=["x==0"])
    with caplog.at_level(logging.WARNING):
        modes = linear_modes(solid, 2)
    assert modes.residuals.max() > 1e-6
    assert "round-off limits the residuals" in caplog.text
    assert modes.frequencies[0] == pytest.approx(modes.frequencies[1], rel=1e-4)
    with pytest.raises(EigenSolveError, match=r"1\.0e-06 is allowed"):
        linear_modes(solid, 2, residual_tolerance=1e-6)


@pytest.mark.parametrize("solver", ["davidson", "iterative"])
def test_the_same_bits_on_each_run(solver: Any) -> None:
    for fixed in ([], ["x==0"]):
        first, second = (
            linear_modes(box((4, 2, 2), (1.0, 0.2, 0.2), fixed=fixed), 9, solver=solver)
            for _ in range(2)
        )
        assert (first.frequencies == second.frequencies).all()
        assert (first.shapes == second.shapes).all()


def test_another_seed_gives_the_same_modes() -> None:
    solid = box((4, 2, 2), (1.0, 0.2, 0.2), kind="hexahedron")
    first, second = (linear_modes(solid, 14, seed=seed) for seed in (0, 7))
    assert second.frequencies == pytest.approx(first.frequencies, rel=1e-9)
    scale = np.abs(first.shapes).max()
    assert second.shapes == pytest.approx(first.shapes, abs=1e-5 * scale)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_body_carried_elsewhere_has_the_same_modes(solver: Any) -> None:
    solid = thread()
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    displacement = solid.points @ turn.T - solid.points + [5.0, 0.0, -10.0]
    rest = linear_modes(solid, 10, solver="davidson")
    there = linear_modes(solid, 10, solver=solver, displacement=displacement)
    assert there.rigid_modes == 6
    assert there.frequencies == pytest.approx(rest.frequencies, rel=1e-6, abs=1e-9)
    carried = rest.shapes[6:] @ turn.T
    overlap = mac(there.shapes[6:], carried)
    pairs = overlap.reshape(2, 2, 2, 2).sum(axis=(1, 3)) / 2.0  # bending pairs may turn
    assert pairs == pytest.approx(np.eye(2), abs=1e-5)


@pytest.mark.parametrize("solver", SOLVERS)
def test_tension_raises_and_compression_lowers_frequencies(solver: Any) -> None:
    solid = thread(fixed=["x==0", "x==1"])
    buckling = 4.0 * np.pi**2 * (0.05**2 / 12.0)  # Euler's strain of a beam clamped at both ends

    def first(strain: float) -> float:
        displacement = stretched(solid, strain)
        modes = linear_modes(solid, 1, displacement=displacement, solver=solver)
        expected = np.sqrt(dense_pairs(solid, displacement)[0][0])
        assert modes.omega[0] == pytest.approx(expected, rel=1e-6)
        return float(modes.frequencies[0])

    rest = first(0.0)
    assert rest == pytest.approx(linear_modes(solid, 1).frequencies[0], rel=1e-9)
    for strain in (0.2 * buckling, -0.2 * buckling):
        # Galef: (f / f0)^2 = 1 - P / P_crit, nearly, whatever the supports.
        assert first(strain) / rest == pytest.approx(np.sqrt(1.0 + strain / buckling), rel=0.03)
    with pytest.raises(SolverError, match="not a stable state"):
        first(-1.5 * buckling)


@pytest.mark.parametrize("solver", ["davidson", "krylov-schur"])
def test_loads_that_keep_their_direction_make_a_pendulum(solver: Any) -> None:
    solid = thread(fixed=["x==0 and z==0.025"])
    displacement = stretched(solid, 1e-3)
    modes = linear_modes(solid, 3, displacement=displacement, solver=solver)
    assert modes.rigid_modes == 0
    expected = np.sqrt(dense_pairs(solid, displacement)[0][:3])
    assert modes.omega == pytest.approx(expected, rel=1e-6)
    with pytest.raises(EigenSolveError, match="not a stable state"):
        linear_modes(solid, 3, displacement=-displacement, solver=solver)


def test_phases_are_timed_and_announced() -> None:
    announced: list[str] = []
    phases = Phases(on_start=announced.append)
    linear_modes(box(), 7, phases=phases)
    assert announced == ["assemble", "factorise", "solve", "count"]
    assert list(phases.seconds) == announced
    assert all(seconds > 0.0 for seconds in phases.seconds.values())


@pytest.mark.parametrize(
    ("count", "options", "message"),
    [
        (0, {}, "whole number from 1 to 36, the motions of this body, got 0"),
        (37, {}, "from 1 to 36"),
        (31, {"keep_rigid": False}, "from 1 to 30"),
        (2.0, {}, r"got 2\.0"),
        ("3", {}, "got '3'"),
        (1, {"solver": "arpack"}, "solver must be one of davidson, krylov-schur, iterative"),
        (1, {"residual_tolerance": 0.0}, "residual_tolerance must be positive"),
        (1, {"residual_tolerance": float("nan")}, "residual_tolerance must be positive"),
        (1, {"cluster_tolerance": float("nan")}, "cluster_tolerance must be from 0 to 0.1"),
        (1, {"seed": -1}, "seed must be a whole number from 0, got -1"),
        (1, {"displacement": np.zeros((3, 3))}, r"must have the shape \(12, 3\), got \(3, 3\)"),
        (1, {"displacement": np.full((12, 3), np.nan)}, "must be finite"),
    ],
)
def test_what_cannot_be_asked(count: Any, options: dict[str, Any], message: str) -> None:
    with pytest.raises(DefoError, match=message):
        linear_modes(box((2, 1, 1)), count, **options)


def test_a_residual_that_is_too_large_raises() -> None:
    with pytest.raises(EigenSolveError, match=r"relative residual .* and 1\.0e-30 is allowed"):
        linear_modes(box(fixed=["x==0"]), 3, residual_tolerance=1e-30)


@pytest.mark.parametrize("solver", ["davidson", "krylov-schur"])
def test_a_wire_as_thin_as_round_off_allows(solver: Any) -> None:
    """At 1:500 the softest mode's λ is 1e-14 of the largest: vectors are good to a few digits."""
    solid = box((20, 1, 1), (5.0, 0.01, 0.01), order=2, fixed=["x==0"])
    modes = linear_modes(solid, 2, solver=solver)
    section = beams.RectangularSection(0.01, 0.01)
    constants = {"young": STEEL.young, "poisson": STEEL.poisson, "density": STEEL.density}
    expected = beams.cantilever_frequencies(length=5.0, section=section, count=2, **constants)
    assert modes.frequencies[:2] == pytest.approx(expected[:2], rel=0.02)
