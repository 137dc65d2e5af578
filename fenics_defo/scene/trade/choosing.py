"""The choice among measured candidates: the cheapest that is good enough."""

from collections.abc import Sequence
from dataclasses import dataclass

from fenics_defo.scene.trade.records import FULL, MEASURED, Measurement

_MISSES = 3
# Costs that differ by no more than this part count as equal: clocks are no better.
_SAME = 0.2
# A candidate that costs more must be better by so much to be on the front.
_BETTER = 0.99


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What is required.

    Args:
        tolerance: largest error [-].
        rate: steps a second [Hz]; None: any.
        step: of the scene [s].
        floor: error of the reference: smaller ones count as equal to it [-].
    """

    tolerance: float
    rate: float | None
    step: float
    floor: float = 0.0

    def allows_error(self, row: Measurement) -> bool:
        """Whether a candidate is accurate enough."""
        return row.error is not None and row.error <= self.tolerance

    def allows_cost(self, row: Measurement) -> bool:
        """Whether a candidate is fast enough, and its states come as often as asked for."""
        if self.rate is None:
            return True
        often = row.candidate.step <= max(1.0 / self.rate, self.step) * (1.0 + 1e-9)
        return often and row.microseconds is not None and row.microseconds <= 1e6 / self.rate

    def excess(self, row: Measurement) -> float:
        """By which factor a measured candidate misses the worse of the two limits."""
        assert row.error is not None
        assert row.microseconds is not None
        late = 0.0 if self.rate is None else row.microseconds * self.rate / 1e6
        return max(row.error / self.tolerance, late)


def in_order(rows: Sequence[Measurement]) -> tuple[Measurement, ...]:
    """Measured candidates from the cheapest on, then the others as they came."""
    measured = [row for row in rows if row.status == MEASURED]
    others = [row for row in rows if row.status != MEASURED]
    return (*sorted(measured, key=lambda row: row.cost or 0.0), *others)


def pareto_front(
    rows: Sequence[Measurement], floor: float = 0.0, *, trained: bool = False
) -> tuple[int, ...]:
    """Numbers of the rows that no other beats in both error and cost, cheapest first.

    Args:
        rows: from the cheapest on.
        floor: error of the reference: smaller ones count as equal to it [-].
        trained: whether models count whose bases are made from this very motion.
    """
    front, least = [], float("inf")
    for number, row in enumerate(rows):  # they are in the order of their cost
        if row.status != MEASURED or row.error is None:
            continue
        if row.candidate.is_trained and not trained:
            continue
        error = max(row.error, floor)
        if error < _BETTER * least:
            front.append(number)
            least = error
    return tuple(front)


def choose(rows: Sequence[Measurement], limits: Limits) -> tuple[int | None, tuple[int, ...], str]:
    """The number of the chosen row, those of the nearest misses, and the reason.

    Only models are chosen: a run of the whole body is there to be compared with. A model whose
    basis is made from this very motion is chosen where no other fits: its error is that of what it
    was made from, and says little of other motions.

    Args:
        rows: from the cheapest on.
        limits: what is required.
    """
    models = [
        (number, row)
        for number, row in enumerate(rows)
        if row.status == MEASURED and row.candidate.kind != FULL and row.error is not None
    ]
    good = [n for n, row in models if limits.allows_error(row) and limits.allows_cost(row)]
    others = [n for n in good if not rows[n].candidate.is_trained]
    good = others or good
    if good:
        near = [n for n in good if _cost(rows[n]) <= (1.0 + _SAME) * _cost(rows[good[0]])]
        # Then the smallest: it leaves most to spare.
        choice = min(near, key=lambda n: (max(rows[n].error or 0.0, limits.floor), _size(rows[n])))
        return choice, (), _because(rows, choice, models, limits)
    nearest = sorted(models, key=lambda pair: limits.excess(pair[1]))[:_MISSES]
    return None, tuple(number for number, _ in nearest), _why_none(nearest, limits)


def _size(row: Measurement) -> int:
    return 0 if row.candidate.model is None else row.candidate.model.size


def _cost(row: Measurement) -> float:
    return float("inf") if row.cost is None else row.cost


def _because(
    rows: Sequence[Measurement],
    choice: int,
    models: list[tuple[int, Measurement]],
    limits: Limits,
) -> str:
    row = rows[choice]
    is_trained = row.candidate.is_trained
    models = [(n, r) for n, r in models if is_trained or not r.candidate.is_trained]
    cheaper = [r for _, r in models if (1.0 + _SAME) * _cost(r) < _cost(row)]
    text = (
        f"the cheapest of {len(models)} measured models within {percent(limits.tolerance)}: its "
        f"error is {percent(row.error)}, a step takes {duration(row.microseconds)}"
    )
    if is_trained:
        text += "; its basis is made from this very motion, which no other model could follow"
    if cheaper:
        best = min(cheaper, key=lambda r: r.error or 0.0)
        count = f"the best of the {len(cheaper)} cheaper ones" if cheaper[1:] else "the cheaper one"
        text += f"; {count} is off by {percent(best.error)}"
    full = [r for r in rows if r.candidate.kind == FULL and not r.candidate.law and r.cost]
    if full and row.cost and full[0].cost:
        text += f"; the whole body takes {full[0].cost / row.cost:,.0f} times as long"
    return text


def _why_none(nearest: list[tuple[int, Measurement]], limits: Limits) -> str:
    asked = f"an error of at most {percent(limits.tolerance)}"
    if limits.rate is not None:
        asked += f" at {limits.rate:g} steps a second"
    if not nearest:
        return f"no model could be measured, and {asked} was asked for"
    told = "; ".join(
        f"{row.candidate.name}, step {step_text(row)}: {percent(row.error)} in "
        f"{duration(row.microseconds)} a step"
        for _, row in nearest
    )
    return f"no model has {asked}; nearest: {told}"


def step_text(row: Measurement) -> str:
    """A candidate's step, as text."""
    return duration(1e6 * row.candidate.step)


def percent(value: float | None) -> str:
    """A part of one as text."""
    return "-" if value is None else f"{100.0 * value:.3g} %"


def duration(microseconds: float | None) -> str:
    """A time as text."""
    if microseconds is None:
        return "-"
    # Three digits first: 999.7 µs are 1 ms.
    rounded = float(f"{microseconds:.3g}")
    for size, unit in ((1.0, "µs"), (1e3, "ms")):
        if rounded < 1e3 * size:
            return f"{rounded / size:.3g} {unit}"
    return f"{rounded / 1e6:.3g} s" if rounded < 1e9 else f"{rounded / 1e6:,.0f} s"
