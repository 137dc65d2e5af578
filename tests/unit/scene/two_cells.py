"""The scene of a body of two hexahedra, so small that a model can have all its motions."""

from pathlib import Path

# A hexahedron on another: 12 nodes in 3 layers, the lowest of them held; 24 motions are left.
LAYERS = (0.0, 0.5, 1.0)
SQUARE = ((0.0, 0.0), (0.4, 0.0), (0.4, 0.3), (0.0, 0.3))
MOTIONS = 24
TIP = (0.2, 0.15, 1.0)

SCENE = """
[mesh]
file = "two.msh"
[[material]]
law = "st-venant-kirchhoff"
young = 1e6
poisson = 0.3
density = 1000
[[fixed]]
region = "floor"
[[load]]
kind = "gravity"
vector = [3, 0, -9.81]
history = { kind = "ramp", duration = 0.05 }
[[load]]
kind = "traction"
region = "roof"
vector = [2e4, 5e3, 0]
history = { kind = "sine", frequency = 4 }
[[load]]
kind = "point"
point = [0.4, 0.3, 0.75]
vector = [0, 100, 0]
[damping]
mass = 0.5
stiffness = 2e-4
[time]
integrator = "implicit-newmark"
step = 1e-3
duration = 0.04
[output]
every = 1000
[[probe]]
name = "tip"
point = [0.2, 0.15, 1]
[[probe]]
name = "inside"
point = [0.1, 0.2, 0.6]
"""

INITIAL = """
[initial]
velocity = [0.2, 0, 0]
spin = [0, 0, 3]
stretch = [1.02, 1, 0.97]
displacement = [0, 0.01, 0]
mode = 2
amplitude = 0.02
"""

IMPULSES = """
[[load]]
kind = "impulse"
region = "z>0.9"
vector = [0, 0, 1]
time = 0.01
[[load]]
kind = "impulse"
node = 11
vector = [1, 0, 0]
"""


def write_mesh(path: Path) -> None:
    """Write the mesh in Gmsh's format 2.2."""
    nodes = [(x, y, z) for z in LAYERS for x, y in SQUARE]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", "3", '2 1 "floor"', '2 2 "roof"', '3 3 "body"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(nodes))]
    lines += [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(nodes, 1)]
    lines += ["$EndNodes", "$Elements", "4"]
    lines += ["1 3 2 1 1 1 2 3 4", "2 3 2 2 1 9 10 11 12"]
    lines += ["3 5 2 3 1 1 2 3 4 5 6 7 8", "4 5 2 3 1 5 6 7 8 9 10 11 12", "$EndElements"]
    path.write_text("\n".join(lines) + "\n")


def write_scene(folder: Path, text: str = SCENE, name: str = "scene.toml") -> Path:
    """Write a scene beside its mesh."""
    write_mesh(folder / "two.msh")
    (folder / name).write_text(text)
    return folder / name
