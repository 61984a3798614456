"""Which integrator moves cloth best for the same number of solves with W: the comparison that decided for ours.

    python benchmarks/motion.py                      the table; minutes
    python benchmarks/motion.py --quick              ten solves a frame only, no long runs
    python benchmarks/motion.py --plot               also draw docs/images/motion.svg
    python benchmarks/motion.py --reference          compute the reference motion anew; takes longest

A square cloth of 30 x 30 vertices is let go level, held by two neighbouring corners, with nothing that damps it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from motion import contestants, measure, picture, reference
from motion.contestants import Contestant
from motion.report import TEN, Row, reaches_bar, report

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "motion.svg"
BUDGETS = (TEN, 20, 40)
SWING = 10.0  # s


def main() -> int:
    """Play, print, draw; exit code 1 if the solver misses the bar."""
    options = _options()
    if options.reference:
        reference.compute()
    heights, stretch = reference.read()
    rows = []
    for row in play(heights, quick=options.quick):
        rows.append(row)
        print(f"played: {row.name}, hinge {'on' if row.hinge else 'off'}", file=sys.stderr, flush=True)
    print(report(rows, stretch, SWING))
    if options.plot and not picture.draw(rows, options.plot):
        print("no picture: matplotlib is not installed (pip install '.[bench]')", file=sys.stderr)
    return int(not reaches_bar(rows[0]))


def play(heights: dict[int, np.ndarray], *, quick: bool) -> Iterator[Row]:
    """The solver first, then the contestants; some of them only at ten solves, or without a long run."""
    budgets = (TEN,) if quick else BUDGETS
    scores = {solves: measure.score_of_solver(solves, heights) for solves in budgets}
    swings = {} if quick else measure.swing(partial(measure.frames_of_solver, substeps=TEN), SWING)
    yield Row("cloth_core", True, True, scores, swings)
    for one in contestants.INTEGRATORS:
        yield from (_row(one, heights, budgets, hinge=hinge, long=not quick) for hinge in (False, True))
    for one in contestants.MINIMISERS:
        yield _row(one, heights, (TEN,), hinge=False, long=False)
        yield _row(one, heights, budgets, hinge=True, long=not quick)
    for one in contestants.OTHERS:
        yield _row(one, heights, (TEN,), hinge=True, long=not quick)


def _row(one: Contestant, heights: dict[int, np.ndarray], budgets: tuple[int, ...], *, hinge: bool, long: bool) -> Row:
    scores = {n: measure.best_split(one, n, heights, hinge=hinge) for n in budgets}
    split = {"substeps": scores[TEN].substeps, "iterations": scores[TEN].iterations}
    frames = partial(measure.frames_of, contestant=one, hinge=hinge, **split)
    return Row(one.name, hinge, one.ours, scores, measure.swing(frames, SWING) if long else {})


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="ten solves a frame only, no long runs")
    parser.add_argument("--reference", action="store_true", help=f"compute {reference.PATH.name} anew")
    parser.add_argument("--plot", type=Path, nargs="?", const=PICTURE, help=f"draw a picture (there: {PICTURE.name})")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
