"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import time
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path


def describe() -> dict[str, str | int | float]:
    """Processor, cores, versions, and how busy the machine was with other things."""
    return {
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "cpu": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load": round(_busy_cores(), 2),
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in ("numpy", "scipy", "numba")},
    }


def _busy_cores(seconds: float = 2.0) -> float:
    """How many cores others keep busy just now; a load average would still count what we did a minute ago."""
    before, began = _ticks_at_work(), time.monotonic()
    time.sleep(seconds)
    return (_ticks_at_work() - before) / os.sysconf("SC_CLK_TCK") / (time.monotonic() - began)


def _ticks_at_work() -> int:
    user, nice, system, _idle, _waiting, *interrupts = map(
        int, Path("/proc/stat").read_text().split("\n")[0].split()[1:]
    )
    return user + nice + system + sum(interrupts[:3])  # irq, softirq, steal


def _processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(":")[2].strip()
    return platform.machine()
