"""Every figure that is wanted of the solver beside its bar and its aim, in one table.

    python benchmarks/bars.py                        minutes
    python benchmarks/bars.py --large                also 200 x 200 vertices
    python benchmarks/bars.py --only start memory    parts of it

On two cores unless ``--threads`` says otherwise. How much faster than other engines: ``table.py``. Exit code 1 if a bar
is missed.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from comparison import machine, process
from marks.measure import PARTS
from marks.row import Row, table
from table import save

RESULTS = process.ROOT / "benchmarks" / "results" / "bars.json"
SIZES, LARGE = [20, 50, 100], 200


def main() -> int:
    """Measure, print, write."""
    options = _options()
    _begin_again_with(options.threads)
    began, before = time.monotonic(), machine.describe()
    rows: list[Row] = []
    for part in options.only:
        for row in PARTS[part](options.sizes + [LARGE] * options.large):
            rows.append(row)
            print(" | ".join(row.cells()), file=sys.stderr, flush=True)
    save(document(before, rows, options.threads), options.json)
    print(f"\n{table(rows)}\n\n{_summary(rows)} In {time.monotonic() - began:.0f} s, threads: {options.threads}.")
    print(machine.sentence(before))
    return int(any(row.reached == "MISSED" for row in rows))


def document(described: dict[str, Any], rows: list[Row], threads: int) -> dict[str, Any]:
    """What is written to the file."""
    results = [{**asdict(row), "reached": row.reached} for row in rows]
    return {"machine": described, "how": {"threads": threads}, "results": results}


def _summary(rows: list[Row]) -> str:
    counts = {name: sum(row.reached == name for row in rows) for name in ("aim", "bar", "MISSED")}
    return f"{len(rows)} rows: aim {counts['aim']}, bar {counts['bar']}, missed {counts['MISSED']}."


def _begin_again_with(threads: int) -> None:
    """Begin again with so many threads, if need be: libraries count them when they are loaded."""
    wanted = dict.fromkeys(process.THREADS, str(threads))
    if not wanted.items() <= os.environ.items():
        environment = {**os.environ, **wanted}
        os.execve(sys.executable, [sys.executable, *sys.argv], environment)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="N", help="vertices a side")
    parser.add_argument("--large", action="store_true", help=f"also {LARGE}")
    parser.add_argument("--threads", type=int, default=process.CORES, help="cores of a run (default: %(default)s)")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="parts of the table")
    parser.add_argument("--json", type=Path, default=RESULTS, help="write the rows there (default: %(default)s)")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
