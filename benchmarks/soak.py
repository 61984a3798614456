"""What the node has to stand, each figure beside its bar and aim.

    python benchmarks/soak.py                       all of it: two hours
    python benchmarks/soak.py --seconds 20          all of it, short
    python benchmarks/soak.py --only rate latency   parts of it

A real node in a process of its own, over real DDS, on a ROS domain that nobody else here uses. Exit code 1 if a bar is
missed. ``--seconds`` is how long each part runs; the bars are meant for the 600 of its default.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from comparison import machine
from marks.row import Row, table

from cloth_sim_ros.command_line import free_domain

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["ROS_DOMAIN_ID"] = str(free_domain())

from soaking import damage, killed, latency, long, overhead, rate

PARTS: dict[str, Callable[[Path, float], Iterator[Row]]] = {
    "overhead": overhead.rows,
    "rate": rate.small,
    "rate_10000": rate.large,
    "latency": latency.rows,
    "damage": damage.rows,
    "kill": killed.kill_9,
    "restarts": killed.restarts,
    "again": long.again,
    "hour": long.hour,
}


def main() -> int:
    """Measure, print."""
    options = _options()
    began, before = time.monotonic(), machine.describe()
    rows: list[Row] = []
    for part in options.only:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["ROS_LOG_DIR"] = folder
            for row in PARTS[part](Path(folder), options.seconds):
                rows.append(row)
                print(" | ".join(row.cells()), file=sys.stderr, flush=True)
    print(f"\n{table(rows)}\n\nIn {time.monotonic() - began:.0f} s.")
    print(machine.sentence(before))
    return int(any(row.reached == "MISSED" for row in rows))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=600.0, help="how long a part runs (default: %(default)g)")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="parts of it")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
