"""What a file or folder holds: modes, a model, a mesh, a scene, results."""

import json
import sys
from pathlib import Path

from fenics_defo.cli.model_info import model_record, model_text
from fenics_defo.cli.modes_info import modes_record, modes_text
from fenics_defo.cli.output import can_style, libraries_on_stderr, loading_libraries, write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.results_info import results_record
from fenics_defo.cli.simulate_report import summary_text
from fenics_defo.runtime import load, load_modes
from fenics_defo.runtime.archive import archive_kind
from fenics_defo.runtime.model_file import KIND as MODEL_KIND

_ZIP = b"PK\x03\x04"  # how an .npz file begins


def print_info(file: str, *, size: float | None, as_json: bool, progress: Progress) -> None:
    """Print what ``file`` holds; a file of modes or a model needs NumPy only.

    Args:
        file: mesh, modes, model, scene, or the folder of a simulation's results.
        size: edge length of the tetrahedra that fill a surface or solid [m].
        as_json: print one JSON object.
        progress: display to be taken away before printing.

    Raises:
        DefoError: it is none of these, or at fault.
    """
    style = can_style(sys.stdout) and not as_json
    with libraries_on_stderr():
        if Path(file).is_dir():
            record = results_record(file)
            text = "" if as_json else summary_text(record)
        elif Path(file).suffix.lower() == ".toml":
            # Late, because it needs UFL.
            from fenics_defo.cli.scene_info import scene_record, scene_text

            record = scene_record(file)
            text = "" if as_json else scene_text(record)
        elif _is_archive(file) and archive_kind(file) == MODEL_KIND:
            record = model_record(file, load(file))
            text = "" if as_json else model_text(record)
        elif _is_archive(file):
            modes = load_modes(file)
            record = modes_record(file, modes)
            text = "" if as_json else modes_text(file, modes, style=style)
        else:
            # Late, because it needs DOLFINx and its company, which a file of modes does not.
            with loading_libraries():
                from fenics_defo.cli.mesh_info import mesh_record, mesh_text

            record = mesh_record(file, size=size)
            text = "" if as_json else mesh_text(record)
    progress.stop()
    write_text(sys.stdout, json.dumps(record, allow_nan=False) + "\n" if as_json else text)


def _is_archive(file: str) -> bool:
    path = Path(file)
    if path.suffix.lower() == ".npz":
        return True
    try:
        with path.open("rb") as stream:
            return stream.read(len(_ZIP)) == _ZIP
    except (OSError, ValueError):  # the reader of meshes says what is wrong
        return False
