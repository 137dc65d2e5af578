"""What ``validation.py`` measures and how it writes it down."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Check:
    """One number that was measured.

    Args:
        what: what it is, with its unit.
        found: the simulator's.
        expected: theory's, or the published one.
        bound: largest relative difference that is accepted; of the absolute one if theory says 0.
    """

    what: str
    found: float
    expected: float
    bound: float

    @property
    def error(self) -> float:
        """Relative difference; absolute where theory says zero."""
        return self.found / self.expected - 1.0 if self.expected else self.found

    def row(self) -> str:
        """Of the table."""
        return (
            f"| {self.what} | {self.found:.6g} | {self.expected:.6g} | {self.error:+.1e} "
            f"| {self.bound:.0e} |"
        )


@dataclass(frozen=True, slots=True)
class Chapter:
    """One subject of the page.

    Args:
        title: heading.
        text: what was done, in Markdown, with the figures.
        checks: its numbers.
        notes: what follows the table.
    """

    title: str
    text: str
    checks: tuple[Check, ...]
    notes: str = ""

    def page(self) -> str:
        """The chapter in Markdown."""
        table = [
            "| number | found | expected | difference | accepted |",
            "| --- | --- | --- | --- | --- |",
            *(check.row() for check in self.checks),
        ]
        parts = [f"## {self.title}", self.text.strip(), "\n".join(table), self.notes.strip()]
        return "\n\n".join(part for part in parts if part)
