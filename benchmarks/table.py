"""Our solver beside other engines on the same work: stretch, time of a frame, and who is good enough to be compared.

    make peers                                          installs the others, each in an environment of its own
    python benchmarks/table.py                          everything, three times over: takes long
    python benchmarks/table.py --quick --sizes 20 50    a first look
    python benchmarks/table.py --show                   the last results again

Every run is a process of its own, one at a time, pinned to its cores. Peers that are not installed are left out.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any

from comparison import machine, plan, plot, process, report
from comparison.gate import faults, stopped_early

RESULTS = process.ROOT / "benchmarks" / "results" / "table.json"
PICTURE = process.ROOT / "docs" / "images" / "bench.svg"
SIZES = (20, 50, 71, 100, 200)
REPEATS = 3


def main() -> int:
    """Measure or read, print, draw; exit code 1 if ours did not run."""
    options = _options()
    document = json.loads(options.json.read_text()) if options.show else measure(options)
    if not options.show:
        save(document, options.json)
    print(report.report(document))
    if not plot.draw(document, options.plot):
        print("no picture: matplotlib is not installed (pip install '.[bench]')", file=sys.stderr)
    ours = [result for result in document["results"] if result["engine"] == "ours"]
    return int(any(result["status"] != "ok" for result in ours))


def measure(options: argparse.Namespace) -> dict[str, Any]:
    """Play all jobs, round by round; what took too long once is not repeated."""
    before = machine.describe()
    round_of_jobs = list(plan.jobs(options.peers, options.scenarios, options.sizes))
    repeats = 1 if options.quick else REPEATS
    played: dict[plan.Job, list[dict[str, Any]]] = defaultdict(list)
    for turn in range(repeats):
        for number, job in enumerate(round_of_jobs):
            if turn and (played[job][0]["status"] != "ok" or stopped_early(played[job][0])):
                continue
            result = process.play(job, threads=options.threads, max_wall=options.max_wall, frames=options.frames)
            played[job].append(result)
            done = f"[{turn * len(round_of_jobs) + number + 1:3d}/{repeats * len(round_of_jobs)}]"
            print(f"{done} {job.title}: {_outcome(result)}", file=sys.stderr, flush=True)
    how = {"threads": options.threads, "repeats": repeats, "max_wall_s": options.max_wall}
    return {"machine": before, "how": how, "results": [process.merged(results) for results in played.values()]}


def save(document: dict[str, Any], path: Path) -> None:
    """Write a document, each result on a line of its own, so that two of them can be compared."""
    path.parent.mkdir(parents=True, exist_ok=True)
    head = json.dumps({key: document[key] for key in ("machine", "how")}, indent=1)[:-2]
    lines = ",\n".join("  " + json.dumps(result) for result in document["results"])
    path.write_text(f'{head},\n "results": [\n{lines}\n ]\n}}\n')


def _outcome(result: dict[str, Any]) -> str:
    if "ms_median" not in result:
        return result["status"]
    wrong = faults(result)
    return f"{result['ms_median']:.2f} ms" + (f"   fails: {'; '.join(wrong)}" if wrong else "")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="N", help="vertices a side")
    parser.add_argument("--scenarios", nargs="+", choices=plan.SCENARIOS, default=["hang", "drape", "drag"])
    parser.add_argument("--peers", nargs="+", choices=plan.ENGINES, default=plan.ENGINES, help="who takes part")
    parser.add_argument("--quick", action="store_true", help=f"one repeat instead of {REPEATS}")
    cores = range(1, len(os.sched_getaffinity(0)) + 1)
    parser.add_argument(
        "--threads", type=int, default=process.CORES, choices=cores, help="cores of a run (default: %(default)s)"
    )
    parser.add_argument("--max-wall", type=float, default=60.0, help="stop a run after so many seconds of frames")
    parser.add_argument("--frames", type=int, default=0, help="stop a run after so many frames; 0: when it is over")
    parser.add_argument("--json", type=Path, default=RESULTS, help="write the results there (default: %(default)s)")
    parser.add_argument("--plot", type=Path, default=PICTURE, help="draw them there (default: %(default)s)")
    parser.add_argument("--show", action="store_true", help="measure nothing: read the results from --json")
    options = parser.parse_args()
    if options.show and not options.json.exists():
        parser.error(f"--show: there are no results in {options.json}")
    return options


if __name__ == "__main__":
    sys.exit(main())
