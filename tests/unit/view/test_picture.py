import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from fenics_defo.errors import DefoError
from fenics_defo.runtime import Modes
from fenics_defo.view import check_picture_path, mode_picture, picture, require_rendering
from fenics_defo.view.surface import displaced, largest_scale, skin

Array = NDArray[np.float64]
Box = Callable[..., Modes]

CELL_TYPES = ("tetra", "tetra10", "hexahedron", "hexahedron27")


def parabola(points: Array) -> Array:
    """Bending with a constant curvature: quadratic cells hold it exactly."""
    x, _, z = points.T
    return np.stack([-2.0 * x * (z - 0.25), 0.0 * x, x**2], axis=1)


def twist(points: Array) -> Array:
    return np.cross([1.0, 0.0, 0.0], points - [0.0, 0.5, 0.25]) * points[:, :1]


def stretch(points: Array) -> Array:
    return points * [1.0, 0.0, 0.0]


def pixels(path: Path) -> NDArray[np.uint8]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def run(script: str, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run Python without a display and without our variables for VTK."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW", "EGL_LOG_LEVEL")
    inherited = {name: value for name, value in os.environ.items() if name not in hidden}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", script, *arguments],
        check=False,
        capture_output=True,
        text=True,
        env=inherited | environment,
    )


DRAW = (
    "import sys\n"
    "from fenics_defo.errors import DefoError\n"
    "from fenics_defo.runtime import load_modes\n"
    "try:\n"
    "    from fenics_defo.view import mode_picture\n"
    "    mode_picture(load_modes(sys.argv[1]), sys.argv[2])\n"
    "except DefoError as error:\n"
    "    print(type(error).__name__, error)\n"
)


@pytest.fixture
def modes(box_modes: Box) -> Modes:
    return box_modes("tetra10", [np.ones_like, parabola, twist, stretch], rigid_modes=1)


def test_without_a_display_and_without_a_word(modes: Modes, tmp_path: Path) -> None:
    modes.save(tmp_path / "modes.npz")
    done = run(DRAW, str(tmp_path / "modes.npz"), str(tmp_path / "modes.png"))
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    image = pixels(tmp_path / "modes.png")
    assert min(image.shape[:2]) > 400
    assert (image[0] == 255).all()
    assert 0.05 < (image != 255).any(axis=2).mean() < 0.7
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 1000


def test_missing_driver_is_one_sentence(modes: Modes, tmp_path: Path) -> None:
    modes.save(tmp_path / "modes.npz")
    done = run(
        DRAW,
        str(tmp_path / "modes.npz"),
        str(tmp_path / "modes.png"),
        __EGL_VENDOR_LIBRARY_DIRS="/nonexistent",
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("MissingDependencyError pictures without a display need EGL")
    assert not (tmp_path / "modes.png").exists()


def test_missing_pyvista_names_the_extra() -> None:
    script = "import sys; sys.modules['pyvista'] = None\n" + DRAW
    done = run(script, "absent.npz", "absent.png")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("MissingDependencyError pictures need PyVista")
    assert "pip install 'fenics_defo[view]'" in done.stdout


def test_rendering_is_possible_here() -> None:
    require_rendering()


@pytest.fixture
def sheets(monkeypatch: pytest.MonkeyPatch) -> list[tuple[list[str], str]]:
    """Titles and notes of the pictures that are composed."""
    seen: list[tuple[list[str], str]] = []
    compose = picture.compose

    def spy(drawings: list[Image.Image], titles: list[str], **options: object) -> Image.Image:
        assert len(drawings) == len(titles)
        seen.append((list(titles), str(options["note"])))
        return compose(drawings, titles, **options)

    monkeypatch.setattr(picture, "compose", spy)
    return seen


def test_rigid_modes_are_left_out_and_said_so(
    modes: Modes, tmp_path: Path, sheets: list[tuple[list[str], str]]
) -> None:
    mode_picture(modes, tmp_path / "a.png", count=2)
    mode_picture(modes.select([0]), tmp_path / "b.png")
    assert sheets == [
        (
            ["2 · 200.0 Hz · bending z", "3 · 300.0 Hz · torsion"],
            "1 rigid mode and 1 higher mode not shown",
        ),
        (["1 · rigid"], ""),
    ]


def test_columns_and_count_set_the_page(modes: Modes, tmp_path: Path) -> None:
    sizes = []
    for count, columns in ((1, 1), (2, 1), (2, 2)):
        mode_picture(modes, tmp_path / "a.png", count=count, columns=columns)
        sizes.append(pixels(tmp_path / "a.png").shape)
    (low, narrow, _), (high, _, _), (_, wide, _) = sizes
    assert high > 1.5 * low
    assert wide > 1.5 * narrow


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_same_modes_same_bytes(box_modes: Box, tmp_path: Path, cell_type: str) -> None:
    modes = box_modes(cell_type, [parabola], grid=(3, 1, 1))
    for name in ("a.png", "b.png"):
        mode_picture(modes, tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_scale_place_and_unit_of_length_do_not_matter(box_modes: Box, tmp_path: Path) -> None:
    modes = box_modes("hexahedron", [parabola, twist])
    small = replace(modes, shapes=1e6 * modes.shapes, points=1e-7 * modes.points - 3e-3)
    mode_picture(modes, tmp_path / "a.png")
    mode_picture(small, tmp_path / "b.png")
    difference = np.abs(pixels(tmp_path / "a.png").astype(int) - pixels(tmp_path / "b.png"))
    assert difference.mean() < 0.05


def test_nodes_without_cells_do_not_matter(modes: Modes, tmp_path: Path) -> None:
    stray = {
        "points": np.vstack([modes.points, [[99.0, -99.0, 99.0]]]),
        "shapes": np.pad(modes.shapes, ((0, 0), (0, 1), (0, 0))),
        "node_mass": np.append(modes.node_mass, 0.0),
        "node_numbers": np.append(modes.node_numbers, 999),
    }
    mode_picture(modes, tmp_path / "a.png", count=1)
    mode_picture(replace(modes, **stray), tmp_path / "b.png", count=1)
    difference = np.abs(pixels(tmp_path / "a.png").astype(int) - pixels(tmp_path / "b.png"))
    assert difference.mean() < 0.05


def test_larger_scale_moves_further(modes: Modes, tmp_path: Path) -> None:
    """The same view has to hold more height."""
    for name, scale in (("a.png", 0.02), ("b.png", 1.0)):
        mode_picture(modes, tmp_path / name, count=1, scale=scale)
    heights = [pixels(tmp_path / name).shape[0] for name in ("a.png", "b.png")]
    assert heights[1] > 1.2 * heights[0]


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.jpg", {}, "pictures are PNG files"),
        ("absent/a.png", {}, "does not exist"),
        ("a.png", {"count": 0}, "count must be positive, got 0"),
        ("a.png", {"columns": -1}, "columns must be positive, got -1"),
        ("a.png", {"scale": np.nan}, "scale must be positive, got nan"),
    ],
)
def test_bad_requests_are_refused(
    modes: Modes, tmp_path: Path, name: str, options: dict[str, float], message: str
) -> None:
    with pytest.raises(DefoError, match=message):
        mode_picture(modes, tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_path_can_be_checked_before(tmp_path: Path) -> None:
    check_picture_path(tmp_path / "a.PNG")
    with pytest.raises(DefoError, match=r"name it \*\.png"):
        check_picture_path(tmp_path / "a.svg")


@pytest.mark.parametrize("cell_type", ["tetra10", "hexahedron27"])
def test_surface_of_second_order_follows_its_curves(box_modes: Box, cell_type: str) -> None:
    """Also between the nodes: the subdivided faces carry the quadratic shape itself."""
    modes = box_modes(cell_type, [parabola], grid=(2, 1, 1))
    body = skin(modes)
    points = np.asarray(body.surface.points, dtype=float)
    assert len(points) > 5 * len(modes.points)
    np.testing.assert_allclose(body.surface_moves[0], parabola(points), atol=1e-4)
    np.testing.assert_allclose(
        body.edge_moves[0], parabola(np.asarray(body.edges.points, dtype=float)), atol=1e-4
    )


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_surface_is_the_boundary_with_its_twelve_edges(box_modes: Box, cell_type: str) -> None:
    body = skin(box_modes(cell_type, [parabola], grid=(3, 2, 2)))
    assert body.surface.area == pytest.approx(2 * (4.0 * 1.0 + 4.0 * 0.5 + 1.0 * 0.5), rel=1e-5)
    assert body.edges.length == pytest.approx(np.linalg.norm([4.0, 1.0, 0.5]), rel=1e-5)
    lengths = body.edges.compute_cell_sizes(area=False, volume=False).cell_data["Length"]
    assert lengths.sum() == pytest.approx(4 * (4.0 + 1.0 + 0.5), rel=1e-5)


@pytest.mark.parametrize("cell_type", CELL_TYPES)
def test_normals_are_those_of_the_sides(box_modes: Box, cell_type: str) -> None:
    """Sharp edges stay sharp; smoothing does not reach around them."""
    body = skin(box_modes(cell_type, [stretch], grid=(3, 2, 2)))
    normals = np.asarray(displaced(body, 0, 0.1).point_data["Normals"])
    np.testing.assert_allclose(np.abs(normals).max(axis=1), 1.0, atol=1e-5)


def test_scale_limit_is_where_sections_turn_by_the_rotation(box_modes: Box) -> None:
    """Shear u_z = x turns each side along x by the factor itself."""
    body = skin(box_modes("hexahedron", [lambda p: p[:, :1] * [0.0, 0.0, 1.0], np.ones_like]))
    assert largest_scale(body, body.surface_moves[0], 0.45) == pytest.approx(0.45)
    assert largest_scale(body, body.surface_moves[1], 0.45) == np.inf
