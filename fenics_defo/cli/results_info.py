"""What a folder of results holds, by its ``summary.json``."""

import json
from pathlib import Path
from typing import Any

from fenics_defo.errors import FileFormatError

_SUMMARY = "summary.json"
# What a summary has at least, and what must be a table in it.
_KEYS = ("status", "time", "duration", "steps", "steps_now", "step", "integrator", "linear_solver")
_MORE = ("mesh", "order", "nodes", "cells", "dofs", "newton_iterations", "halvings", "files")
_TABLES = ("probes", "energies", "seconds")


def results_record(folder: str) -> dict[str, Any]:
    """Read the summary of a run, finished or not.

    Args:
        folder: what ``fenics-defo simulate`` has filled.

    Raises:
        FileFormatError: there is no summary, or it is not one.
    """
    path = Path(folder) / _SUMMARY
    try:
        record = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise FileFormatError(
            f"{folder}: is a folder without {_SUMMARY} ({error.strerror}); give a file, or the "
            "folder of a simulation's results"
        ) from error
    except (ValueError, RecursionError) as error:
        raise FileFormatError(f"{path}: is damaged ({error}); run the simulation again") from error
    if (
        not isinstance(record, dict)
        or not all(key in record for key in (*_KEYS, *_MORE, *_TABLES))
        or not all(isinstance(record[key], dict) for key in _TABLES)
    ):
        raise FileFormatError(f"{path}: is no summary of a simulation; run the simulation again")
    return {"kind": "results", **record, "folder": folder}
