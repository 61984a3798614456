"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Mapping
from datetime import datetime, timezone
from importlib import metadata
from pathlib import Path

LIBRARIES = ("numpy", "scipy", "numba")
QUIET = 0.3
"""Cores that others may keep busy while times are measured."""


def describe() -> dict[str, str | int | float]:
    """Processor, cores, versions, and how busy the machine was with other things."""
    return {
        "date": datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC"),
        "cpu": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "load": round(_busy_cores(), 2),
        "system": platform.platform(terse=True),
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
    }


def sentence(described: Mapping[str, str | int | float]) -> str:
    """What :func:`describe` found, in words."""
    versions = ", ".join(f"{name} {described[name]}" for name in ("python", *LIBRARIES))
    busy = " (NOT QUIET: not a fair measurement)" if described["load"] > QUIET else ""
    return (
        f"{described['date']}, {described['cpu']}, {described['cores']} cores, {described['load']:g} of them busy"
        f"{busy}, {described['system']}, {versions}."
    )


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
