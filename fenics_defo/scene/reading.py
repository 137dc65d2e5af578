"""From a scene file to its record; the mesh is not opened yet."""

import os

from fenics_defo.energy.tables import materials_from_tables
from fenics_defo.scene.parsing import parse_scene
from fenics_defo.scene.records import Scene


def read_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and check a scene file.

    Args:
        path: a TOML file of the tables [mesh], [[material]], [[fixed]], [[load]], [damping],
            [time], [solver], [[probe]], [initial], [output] and [require].

    Returns:
        the scene; file names in it are relative to the scene file's folder.

    Raises:
        SceneError: the file cannot be read, is not TOML, or a table or key is unknown, missing, of
            the wrong type or out of range. It names the file, the table, the key and the value.
        MaterialError: a material is at fault.
    """
    return parse_scene(path, materials=materials_from_tables)
