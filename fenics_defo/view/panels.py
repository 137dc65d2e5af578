"""Drawings of one displaced body each, rendered off screen."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_defo.view.camera import View
from fenics_defo.view.offscreen import Image, pyvista
from fenics_defo.view.surface import Skin, displaced

Array = NDArray[np.float64]

_AREA = 260_000.0  # pixels of a drawing
_MARGIN = 1.08
_OVERSAMPLING = 2
_REST, _EDGE = "#98a2ad", "#20262c"


def palette() -> NDArray[np.uint8]:
    """Return the colours (r, 4) for displacements from 0 to the largest.

    The perceptually uniform map *magma*, from pale to dark and without its ends: what rests is
    nearly the colour of the paper, and light and shade remain visible on what moves.
    """
    values = np.asarray(pyvista.LookupTable("magma_r", n_values=256).values, dtype=np.uint8)
    return values[6:196]


def panel_size(width: float, height: float) -> tuple[int, int]:
    """Return the pixels of a drawing for a view of ``width`` by ``height`` [m]."""
    ratio = float(np.clip(width / max(height, 1e-12 * width), 0.4, 3.2))
    return round(np.sqrt(_AREA * ratio)), round(np.sqrt(_AREA / ratio))


def draw_panels(body: Skin, factors: Array, view: View, size: tuple[int, int]) -> list[Image.Image]:
    """Draw the body once for each mode.

    Args:
        body: surface and displacements of k modes.
        factors: what to multiply the displacements by (k,).
        view: one projection for all.
        size: width and height of a drawing [pixels].
    """
    plotter = pyvista.Plotter(
        off_screen=True, window_size=[_OVERSAMPLING * n for n in size], lighting="none"
    )
    try:
        plotter.disable_anti_aliasing()  # drawn larger and reduced instead, which is faster here
        plotter.set_background("white")
        _light(plotter, view)
        _look(plotter, view, size)
        _add_rest(plotter, body)
        # Lines a little nearer to the eye than their surface: they never sink into it, and a
        # parallel projection does not show the shift.
        lift = 0.004 * (view.width + view.height) * view.towards
        images = []
        for index, factor in enumerate(factors):
            actors = _add_moved(plotter, body, index, factor, lift=lift)
            plotter.render()
            pixels = np.asarray(plotter.screenshot(return_img=True))
            images.append(Image.fromarray(pixels).resize(size, Image.Resampling.LANCZOS))
            for actor in actors:
                plotter.remove_actor(actor, render=False)
        return images
    finally:
        plotter.close()


def _look(plotter: Any, view: View, size: tuple[int, int]) -> None:
    """Point the camera and make the view fill the drawing."""
    reach = view.width + view.height
    camera = plotter.camera
    camera.focal_point = view.centre
    camera.position = view.centre + 2.0 * reach * view.towards
    camera.up = view.up
    camera.parallel_projection = True
    camera.parallel_scale = _MARGIN * max(view.height, view.width * size[1] / size[0]) / 2.0
    camera.clipping_range = (0.01 * reach, 4.0 * reach)


def _light(plotter: Any, view: View) -> None:
    """Light the body from above left, and weakly from the right and the eye."""
    for sideways, above, strength in ((-0.6, 0.9, 0.48), (0.9, 0.1, 0.22), (0.0, 0.0, 0.36)):
        direction = view.towards + sideways * view.right + above * view.up
        light = pyvista.Light(intensity=strength, light_type="scene light")
        light.positional = False
        light.position, light.focal_point = view.centre + direction, view.centre
        plotter.add_light(light)


def _add_rest(plotter: Any, body: Skin) -> None:
    """Draw the body at rest by its sharp edges and its outline."""
    if body.edges.n_points:
        plotter.add_mesh(body.edges, color=_REST, line_width=2.0, lighting=False)
    plotter.add_silhouette(body.surface, color=_REST, line_width=2.0)


def _add_moved(plotter: Any, body: Skin, index: int, factor: float, *, lift: Array) -> list[Any]:
    """Draw the displaced body, return what was added."""
    surface = displaced(body, index, factor)
    size = np.linalg.norm(body.surface_moves[index], axis=1)
    surface.point_data["size"] = size / max(size.max(), np.finfo(float).tiny)
    actors = [
        plotter.add_mesh(
            surface,
            scalars="size",
            cmap=pyvista.LookupTable(values=palette(), scalar_range=(0.0, 1.0)),
            show_scalar_bar=False,
            smooth_shading=True,
            clim=(0.0, 1.0),
            ambient=0.42,
            diffuse=0.75,
            specular=0.12,
            specular_power=20.0,
            render=False,
        )
    ]
    if body.edges.n_points:
        edges = body.edges.copy()
        edges.points = body.edges.points + factor * body.edge_moves[index] + lift
        actors.append(
            plotter.add_mesh(
                edges, color=_EDGE, line_width=1.6, opacity=0.55, lighting=False, render=False
            )
        )
    return actors
