"""Cells computed in processes that may hang or crash without taking the map with them."""

import multiprocessing
import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from workflows.stability_map.cases import Case, Cell
from workflows.stability_map.hearing import listen
from workflows.stability_map.outcomes import Kind, Measured, Outcome, outcome_of


def run(cases: Sequence[Case], *, jobs: int, told: Callable[[Cell], None]) -> list[Cell]:
    """Compute all cells, in their order.

    Args:
        cases: what to compute.
        jobs: number of processes.
        told: called with each cell once it is known, from several threads.

    Returns:
        the cells, in the order of the cases.
    """
    # Rows stay together: a process keeps the bodies and references of those it has computed.
    rows = list(dict.fromkeys((case.sweep, case.row) for case in cases))
    by_row = [[case for case in cases if (case.sweep, case.row) == row] for row in rows]
    workers = [_Worker() for _ in range(jobs)]
    free = list(workers)

    def row_of(some: list[Case]) -> list[Cell]:
        worker = free.pop()
        try:
            cells = []
            for case in some:
                cells.append(worker.cell(case))
                told(cells[-1])
            return cells
        finally:
            free.append(worker)

    try:
        with ThreadPoolExecutor(jobs) as pool:
            found = [cell for cells in pool.map(row_of, by_row) for cell in cells]
    finally:
        for worker in workers:
            worker.end()
    order = {(case.sweep, case.row, case.column): number for number, case in enumerate(cases)}
    return sorted(found, key=lambda cell: order[cell.sweep, cell.row, cell.column])


class _Worker:
    """A process that computes one cell after the other, and is replaced when it fails."""

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None

    def cell(self, case: Case) -> Cell:
        """Compute one cell."""
        pipe = self._started()
        begin = time.perf_counter()
        pipe.send(case.compute)
        outcome = self._answer(pipe, case.patience)
        return Cell(case.sweep, case.row, case.column, outcome, time.perf_counter() - begin)

    def _answer(self, pipe: Connection, patience: float) -> Outcome:
        if not pipe.poll(patience):
            self.end()
            return Outcome(Kind.HANG, message=f"no answer within {patience:g} s")
        try:
            return pipe.recv()
        except EOFError:
            assert self._process is not None
            self._process.join()
            code = self._process.exitcode
            self.end()
            return Outcome(Kind.CRASH, message=f"the process ended with status {code}")

    def _started(self) -> Connection:
        if self._pipe is None:
            self._pipe, theirs = self._context.Pipe()
            self._process = self._context.Process(target=_serve, args=(theirs,), daemon=True)
            self._process.start()
            theirs.close()
            assert self._pipe.recv() == "ready"  # loading the libraries is no cell's time
        return self._pipe

    def end(self) -> None:
        """Stop the process, if there is one."""
        if self._process is not None and self._pipe is not None:
            self._process.kill()
            self._process.join()
            self._process.close()
            self._pipe.close()
        self._process = self._pipe = None


def _serve(pipe: Connection) -> None:
    """Compute what comes through the pipe until it closes."""
    pipe.send("ready")
    with suppress(EOFError, KeyboardInterrupt):
        while True:
            pipe.send(_observed(pipe.recv()))


def _observed(compute: Callable[[], Measured]) -> Outcome:
    """A cell's outcome, with what was logged or warned of meanwhile."""
    with listen() as said, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        outcome = outcome_of(compute)
    notes = [outcome.message] if outcome.message else []
    # That a tangent was indefinite is news of a step on the way, not of the result.
    told = sorted(said, key=lambda message: "negative eigenvalue" in message)
    notes += [f"said: {told[0]}"] if told else []
    notes += [f"Python warned: {caught[0].message}"] if caught else []
    return replace(outcome, message="; ".join(notes))
