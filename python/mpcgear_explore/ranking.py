"""Which trials are better: constraints first, then Pareto rank, then room on the front."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpcgear_explore.records import Record
from mpcgear_explore.study import Study


def costs(study: Study, records: Sequence[Record]) -> NDArray[np.float64]:
    """Objectives as costs, a row per record: less is better, infinite where there is none."""
    rows = np.full((len(records), len(study.objectives)), np.inf)
    for i, record in enumerate(records):
        values = record.values(study.objectives)
        if values is not None:
            rows[i] = [-v if o.up else v for v, o in zip(values, study.objectives, strict=True)]
    return rows


def fronts(rows: NDArray[np.float64]) -> NDArray[np.int64]:
    """Pareto rank of each row, from 0."""
    ranks = np.full(len(rows), -1)
    left = np.arange(len(rows))
    rank = 0
    while len(left):
        here = rows[left]
        no_worse = (here[:, None, :] <= here[None, :, :]).all(axis=2)
        better = (here[:, None, :] < here[None, :, :]).any(axis=2)
        beaten = (no_worse & better).any(axis=0)
        ranks[left[~beaten]] = rank
        left = left[beaten]
        rank += 1
    return ranks


def crowding(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """How much room each row of one front has around it; infinite at the ends."""
    room = np.zeros(len(rows))
    for column in rows.T:
        order = np.argsort(column, kind="stable")
        span = column[order[-1]] - column[order[0]]
        room[order[[0, -1]]] = np.inf
        if len(rows) > 2 and np.isfinite(span) and span > 0:
            room[order[1:-1]] += (column[order[2:]] - column[order[:-2]]) / span
    return room


def best_first(study: Study, records: Sequence[Record]) -> list[int]:
    """Places of the records that are gears, the best first; the same for the same records in the same order."""
    gears = [i for i, r in enumerate(records) if r.values(study.objectives) is not None]
    if not gears:
        return []
    rows = costs(study, [records[i] for i in gears])
    broken = np.array(
        [sum(max(v, 0.0) for v in records[i].violations(study.constraints).values()) for i in gears]
    )
    # Broken constraints come before everything; among those that hold them, ranks are taken anew.
    ranks = np.full(len(gears), len(gears))
    room = np.zeros(len(gears))
    holding = np.flatnonzero(broken <= 0)
    if len(holding):
        ranks[holding] = fronts(rows[holding])
    for rank in np.unique(ranks[holding]):
        members = np.flatnonzero(ranks == rank)
        room[members] = crowding(rows[members])
    order = np.lexsort((np.arange(len(gears)), -room, ranks, broken))
    return [gears[i] for i in order]


def pareto(study: Study, records: Sequence[Record]) -> list[int]:
    """Places of the records that no other beats and that keep every constraint."""
    held = [i for i, r in enumerate(records) if r.holds(study.constraints) and r.values(study.objectives)]
    if not held:
        return []
    ranks = fronts(costs(study, [records[i] for i in held]))
    return [i for i, rank in zip(held, ranks, strict=True) if rank == 0]


@dataclass(frozen=True)
class Pick:
    """A design that is worth a look, and why."""

    index: int
    why: str


MOST = 3
"""How many designs are picked."""


def picks(study: Study, records: Sequence[Record]) -> list[Pick]:
    """Up to three designs of the front: the balanced one, then the best by the first objectives."""
    front = pareto(study, records)
    if not front:
        return []
    rows = costs(study, [records[i] for i in front])
    span = np.ptp(rows, axis=0)
    scaled = (rows - rows.min(axis=0)) / np.where(span > 0, span, 1.0)
    distance = np.linalg.norm(scaled, axis=1)
    middle = int(np.argmin(distance))
    chosen = {front[middle]: _balanced(study, len(front), scaled[middle])}
    for column, objective in enumerate(study.objectives):
        order = np.lexsort((distance, rows[:, column]))
        index = front[int(order[0])]
        if len(chosen) < MOST and index not in chosen:
            value = records[index].figures[objective.measure]
            word = "most" if objective.up else "least"
            chosen[index] = f"{word} {objective.measure} of the front: {value:.4g} {objective.unit}".strip()
    for i in np.argsort(distance, kind="stable"):
        if len(chosen) < min(MOST, len(front)) and front[int(i)] not in chosen:
            chosen[front[int(i)]] = "the next nearest to the best of all objectives together"
    return [Pick(index, why) for index, why in chosen.items()]


def _balanced(study: Study, count: int, scaled: NDArray[np.float64]) -> str:
    if count == 1:
        return "the only design that none of the others beats"
    places = ", ".join(
        f"{100 * (1 - s):.0f} % of the way to the best {o.measure}"
        for s, o in zip(scaled, study.objectives, strict=True)
    )
    return f"balanced: nearest to the best of all objectives together ({places})"
