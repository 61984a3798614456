"""Starting what is measured: fresh processes on two cores, with the kernels on disk or with an empty cache."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from comparison.process import CORES, THREADS

HERE = Path(__file__).resolve().parents[1]
NODE_WITHIN_S = 300.0
_READY = re.compile(r"ready after ([\d.]+) s")
_PROGRESS = re.compile(r"compiling kernel (\d+)")


def child(what: str, side: int, *more: str, cache: str | None = None) -> dict[str, Any]:
    """What ``starting.child`` measures in a process of its own, with its kernels cached in ``cache`` if given."""
    command = [sys.executable, "-m", "starting.child", what, str(side), *more]
    done = subprocess.run(command, env=_environment(cache), stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def first_frame(side: int, cache: str | None = None) -> dict[str, Any]:
    """From the start of Python to the first frame; see :func:`starting.child.first_frame`."""
    return child("first", side, repr(time.monotonic()), cache=cache)


@contextmanager
def empty_cache() -> Iterator[str]:
    """A folder for kernels that holds none."""
    with tempfile.TemporaryDirectory(prefix="kernels_") as folder:
        yield folder


def node(scene: str, cache: str | None = None) -> dict[str, float] | None:
    """Start the cloth node until it is ready to step; None where there is no ROS.

    Returns:
        ``ready_s`` since its process was started, ``prepared_s`` by its own account, and how many lines of
        ``progress`` it said meanwhile.
    """
    from cloth_sim_ros.command_line import free_domain

    environment = {
        **_environment(cache),
        "PYTHONUNBUFFERED": "1",
        "ROS_DOMAIN_ID": str(free_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    parameters = ["-p", f"scene:={scene}", "-p", "record:=none"]
    began, progress = time.monotonic(), 0
    process = subprocess.Popen(
        [sys.executable, "-m", "cloth_sim_ros.node", "--ros-args", *parameters],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        for line in process.stdout:
            progress += bool(_PROGRESS.search(line))
            if ready := _READY.search(line):
                took = time.monotonic() - began
                return {"ready_s": took, "prepared_s": float(ready[1]), "progress": progress}
        return None
    finally:
        process.terminate()
        process.communicate(timeout=NODE_WITHIN_S)


def _environment(cache: str | None) -> dict[str, str]:
    paths = os.pathsep.join(filter(None, (str(HERE), str(HERE.parent), os.environ.get("PYTHONPATH"))))
    return {
        **os.environ,
        **dict.fromkeys(THREADS, str(CORES)),
        "PYTHONPATH": paths,
        **({"NUMBA_CACHE_DIR": cache} if cache else {}),
    }
