"""The modes as a table of 77 columns of plain text, for terminals, pipes and files alike."""

from collections.abc import Iterable, Sequence

from fenics_defo.cli.number_text import period_text, six_digits
from fenics_defo.runtime import DIRECTIONS, Modes

_DIM, _BOLD, _PLAIN = "\x1b[2m", "\x1b[1m", "\x1b[0m"
_TINY = 0.0005  # of the total: below it a percentage with one decimal says nothing


def table_lines(modes: Modes, motions: Sequence[str], *, style: bool = False) -> list[str]:
    """Lay the modes out: number, frequency, period, kind of motion, effective masses.

    Args:
        modes: k modes.
        motions: k words for the kinds of motion; may be empty.
        style: use the escape codes of terminals for bold and dim.

    Returns:
        lines without their ends: two of heading, k of modes, one of sums.
    """
    width = 10 if any(motions) else 0
    heading = f"{'mode':>4}{'frequency Hz':>14}{'period':>11}  {'motion'[:width]:<{width}}"
    directions = "".join(f"{name:>6}" for name in DIRECTIONS)
    blank = " " * len(heading)
    lines = [
        _styled(f"{blank}{'effective mass in %':>36}", _BOLD, style).rstrip(),
        _styled(f"{heading}{directions}", _BOLD, style),
    ]
    rows = zip(modes.frequencies, modes.periods, motions, modes.effective_mass, strict=True)
    for index, (frequency, period, motion, masses) in enumerate(rows):
        rigid = index < modes.rigid_modes
        row = (
            f"{index + 1:>4}{six_digits(frequency):>14}"
            f"{'-' if rigid else period_text(period):>11}  {motion:<{width}}"
        )
        lines.append(row + _percentages(masses, style))
    lines.append(
        f"{'sum':>4}{'':{len(heading) - 4}}" + _percentages(modes.effective_mass.sum(0), style)
    )
    return lines


def _percentages(fractions: Iterable[float], style: bool) -> str:
    return "".join(
        f"{100.0 * share:6.1f}" if share >= _TINY else _styled(f"{'-':>6}", _DIM, style)
        for share in fractions
    )


def _styled(text: str, code: str, style: bool) -> str:
    return f"{code}{text}{_PLAIN}" if style else text
