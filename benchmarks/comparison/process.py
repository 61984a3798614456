"""One run in a process of its own: the interpreter of its engine, its cores, its time limit."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from comparison.plan import Job

ROOT = Path(__file__).resolve().parents[2]
HARNESS = ROOT / "benchmarks" / "peers"
ENVIRONMENTS = ROOT / ".venv-peers"
NOT_INSTALLED = "not installed"
START_UP_S = 120.0  # beyond the time of the frames: imports, compiling, building, measuring
# What the ROS wheels of our own environment leave behind would lead another environment's Python to our libraries.
LEFT_BY_ROS = ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "PYTHONPATH")
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
CORES = int(os.environ.get("NUMBA_NUM_THREADS") or min(2, len(os.sched_getaffinity(0))))
"""That a run has if nothing else is asked for: the bars are meant for two."""


def interpreter(engine: str) -> Path | None:
    """The Python of the engine's environment, None where ``make peers`` has not made one."""
    if engine == "ours":
        return Path(sys.executable)
    python = ENVIRONMENTS / engine / "bin" / "python"
    return python if python.exists() else None


def play(job: Job, *, threads: int = CORES, max_wall: float = 60.0, frames: int = 0) -> dict[str, Any]:
    """Run a job, pinned to ``threads`` cores, and return what the harness measured; failures say so in ``status``.

    Args:
        job: what to run.
        threads: cores and threads that the engine has.
        max_wall: seconds of frames after which it is stopped.
        frames: stop after so many; 0 for the whole scenario.
    """
    contestant = job.contestant
    known = dict(engine=contestant.engine, variant=contestant.variant, n=job.n, scenario=job.scenario)
    python = interpreter(contestant.engine)
    if python is None:
        return {**known, "status": NOT_INSTALLED}
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "result.json"
        limits = {"threads": threads, "max-wall": max_wall, "frames": frames, "json": output}
        options = {"n": job.n, "scenario": job.scenario, "variant": contestant.variant, **limits}
        command = [str(python), f"bench_{contestant.engine}.py"]
        command += [text for name, value in options.items() for text in (f"--{name}", str(value))]
        outcome = _finish(command, threads, 2.0 * max_wall + START_UP_S)
        return json.loads(output.read_text()) if output.exists() else {**known, "status": outcome}


def _finish(command: list[str], threads: int, limit: float) -> str:
    """Run a command of the harness to its end; how it ended."""
    environment = {name: value for name, value in os.environ.items() if name not in LEFT_BY_ROS}
    environment |= dict.fromkeys(THREADS, str(threads))
    cores = sorted(os.sched_getaffinity(0))[-threads:]
    try:
        done = subprocess.run(
            ["taskset", "--cpu-list", ",".join(map(str, cores)), *command],
            cwd=HARNESS, env=environment, timeout=limit, capture_output=True, text=True, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"killed after {limit:.0f} s"
    last = (done.stderr.strip().splitlines() or ["no message"])[-1]
    return f"crashed (exit {done.returncode}): {last[:200]}"


def merged(repeats: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Repeats of a job as one: medians of what was measured, the rest of the first; a failure stands for all."""
    failed = [result for result in repeats if result["status"] != "ok"]
    if failed:
        return {**failed[0], "repeats": len(repeats)}
    one: dict[str, Any] = {}
    for result in reversed(repeats):
        one |= result
    for key, value in one.items():
        if isinstance(value, float):
            median = statistics.median([result[key] for result in repeats if key in result])
            one[key] = float(f"{median:.6g}")
    return {**one, "repeats": len(repeats)}
