"""What a frame costs beside the solver: numbers out of the state, messages, publishing, the session."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from marks.row import Row
from rclpy.signals import SignalHandlerOptions

FRAMES_A_SECOND = 50
SWITCH_SECONDS = 1e-4  # as the node's own process has it


def rows(folder: Path, seconds: float) -> Iterator[Row]:
    """The parts of the node itself, driven frame by frame in this process, beside its recorder."""
    import rclpy

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        for record in ("outputs", "none"):
            wall, busy = _measure(folder / record, record, int(seconds * FRAMES_A_SECOND))
            note = f"record {record}, p99 {np.percentile(wall, 99):.2f} ms, processor time p50 {np.median(busy):.2f} ms"
            what = "everything but the solver, per frame, 2,500 vertices: p50"
            yield Row(what, "ms", 1.5, 0.5, float(np.median(wall)), note=note)
    finally:
        rclpy.try_shutdown()


def _measure(folder: Path, record: str, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """ms per frame: passed, and spent by the thread that steps."""
    from rclpy.parameter import Parameter

    from cloth_sim_ros.ros.cloth_node import ClothNode

    sys.setswitchinterval(SWITCH_SECONDS)
    overrides = {"scene": "drape", "session_folder": str(folder), "record": record, "autostart": False}
    node = ClothNode(parameter_overrides=[Parameter(name, value=value) for name, value in overrides.items()])
    node.trigger_configure()
    node.trigger_activate()
    try:
        runner = node._runner
        runner.pause(True)
        solver = _Stopwatch(node._parts.simulation.solver)
        node._parts.simulation.solver = solver
        taken = np.array([_frame(runner, solver) for _ in range(frames)])
    finally:
        node.close()
        node.destroy_node()
    return 1e3 * taken[:, 0], 1e3 * taken[:, 1]


def _frame(runner: Any, solver: _Stopwatch) -> tuple[float, float]:
    time.sleep(0.01)
    wall, busy = time.perf_counter(), time.thread_time()
    runner._step()
    return time.perf_counter() - wall - solver.wall, time.thread_time() - busy - solver.busy


class _Stopwatch:
    """A solver whose steps are timed."""

    def __init__(self, solver: Any) -> None:
        self._solver = solver
        self.wall = self.busy = 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._solver, name)

    def step(self, *arguments: Any) -> Any:
        wall, busy = time.perf_counter(), time.thread_time()
        state = self._solver.step(*arguments)
        self.wall, self.busy = time.perf_counter() - wall, time.thread_time() - busy
        return state
