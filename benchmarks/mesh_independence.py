"""Whether the same fabric behaves alike however it is meshed: a grid, jittered triangles, a grid twice as fine.

    python benchmarks/mesh_independence.py           means of ten seeds
    python benchmarks/mesh_independence.py --quick   of three, on coarser meshes

A seed draws the jitter of the triangles and, for the drape, where the cloth lies and how uneven it is at first.
Differences are to the grid; after the +-, the standard error of a mean over seeds.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from independence import scenes
from independence.meshes import Mesher, grid, irregular

BAR, AIM = 0.03, 0.01


@dataclass(frozen=True)
class Row:
    """One quantity: its name and unit, how it is measured, cells along the shorter side, and theory if there is one.

    ``seeded`` says whether it depends on the seed on a grid, too; on jittered triangles all do.
    """

    name: str
    unit: str
    measure: Callable[[Mesher, int], float]
    cells: int
    expected: float | None = None
    seeded: bool = False
    judged: bool = True


def rows(quick: bool) -> list[Row]:
    """What is measured."""
    coarse = 0.6 if quick else 1.0
    warp, weft = (scenes.sag_of_a_ribbon(scenes.FABRIC[key]) for key in ("stretch_warp", "stretch_weft"))
    return [
        Row("sag, weft taut", "m", scenes.sag, round(30 * coarse), weft),
        Row("sag, warp taut", "m", scenes.warp_sag, round(15 * coarse), warp),
        Row("swing period", "s", scenes.swing, round(15 * coarse)),
        Row("drape coefficient", "", scenes.drape, round(40 * coarse), seeded=True),
        Row("free strip", "Hz", scenes.strip_frequency, round(40 * coarse), scenes.frequency_of_a_beam(), judged=False),
    ]


def main() -> int:
    """Measure and print; exit code 1 if a row that is judged misses the bar."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="three seeds, coarser meshes")
    parser.add_argument("--only", default="", help="rows whose name contains this")
    options = parser.parse_args()
    seeds = range(3 if options.quick else 10)
    print("| | theory | grid | jittered triangles | twice as fine | |\n|---|---|---|---|---|---|")
    good = True
    for row in rows(options.quick):
        if options.only in row.name:
            good &= _show(row, seeds)
    return 0 if good else 1


@dataclass(frozen=True)
class Compared:
    """A row as measured on the grid, on jittered triangles and on a grid twice as fine, in this order.

    Args:
        means: over the seeds.
        errors: of those means, one standard deviation.
    """

    means: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def off(self) -> tuple[float, ...]:
        """By how much the others differ from the grid, as a ratio."""
        return tuple(mean / self.means[0] - 1.0 for mean in self.means[1:])

    @property
    def worst(self) -> float:
        """The larger of these differences."""
        return max(map(abs, self.off))


def compare(row: Row, seeds: range) -> Compared:
    """Measure one row, saying each figure on standard error."""
    taken = []
    for mesher, jittered in ((grid(row.cells), False), (irregular(row.cells), True), (grid(2 * row.cells), False)):
        chosen = seeds if row.seeded or jittered else seeds[:1]
        taken.append(np.array([row.measure(mesher, seed) for seed in chosen]))
        print(f"{row.name}: {np.round(taken[-1], 5).tolist()}", file=sys.stderr, flush=True)
    return Compared(tuple(float(values.mean()) for values in taken), tuple(map(_error, taken)))


def _show(row: Row, seeds: range) -> bool:
    """Measure and print one row; whether it reaches the bar, or is not judged by it."""
    found = compare(row, seeds)
    first, *others = found.means
    cells = [f"{first:.5g}"] + [
        f"{mean:.5g} ({100 * away:+.1f} +- {100 * error / first:.1f} %)"
        for mean, away, error in zip(others, found.off, found.errors[1:], strict=True)
    ]
    verdict = "aim" if found.worst <= AIM else "bar" if found.worst <= BAR else "missed"
    theory = f"{row.expected:.5g}" if row.expected is not None else ""
    print(f"| {row.name}, {row.unit or '1'} | {theory} | {' | '.join(cells)} | {verdict if row.judged else ''} |")
    return verdict != "missed" or not row.judged


def _error(values: np.ndarray) -> float:
    return float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else 0.0


if __name__ == "__main__":
    sys.exit(main())
