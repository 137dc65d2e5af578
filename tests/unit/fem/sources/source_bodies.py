"""Small bodies for the tests of the readers, and measures of what was read.

The tables of mid nodes are written out here once more, on purpose: they are VTK's
(vtkQuadraticTetra, vtkTriQuadraticHexahedron), not the package's.
"""

from pathlib import Path

import gmsh
import numpy as np

TET10_MIDS = {4: (0, 1), 5: (1, 2), 6: (0, 2), 7: (0, 3), 8: (1, 3), 9: (2, 3)}
HEX27_MIDS = {
    8: (0, 1), 9: (1, 2), 10: (2, 3), 11: (3, 0), 12: (4, 5), 13: (5, 6), 14: (6, 7), 15: (7, 4),
    16: (0, 4), 17: (1, 5), 18: (2, 6), 19: (3, 7), 20: (0, 3, 4, 7), 21: (1, 2, 5, 6),
    22: (0, 1, 4, 5), 23: (2, 3, 6, 7), 24: (0, 1, 2, 3), 25: (4, 5, 6, 7), 26: tuple(range(8)),
}  # fmt: skip
KUHN = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]


def hex_box(n=2, size=(1.0, 1.0, 1.0)):
    """Points and hexahedra of a box, n cells a side."""
    axis = np.linspace(0.0, 1.0, n + 1)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()]) * size
    k, j, i = (a.ravel() for a in np.meshgrid(*[np.arange(n)] * 3, indexing="ij"))
    first = i + (n + 1) * (j + (n + 1) * k)
    up = (n + 1) ** 2
    square = np.array([0, 1, n + 2, n + 1])
    return points, first[:, None] + np.concatenate([square, square + up])


def tet_box(n=2, size=(1.0, 1.0, 1.0)):
    points, hexes = hex_box(n, size)
    return points, np.concatenate([hexes[:, row] for row in KUHN])


def with_mids(points, cells, columns):
    """Append mid nodes; ``columns`` are the columns to make, of the tables above."""
    table = TET10_MIDS if cells.shape[1] == 4 else HEX27_MIDS
    made = {}
    extra = []
    rows = []
    for cell in cells:
        row = list(cell)
        for column in columns:
            key = frozenset(cell[list(table[column])])
            if key not in made:
                made[key] = len(points) + len(extra)
                extra.append(points[list(key)].mean(axis=0))
            row.append(made[key])
        rows.append(row)
    return np.vstack([points, extra]), np.array(rows)


def body(kind, nodes, n=2, size=(1.0, 1.0, 1.0)):
    """A box of straight cells of 4, 10, 8, 20 or 27 nodes."""
    points, cells = tet_box(n, size) if kind == "tetrahedron" else hex_box(n, size)
    corners = cells.shape[1]
    return (points, cells) if nodes == corners else with_mids(points, cells, range(corners, nodes))


def bend(points):
    """A map of second degree with determinant 1: volumes stay, straight edges become parabolas."""
    return points + np.column_stack([0.2 * points[:, 2] ** 2, 0.0 * points[:, :2]])


def corner_volume(source):
    """Volume of the straight cells through the corners."""
    cells = source.cells
    if source.kind == "hexahedron":
        cells = np.concatenate([cells[:, list(row)] for row in KUHN])
    x = source.points[cells]
    a, b, c = (x[:, i] - x[:, 0] for i in (1, 2, 3))
    return np.einsum("mi,mi->m", a, np.cross(b, c)).sum() / 6.0


def assert_mids_in_the_middle(source, atol=1e-9):
    table = TET10_MIDS if source.kind == "tetrahedron" else HEX27_MIDS
    x = source.points[source.cells]
    assert source.cells.shape[1] == len(table) + (4 if source.kind == "tetrahedron" else 8)
    for column, ends in table.items():
        np.testing.assert_allclose(x[:, column], x[:, list(ends)].mean(axis=1), atol=atol)


def group(source, name, dimension=None):
    found = [g for g in source.groups if g.name == name and dimension in (None, g.dimension)]
    assert len(found) == 1, [(g.name, g.dimension) for g in source.groups]
    return found[0]


def write_two_boxes(
    path: Path,
    *,
    kind="tetrahedron",
    order=1,
    version=4.1,
    binary=False,
    save_all=False,
    incomplete=False,
    groups=True,
):
    """Boxes [0,1]x[0,1]x[0,1] and [1,2]x... that share a face, as a .msh file of Gmsh's own."""
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        for name, value in {
            "General.Terminal": 0,
            "Mesh.MshFileVersion": version,
            "Mesh.Binary": binary,
            "Mesh.SaveAll": save_all,
            "Mesh.SecondOrderIncomplete": incomplete,
            "Mesh.MeshSizeMax": 0.7,
        }.items():
            gmsh.option.setNumber(name, float(value))
        occ = gmsh.model.occ
        boxes = [(3, occ.addBox(0, 0, 0, 1, 1, 1)), (3, occ.addBox(1, 0, 0, 1, 1, 1))]
        occ.fragment(boxes[:1], boxes[1:])
        occ.synchronize()
        if kind == "hexahedron":
            gmsh.model.mesh.setTransfiniteAutomatic(recombine=True)
        gmsh.option.setNumber("Mesh.RecombineAll", float(kind == "hexahedron"))
        if groups:
            _two_box_groups()
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
        return {int(t): x for t, x in zip(*_nodes(), strict=True)}
    finally:
        gmsh.finalize()


def _nodes():
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    return tags, coordinates.reshape(-1, 3)


def _two_box_groups():
    left, right = (
        [
            t
            for _, t in gmsh.model.getEntitiesInBoundingBox(
                x - 0.1, -0.1, -0.1, x + 1.1, 1.1, 1.1, 3
            )
        ]
        for x in (0, 1)
    )
    wall = [t for _, t in gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, -0.1, 0.1, 1.1, 1.1, 2)]
    end = [t for _, t in gmsh.model.getEntitiesInBoundingBox(1.9, -0.1, -0.1, 2.1, 1.1, 1.1, 2)]
    line = [t for _, t in gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, -0.1, 0.1, 0.1, 1.1, 1)]
    corner = [t for _, t in gmsh.model.getEntitiesInBoundingBox(-0.1, -0.1, -0.1, 0.1, 0.1, 0.1, 0)]
    add = gmsh.model.addPhysicalGroup
    add(3, left, 11, name="left")
    add(3, right, 12, name="right part")
    add(3, left + right, 13, name="all")
    add(2, wall, 1, name="wall")
    add(2, end, 7)
    add(1, line, 21, name="line")
    add(0, corner, 31, name="corner")
