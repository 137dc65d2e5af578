"""The work of ``mesh-to-modes``: read, build, solve, save, print. All of it is collective."""

import sys
import time
from argparse import Namespace
from pathlib import Path

from fenics_defo import fem, view
from fenics_defo.analysis import Phases, describe_motion, linear_modes
from fenics_defo.cli.command import Run
from fenics_defo.cli.kernels import no_unfinished_kernels
from fenics_defo.cli.materials import ChosenMaterials, given_materials, settled_materials
from fenics_defo.cli.modes_report import ModesReport
from fenics_defo.cli.output import can_style, libraries_on_stderr, write_text
from fenics_defo.cli.progress import Progress
from fenics_defo.cli.ranks import Ranks
from fenics_defo.errors import DefoError
from fenics_defo.runtime import Modes, check_writable


def compute_and_print(options: Namespace, current: Run, progress: Progress, begin: float) -> None:
    """Do what the command line asks for.

    Args:
        options: of the command line.
        current: this run, to which the ranks are made known.
        progress: display and notes.
        begin: `time.perf_counter` when the command began [s].
    """
    current.ranks = ranks = Ranks()
    if not ranks.is_first:
        progress.silence()

    def enter(phase: str) -> None:
        current.go_on()
        progress.start(phase)

    phases = Phases(on_start=enter, seconds={"load": time.perf_counter() - begin})
    with libraries_on_stderr(), no_unfinished_kernels():
        report = _compute(options, ranks, progress, phases)
    progress.stop()
    if ranks.is_first:
        text = report.json_text() if options.json else report.text(style=can_style(sys.stdout))
        write_text(sys.stdout, text)


def _compute(options: Namespace, ranks: Ranks, progress: Progress, phases: Phases) -> ModesReport:
    """Compute the modes and write the files."""
    fixed = [*options.fixed, *(fem.Fixed(region, axes) for axes, region in options.fixed_in)]
    given = given_materials(
        file=options.materials,
        constants={name: getattr(options, name) for name in ("young", "poisson", "density")},
    )
    with phases("check"):
        ranks.on_first(lambda: _check_outputs(options))
    with phases("read"):
        mesh = fem.read_mesh(
            options.mesh, size=options.size, merge=options.merge, unit=options.unit
        )
    materials = settled_materials(given, mesh.record.materials)
    if not fixed and not options.free:
        progress.note("no --fixed: the body is free to move as a whole")
    for note in materials.notes:
        progress.note(note)
    with phases("build"):
        solid = fem.Solid(
            mesh,
            {region: material for region, material in materials.by_region.items()},
            order=options.order or mesh.mesh.geometry.cmaps[0].degree,
            fixed=fixed,
        )
    modes = linear_modes(
        solid,
        options.count,
        solver=options.solver,
        keep_rigid=not options.drop_rigid,
        verify=not options.no_count,
        phases=phases,
    )
    with phases("write"):
        files = ranks.on_first(lambda: _write(options, modes))
    return _report(options, solid, materials, modes, phases, files)


def _check_outputs(options: Namespace) -> None:
    """Make sure that every file can be written, before hours of work depend on it."""
    check_writable(options.output)
    if options.vtk is not None:
        view.check_vtk_path(options.vtk)
    if options.picture is not None:
        view.check_picture_path(options.picture)
        view.require_rendering()
    taken: dict[Path, str] = {Path(options.mesh).resolve(): "MESH"}
    for option in ("output", "vtk", "picture"):
        path = getattr(options, option)
        if path is None:
            continue
        other = taken.setdefault(Path(path).resolve(), f"--{option}")
        if other != f"--{option}":
            raise DefoError(f"--{option} and {other} name the same file {path}; choose another")
    if Path(options.output).suffix.lower() not in ("", ".npz"):
        raise DefoError(f"--output writes an .npz file, got the name {options.output}")


def _write(options: Namespace, modes: Modes) -> list[str]:
    """Write the files and return their names."""
    modes.save(options.output)
    files = [options.output]
    if options.vtk is not None:
        view.write_modes_vtk(modes, options.vtk)
        files.append(options.vtk)
    if options.picture is not None:
        view.mode_picture(modes, options.picture)
        files.append(options.picture)
    return files


def _report(
    options: Namespace,
    solid: fem.Solid,
    materials: ChosenMaterials,
    modes: Modes,
    phases: Phases,
    files: list[str],
) -> ModesReport:
    return ModesReport(
        mesh=options.mesh,
        modes=modes,
        motions=describe_motion(modes),
        order=solid.order,
        dofs=solid.dof_count,
        fixed=tuple(_fixed_texts(options)),
        fixed_nodes=int(solid.held.any(axis=1).sum()),
        materials=materials,
        asked=options.count,
        why_unchecked=_why_unchecked(options),
        notes=(*solid.record.notes, *materials.notes),
        seconds=dict(phases.seconds),
        files=tuple(files),
    )


def _fixed_texts(options: Namespace) -> list[str]:
    return [*options.fixed, *(f"{region} along {axes}" for axes, region in options.fixed_in)]


def _why_unchecked(options: Namespace) -> str:
    if options.no_count:
        return "--no-count"
    return "--solver iterative" if options.solver == "iterative" else ""
