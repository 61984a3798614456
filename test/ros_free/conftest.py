"""Sessions recorded without a node: the solver driven directly, its steps given to a Recorder."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cloth_core import State
from cloth_core.scene import Scene
from cloth_sim_ros.messages.cdr import PointCloudEncoder
from cloth_sim_ros.recording.content import Event, Snapshot, Step
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.session import SessionWriter

NAMESPACE = "/cloth_sim"
POINTS = "sensor_msgs/msg/PointCloud2"
SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 9, rows: 9}, position: [0.0, 0.0, 0.35]}
material: {areal_density: 0.2, stretch_warp: 40.0, stretch_weft: 40.0, stretch_limit: 1.01, friction: 0.4}
obstacles:
  ball: {sphere: {radius: 0.1, center: [0.0, 0.0, 0.2]}}
  floor: {plane: {normal: [0.1, 0.0, 1.0]}}
grasps: {hand: {radius: 0.08, position: [0.2, 0.2, 0.35]}}
wind: {velocity: [1.0, 0.3, 0.1], gust_intensity: 0.3}
pins: [bottom_left]
script:
  grasps:
    hand:
      - {at: 0.0, position: [0.2, 0.2, 0.35], closure: 1.0}
      - {at: 0.6, position: [0.1, 0.1, 0.6], closure: 1.0}
      - {at: 0.7, position: [0.1, 0.1, 0.6]}
  obstacles:
    ball:
      - {at: 0.0, position: [0.0, 0.0, 0.2]}
      - {at: 1.0, position: [0.1, 0.0, 0.25]}
"""
STEP_NS = 20_000_000


class ClothSession:
    """Records a scripted scene, step by step, as a node would."""

    def __init__(self, folder: Path, *, record: str = "inputs", more: str = "") -> None:
        self.scene = Scene.parse(SCENE + more, name="small")
        self.solver, self.state = self.scene.build()
        self.recorder = Recorder.open(folder, self.scene, {"rate": 50}, self.solver, NAMESPACE, record=record)
        self.stamp_ns = 1_000_000_000
        self._encoder = PointCloudEncoder("world")
        self.snapshot()

    def snapshot(self) -> None:
        """Record all of the state."""
        self.recorder.snapshot(self.solver.snapshot(self.state), self.state.step_index, self.stamp_ns)

    def run(self, steps: int, *, snapshot_every: int = 10, cut_short_at: int | None = None) -> State:
        """Go on for some steps; the solver's time is up in the middle of step ``cut_short_at``."""
        for _ in range(steps):
            short = self.state.step_index + 1 == cut_short_at
            inputs = self.scene.script.inputs_at(self.state.time, self.scene.inputs)
            self.state = self.solver.step(self.state, inputs, out_of_time=lambda: short)  # noqa: B023
            self.stamp_ns += STEP_NS
            sweeps = self.solver.report.sweeps
            self.recorder.step(self.state.step_index, inputs, sweeps, self.state.digest, self.stamp_ns)
            flat = self.state.position
            cloud = self._encoder.encode(self.stamp_ns, flat, flat * 0.0, flat[:, 0] * 0.0)
            self.recorder.output(f"{NAMESPACE}/cloth/points", POINTS, cloud, self.stamp_ns)
            if self.state.step_index % snapshot_every == 0:
                self.snapshot()
        return self.state

    def reset(self) -> None:
        """Begin a new episode."""
        self.recorder.event("reset", self.state.step_index, self.stamp_ns)
        self.state = self.solver.initial_state(self.scene.placement)
        self.snapshot()

    def restore(self, solver_snapshot: Mapping[str, np.ndarray]) -> None:
        """Go back to an earlier snapshot."""
        self.recorder.event("restore", self.state.step_index, self.stamp_ns)
        self.state = self.solver.restore(solver_snapshot)
        self.snapshot()

    def close(self) -> Path:
        """Finish the file; returns its folder."""
        health = self.recorder.close()
        assert health.error is None
        return health.folder


def rewrite(source: Path, destination: Path, change: Callable[[Any], Any]) -> Path:
    """The session at ``source`` again, each of its steps, snapshots and events passed through ``change``."""
    session = RecordedSession(source)
    kinds = {f"{NAMESPACE}/{kind.topic}": kind for kind in (Step, Snapshot, Event)}
    reader = session.reader
    with SessionWriter(destination, attachments=reader.attachments, metadata=reader.metadata) as writer:
        for record in reader.messages():
            kind = kinds.get(record.topic)
            cdr = change(kind.decode(record.cdr)).encode() if kind else record.cdr
            writer.write(record.topic, record.type_name, cdr, record.log_time_ns)
    return destination


@pytest.fixture
def cloth_session(tmp_path: Path) -> Callable[..., ClothSession]:
    """Begins to record a small scene: ``cloth_session(record="inputs")``."""

    def begin(**options: Any) -> ClothSession:
        return ClothSession(tmp_path / f"session_{uuid.uuid4().hex[:8]}", **options)

    return begin


@pytest.fixture
def tampered(tmp_path: Path) -> Callable[..., Path]:
    """A session written again with changed entries: ``tampered(session, change)``."""
    return lambda source, change: rewrite(source, tmp_path / f"tampered_{uuid.uuid4().hex[:8]}", change)
