"""Simulating a session again from its recorded inputs, and comparing what comes out bit by bit."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cloth_core import State
from cloth_sim_ros.recording.content import Snapshot, Step
from cloth_sim_ros.recording.follow import Follower
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.session import SessionError

Progress = Callable[[int, float], None]
_POINT_BYTES = 32


@dataclass(frozen=True)
class Difference:
    """Where the simulation first parted from the recording.

    Args:
        step: the first step that came out differently.
        vertex: the first vertex that differs; None when the session does not tell, because it recorded
            neither points nor a snapshot from there on.
        distance: how far that vertex is off, in ``unit``.
        unit: ``m`` for a position, ``m/s`` for a velocity.
        seen_at: the step whose points or snapshot gave the vertex.
    """

    step: int
    vertex: int | None = None
    distance: float = 0.0
    unit: str = "m"
    seen_at: int | None = None

    def __str__(self) -> str:
        """In a sentence's words."""
        if self.vertex is None:
            return f"step {self.step} (no points or snapshot tell which vertex)"
        later = f", seen in the snapshot of step {self.seen_at}" if self.seen_at != self.step else ""
        return f"step {self.step}, vertex {self.vertex}, off by {self.distance:.3g} {self.unit}{later}"


@dataclass(frozen=True)
class Verification:
    """What came of simulating a session again.

    Args:
        steps: steps computed and compared.
        snapshots: snapshots compared.
        first_difference: None when all of it was bit-equal.
        simulated_seconds: s of simulated time.
        wall_seconds: s that it took, reading included.
    """

    steps: int
    snapshots: int
    first_difference: Difference | None
    simulated_seconds: float
    wall_seconds: float

    @property
    def bit_equal(self) -> bool:
        """Every step and snapshot came out as recorded, to the last bit."""
        return self.first_difference is None

    @property
    def realtime_factor(self) -> float:
        """How many times faster than real time."""
        return self.simulated_seconds / self.wall_seconds


def verify(session: RecordedSession, on_progress: Progress | None = None) -> Verification:
    """Simulate ``session`` again, forcing the recorded sweeps, up to its end or the first difference.

    Args:
        session: what was recorded.
        on_progress: called after every step with the steps done and the wall time in s.

    Raises:
        SessionError: the session is damaged, or holds no step that can be computed again.
    """
    return _Rerun(session, on_progress).run()


class _Rerun:
    """The simulation that follows the recording entry by entry, and what it is compared with."""

    def __init__(self, session: RecordedSession, on_progress: Progress | None) -> None:
        self._session = session
        self._on_progress = on_progress
        self._follower = Follower(session)
        self._steps = self._snapshots = 0
        self._difference: Difference | None = None
        self._start = 0.0

    def run(self) -> Verification:
        """Follow the recording until it ends, or until a difference has been pinned down."""
        self._start = time.perf_counter()
        for stamp_ns, entry in self._session.entries():
            self._follower.follow(entry)
            if isinstance(entry, Step):
                self._check_step(entry, stamp_ns)
            elif isinstance(entry, Snapshot):
                self._check_snapshot(entry)
            if self._difference is not None and (self._difference.vertex is not None or not isinstance(entry, Step)):
                break  # nothing later tells more
        if self._steps == 0:
            raise SessionError(f"{self._session.path}: holds no step to compare")
        wall = time.perf_counter() - self._start
        simulated = self._steps * self._follower.solver.config.dt
        return Verification(self._steps, self._snapshots, self._difference, simulated, wall)

    @property
    def _state(self) -> State:
        assert self._follower.state is not None
        return self._follower.state

    def _check_step(self, step: Step, stamp_ns: int) -> None:
        self._steps += 1
        if self._on_progress is not None:
            self._on_progress(self._steps, time.perf_counter() - self._start)
        if self._difference is None and self._state.digest != step.digest:
            self._difference = self._locate_in_points(Difference(step.index), stamp_ns)

    def _check_snapshot(self, snapshot: Snapshot) -> None:
        try:
            recorded = State.from_arrays(snapshot.arrays)
        except (KeyError, ValueError) as error:
            raise SessionError(
                f"{self._session.path}: the snapshot of step {snapshot.index} is damaged: {error}"
            ) from error
        if snapshot.index != self._state.step_index:
            raise SessionError(
                f"{self._session.path}: a snapshot of step {snapshot.index} follows step {self._state.step_index}"
            )
        self._snapshots += 1
        at = self._difference or Difference(snapshot.index)
        found = _locate(at, self._state.position, recorded.position, "m", snapshot.index)
        found = found or _locate(at, self._state.velocity, recorded.velocity, "m/s", snapshot.index)
        self._difference = found or self._difference

    def _locate_in_points(self, difference: Difference, stamp_ns: int) -> Difference:
        """The difference with its vertex, if the points of that step were recorded and show it in float32."""
        size = _POINT_BYTES * self._follower.solver.mesh.vertex_count
        for record in self._session.outputs("cloth/points"):
            data = record.cdr[-1 - size : -1]  # the points end right before the last field, is_dense
            if record.log_time_ns == stamp_ns and record.cdr[-5 - size : -1 - size] == struct.pack("<I", size):
                points = np.frombuffer(data, "<f4").reshape(-1, _POINT_BYTES // 4)[:, :3]
                position = self._state.position.astype(np.float32)
                return _locate(difference, position, points, "m", difference.step) or difference
        return difference


def _locate(at: Difference, ours: np.ndarray, theirs: np.ndarray, unit: str, step: int) -> Difference | None:
    """The first vertex whose three numbers are not bit-equal, or None."""
    bits = [np.ascontiguousarray(values).view(np.uint8).reshape(len(ours), -1) for values in (ours, theirs)]
    vertices = np.flatnonzero((bits[0] != bits[1]).any(axis=1))
    if len(vertices) == 0:
        return None
    vertex = int(vertices[0])
    distance = float(np.linalg.norm(ours[vertex].astype(float) - theirs[vertex].astype(float)))
    return replace(at, vertex=vertex, distance=distance, unit=unit, seen_at=step)
