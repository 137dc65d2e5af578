"""Groups of the file on the checked mesh: what is not part of the body is dropped."""

import numpy as np
from numpy.typing import NDArray

from fenics_defo.fem.sources.draft import Draft
from fenics_defo.fem.sources.numbering import row_keys
from fenics_defo.fem.sources.raw_mesh import RawGroup
from fenics_defo.fem.sources.source_mesh import Group

Integers = NDArray[np.int64]
ENTITY = {0: "points", 1: "edges", 2: "facets", 3: "cells"}


def settle_groups(draft: Draft) -> tuple[Group, ...]:
    """The groups with each entity once, in the file's order, and only on the volume cells."""
    parents = _parents(draft)
    groups = []
    for group in draft.groups:
        entities, lost = _settle(group, parents)
        if lost:
            draft.notes.append(
                f"{lost} {ENTITY[group.dimension]} of group {group.name!r} are not on any volume "
                "cell and were dropped."
            )
        if len(entities) == 0:
            draft.notes.append(f"group {group.name!r} is empty and was left out.")
            continue
        entities.setflags(write=False)
        groups.append(
            Group(
                name=group.name,
                number=group.number,
                dimension=group.dimension,
                entities=entities,
            )
        )
    return tuple(groups)


def _parents(draft: Draft) -> dict[int, Integers]:
    """For each dimension below 3, the distinct entities of the cells that groups may name."""
    wanted = {group.dimension for group in draft.groups}
    parents = {0: np.arange(len(draft.points))[:, None]}
    for dimension, local in ((1, draft.shape.edges), (2, draft.shape.faces)):
        if dimension in wanted:
            table = np.array(local)
            parents[dimension] = draft.corners[:, table].reshape(-1, table.shape[1])
    return parents


def _settle(group: RawGroup, parents: dict[int, Integers]) -> tuple[Integers, int]:
    """Entities to keep, and how many are lost."""
    if group.dimension == 3:
        parts = group.parts or [np.empty(0, dtype=np.int64)]
        return np.unique(np.concatenate(parts)), 0
    table = parents[group.dimension]
    width = table.shape[1]
    fitting = [part for part in group.parts if part.shape[1] == width]
    lost = sum(len(part) for part in group.parts if part.shape[1] != width)
    rows = np.concatenate([np.empty((0, width), dtype=np.int64), *fitting])
    present = (rows >= 0).all(axis=1)
    lost += int(np.count_nonzero(~present))
    rows = rows[present]
    if group.dimension == 0:
        return np.unique(rows, axis=0), lost
    keys, known = row_keys(rows, table)
    on_body = np.isin(keys, known)
    lost += int(np.count_nonzero(~on_body))
    _, first = np.unique(keys[on_body], return_index=True)
    return rows[on_body][np.sort(first)], lost
