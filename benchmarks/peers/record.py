"""What is watched while an engine runs: the time of every frame, and how the cloth fares."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import metrics
import numpy as np
from workload import Scene

WARM_UP = 4  # frames left out of the statistics of time
MEAN_HEIGHT_AT = (0.16, 0.5, 1.0)  # s
FARTHEST = 50.0  # m; a vertex beyond has exploded


class Record:
    """What is watched from frame to frame."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.wall: list[float] = []
        self.cpu: list[float] = []
        self.stretch: list[float] = []
        self.depth: list[float] = []
        self.lowest: list[float] = []
        self.speed = 0.0
        self.threads = 0
        self.facts: dict[str, Any] = {}

    def see(self, frame: int, before: np.ndarray, position: np.ndarray) -> None:
        """Note how the cloth is at the end of ``frame``, counted from 0."""
        scene, now = self.scene, (frame + 1) * self.scene.frame_dt
        finite = bool(np.isfinite(position).all())
        if "bad_at_s" not in self.facts and not (finite and np.abs(position).max() <= FARTHEST):
            self.facts |= {"bad_at_s": now, "explosion": f"|x|>{FARTHEST:g} m" if finite else "NaN"}
        self.stretch.append(float(metrics.stretch(scene, position).max()) if finite else np.inf)
        if frame % 25 == 1:
            self.threads = max(self.threads, len(os.listdir("/proc/self/task")))
        if not finite:
            return
        self.speed = float(np.abs(position - before).max()) / scene.frame_dt
        if scene.sphere:
            self.depth.append(metrics.depth_in_sphere(position))
        if scene.ground:
            self.lowest.append(float(position[:, 2].min()))
        for instant in MEAN_HEIGHT_AT:
            if abs(now - instant) < 1e-6:
                self.facts[f"com_z_{instant:g}"] = float(position[:, 2].mean())

    def results(self) -> dict[str, Any]:
        """Times and worst values of the run."""
        found = summary("ms", self.wall) | summary("cpu_ms", self.cpu) | self.facts
        found |= {"frames": len(self.wall), "cores_used": sum(self.cpu) / sum(self.wall), "threads": self.threads}
        found["stretch_max_run"] = max(self.stretch)
        if self.depth:
            found |= {"pen_end_mm": 1e3 * self.depth[-1], "pen_max_mm": 1e3 * max(self.depth)}
        if self.lowest:
            found["ground_pen_max_mm"] = -1e3 * min(self.lowest)
        return found


def summary(prefix: str, seconds: Sequence[float]) -> dict[str, float]:
    """Statistics of the time of a frame in ms, the first frames left out."""
    ms = 1e3 * np.array(seconds[WARM_UP:] if len(seconds) > 10 else seconds)
    return {
        f"{prefix}_min": float(ms.min()),
        f"{prefix}_p10": float(np.percentile(ms, 10)),
        f"{prefix}_median": float(np.median(ms)),
        f"{prefix}_p95": float(np.percentile(ms, 95)),
        f"{prefix}_max": float(ms.max()),
        f"{prefix}_mean": float(ms.mean()),
    }
