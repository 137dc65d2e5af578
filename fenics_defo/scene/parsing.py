"""From a scene file to its record, without its mesh and, if need be, without its materials."""

import os
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fenics_defo.errors import SceneError
from fenics_defo.scene import load_schema, schema
from fenics_defo.scene.records import (
    DampingTable,
    InitialTable,
    LoadTable,
    OutputTable,
    RequireTable,
    Scene,
    SolverTable,
)
from fenics_defo.scene.table import Table, did_you_mean

if TYPE_CHECKING:
    from fenics_defo.energy import Law

type MaterialReader = Callable[[Path, Sequence[Mapping[str, object]]], "dict[str | None, Law]"]

_SINGLE = ("mesh", "damping", "time", "solver", "initial", "output", "require")
_LISTS = ("material", "fixed", "load", "probe")
_LARGEST = 10_000_000  # bytes; a scene is written by hand


def parse_scene(
    path: str | os.PathLike[str], *, materials: MaterialReader = lambda _path, _tables: {}
) -> Scene:
    """Read and check a scene file but for its materials; needs nothing but Python.

    Args:
        path: scene file, see `fenics_defo.scene.reading.read_scene`.
        materials: what reads the [[material]] tables; they are left alone if not given.

    Raises:
        SceneError: as `read_scene`.
    """
    place = Path(path)
    tables = _load(place)
    _check_names(place, tables)
    for name in ("mesh", "time"):
        if name not in tables:
            example = 'file = "beam.msh"' if name == "mesh" else 'integrator = "implicit-newmark"'
            raise SceneError(f"{place}: needs the table [{name}]; add it, with {example}")

    def single[T](name: str, read: Callable[[Table], T], default: T) -> T:
        return read(Table(place, f"[{name}]", tables[name])) if name in tables else default

    def each[T](name: str, read: Callable[[Table], T]) -> tuple[T, ...]:
        items = enumerate(tables.get(name, []), 1)
        return tuple(read(Table(place, f"[[{name}]] {i}", values)) for i, values in items)

    probes = each("probe", schema.read_probe)
    _check_unique(place, [probe.name for probe in probes])
    time = schema.read_time(Table(place, "[time]", tables["time"]))
    loads = each("load", load_schema.read_load)
    initial = single("initial", schema.read_initial, InitialTable())
    if time.is_static:
        _check_static(place, loads, initial)
    return Scene(
        path=place,
        mesh=schema.read_mesh_table(Table(place, "[mesh]", tables["mesh"])),
        materials=materials(place, tables.get("material", [])),
        fixed=each("fixed", load_schema.read_fixed),
        loads=loads,
        damping=single("damping", schema.read_damping, DampingTable()),
        time=time,
        solver=single("solver", schema.read_solver, SolverTable()),
        probes=probes,
        initial=initial,
        output=single("output", schema.read_output, OutputTable()),
        require=single("require", schema.read_require, RequireTable()),
        tables=tables,
    )


def _load(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > _LARGEST:
            raise SceneError(f"{path}: is too large for a scene file; give the .toml file")
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SceneError(
            f"{path}: cannot be read ({error.strerror}); give the name of a scene file"
        ) from error
    except UnicodeDecodeError as error:
        raise SceneError(
            f"{path}: is not UTF-8 text ({error.reason}); a scene is a TOML file"
        ) from error
    except RecursionError:
        raise SceneError(f"{path}: is not valid TOML: nested too deeply") from None
    except SceneError:
        raise
    except ValueError as error:  # TOMLDecodeError, which names the line, or an impossible number
        raise SceneError(f"{path}: is not valid TOML: {error}") from error


def _check_names(path: Path, tables: Mapping[str, Any]) -> None:
    """Refuse unknown tables, and those with the wrong number of brackets."""
    shown = ", ".join([*(f"[{n}]" for n in _SINGLE), *(f"[[{n}]]" for n in _LISTS)])
    for name, value in tables.items():
        if name not in (*_SINGLE, *_LISTS):
            near = did_you_mean(name, (*_SINGLE, *_LISTS))
            what = "table" if isinstance(value, dict | list) else "key outside of all tables"
            raise SceneError(f"{path}: unknown {what} {name!r}{near}; the tables are {shown}")
        if name in _SINGLE and not isinstance(value, dict):
            raise SceneError(f"{path}: {name!r} must be one table; write [{name}] above its keys")
        if name in _LISTS and not (
            isinstance(value, list) and all(isinstance(item, dict) for item in value)
        ):
            raise SceneError(
                f"{path}: {name!r} may come several times; write [[{name}]], with two brackets, "
                "above the keys of each"
            )


def _check_unique(path: Path, names: list[str]) -> None:
    for i, name in enumerate(names):
        if name in names[:i]:
            raise SceneError(
                f"{path}: [[probe]] {i + 1}: name {name!r} is taken by another probe; "
                "give each its own"
            )


def _check_static(path: Path, loads: tuple[LoadTable, ...], initial: InitialTable) -> None:
    """Refuse what has no meaning without inertia."""
    for i, load in enumerate(loads, 1):
        if load.kind == "impulse":
            raise SceneError(
                f"{path}: [[load]] {i}: an impulse has no place where [time] integrator = "
                '"static"; leave it out, or choose another integrator'
            )
    if any(initial.velocity) or any(initial.spin):
        raise SceneError(
            f'{path}: [initial]: velocity and spin have no place where [time] integrator = "static"'
            "; leave them out, or choose another integrator"
        )
