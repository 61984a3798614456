"""One figure beside what is wanted of it, and the table of all."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from comparison.report import markdown

HEADER = ("what", "bar", "aim", "measured", "shortest", "reached")


@dataclass(frozen=True)
class Row:
    """A figure, which is the better the smaller it is.

    Args:
        what: is measured, and at which size.
        unit: of all its numbers.
        bar: it should be this at the most.
        aim: better if it is.
        value: measured, NaN if that failed; of times, the median.
        least: of times, the shortest.
        note: what else there is to say, such as why it failed.
    """

    what: str
    unit: str
    bar: float
    aim: float
    value: float
    least: float | None = None
    note: str = ""

    @property
    def reached(self) -> str:
        """The aim, the bar, or neither."""
        return "aim" if self.value <= self.aim else "bar" if self.value <= self.bar else "MISSED"

    def cells(self) -> tuple[str, ...]:
        """As the table has it."""
        what = f"{self.what} ({self.note})" if self.note else self.what
        least = "" if self.least is None else _short(self.least)
        value = f"{_short(self.value)} {self.unit}".rstrip()
        return what, f"{self.bar:g}", f"{self.aim:g}", value, least, self.reached


def table(rows: Iterable[Row]) -> str:
    """All rows, as Markdown."""
    return markdown(HEADER, [row.cells() for row in rows])


def _short(value: float) -> str:
    """Four decimals of what is small, three digits of what is large."""
    return f"{value:.4f}" if abs(value) < 0.1 else f"{value:.3g}" if abs(value) < 100.0 else f"{value:.0f}"
