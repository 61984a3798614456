"""How long until the first frame, and how much memory the solver takes.

    python benchmarks/start.py               2,500 vertices, kernels on disk and with an empty cache; memory at 10,000
    python benchmarks/start.py --no-node     without the node's own start, which needs ROS

Every figure is of processes of its own, on two threads. The first frame is counted from the start of Python: import,
build, W, and a step with pins, a hand, an obstacle and wind. Wanted are 3 s, better 1.5, with the kernels on disk,
60 s, better 25, with none, and 400 MB, better 250, at 100 x 100.
"""

from __future__ import annotations

import argparse
import statistics
from typing import Any

from starting import processes

SIDE, SIDE_OF_MEMORY = 50, 100
SCENES = ("hang", "drape")


def warm(repeats: int) -> list[dict[str, Any]]:
    """First frames with the kernels on disk, in the order measured."""
    processes.first_frame(SIDE)  # puts them there
    return [processes.first_frame(SIDE) for _ in range(repeats)]


def cold(repeats: int) -> list[dict[str, Any]]:
    """First frames without."""
    taken = []
    for _ in range(repeats):
        with processes.empty_cache() as cache:
            taken.append(processes.first_frame(SIDE, cache))
    return taken


def memory() -> dict[str, dict[str, float]]:
    """MB that a process without ROS holds after 100 frames, by scene."""
    return {scene: processes.child("memory", SIDE_OF_MEMORY, scene) for scene in SCENES}


def show(name: str, taken: list[dict[str, Any]]) -> None:
    """Print minimum and median, and where the time of the quickest went."""
    best = min(taken, key=lambda one: one["first_frame_s"])
    median = statistics.median(one["first_frame_s"] for one in taken)
    print(
        f"{name}: {best['first_frame_s']:.2f} s, median {median:.2f} (Python {best['python_s']:.2f}, imports "
        f"{best['import_s']:.2f}, first step {best['step_s']:.2f}); kernels compiled: {best['compiled']}, "
        f"resident {best['resident_mb']:.0f} MB",
        flush=True,
    )


def show_node() -> None:
    """Print how long the node takes, with and without kernels on disk."""
    with processes.empty_cache() as cache:
        for name in ("empty cache", "warm cache"):
            taken = processes.node("drape", cache)
            if taken is None:
                print("node: not measured, it does not start here")
                return
            print(
                f"node, {name}: ready after {taken['ready_s']:.2f} s, {taken['prepared_s']:.2f} of them for the scene; "
                f"progress said {taken['progress']:.0f} times",
                flush=True,
            )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5, help="starts with a warm cache (default: %(default)s)")
    parser.add_argument("--cold", type=int, default=2, help="starts with an empty one (default: %(default)s)")
    parser.add_argument("--no-node", action="store_true", help="leave out the node")
    options = parser.parse_args()
    show("first frame, warm cache", warm(options.repeats))
    if options.cold:
        show("first frame, empty cache", cold(options.cold))
    if not options.no_node:
        show_node()
    for scene, taken in memory().items():
        print(
            f"memory, {scene} 100 x 100: {taken['resident_mb']:.0f} MB, at its peak {taken['peak_mb']:.0f}", flush=True
        )


if __name__ == "__main__":
    main()
