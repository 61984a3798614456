"""The table in words and numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest
from math import isinf

from motion.measure import BARS, STIFFNESSES, Play, Score

TEN = 10
"""Solves a frame that bar and aim are about."""


@dataclass(frozen=True)
class Row:
    """A contestant, with or without the hinge correction.

    Args:
        name: as printed.
        hinge: whether it gives back the angular momentum about the line through the pins.
        ours: whether this is the solver, or what it does.
        scores: by solves a frame.
        swings: the long run with ten solves a frame, by stiffness; empty if there was none, None if it blew up.
    """

    name: str
    hinge: bool
    ours: bool
    scores: Mapping[int, Score]
    swings: Mapping[int, Play | None]


HEAD = ("", "scheme", "hinge", "split")
LONG = ("E 200", "E 2000", "top 200", "top 2000", "stretch 200", "2000")


def report(rows: list[Row], stretch: Mapping[int, float], seconds: float) -> str:
    """Everything, as one text; ``stretch`` is the reference's, by stiffness."""
    budgets = list(rows[0].scores)
    errors = [f"{solves}: {k}" for solves in budgets for k in STIFFNESSES]
    long = LONG if rows[0].swings else ()
    table = [[*HEAD, *errors, *long], *(_cells(row, budgets) for row in rows)]
    return "\n".join([*_legend(stretch, seconds), "", *_aligned(table), "", *verdicts(rows)])


def verdicts(rows: list[Row]) -> list[str]:
    """Bar and aim, for each of ours that has the hinge correction."""
    lines = []
    for row in rows:
        if row.ours and row.hinge:
            for k, (bar, aim) in BARS.items():
                error = row.scores[TEN].error[k]
                outcome = ", ".join(
                    f"{name} {bound:.3f} {'reached' if error <= bound else 'missed'}"
                    for name, bound in (("bar", bar), ("aim", aim))
                )
                lines.append(f"{row.name}, k = {k} N/m, {TEN} solves a frame: {error:.4f} m; {outcome}")
    return lines


def reaches_bar(row: Row) -> bool:
    """Whether it does at both stiffnesses."""
    return row.scores[TEN].in_bars <= 1.0


def _legend(stretch: Mapping[int, float], seconds: float) -> list[str]:
    true = ", ".join(f"{value:.3f} at {k} N/m" for k, value in stretch.items())
    return [
        "rms error of the mean height over 1 s, m, by solves with W in a frame of 20 ms and by stiffness in N/m.",
        "hinge: the angular momentum about the line through the pins given back. split: substeps x solves, at ten.",
        f"E: energy after {seconds:g} s at ten solves, 0 for the true motion, -1 for a cloth at rest; top: its peak.",
        f"stretch: the longest thread after any frame of these; in the reference's first second {true}.",
    ]


def _cells(row: Row, budgets: list[int]) -> list[str]:
    split = row.scores[TEN]
    cells = ["*" if row.ours and row.hinge else "", row.name, "yes" if row.hinge else "no"]
    cells.append(f"{split.substeps} x {split.iterations}")
    cells += [_error(row.scores[n].error[k]) if n in row.scores else "" for n in budgets for k in STIFFNESSES]
    if row.swings:
        plays = [row.swings[k] for k in STIFFNESSES]
        cells += ["unstable" if p is None else f"{p.energy[-1]:+.3f}" for p in plays]
        cells += ["-" if p is None else f"{p.energy.max():+.3f}" for p in plays]
        cells += ["-" if p is None else f"{p.stretch:.3f}" for p in plays]
    return cells


def _error(value: float) -> str:
    return "unstable" if isinf(value) else f"{value:.4f}"


def _aligned(table: list[list[str]]) -> list[str]:
    widths = [max(len(cell) for cell in column) for column in zip_longest(*table, fillvalue="")]
    return ["  ".join(map(str.ljust, line, widths)).rstrip() for line in table]
