"""An active simulation: every frame is published, timed and recorded; pause and reset come in between."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable
from typing import Any, Protocol

from cloth_core import ClothSolver
from cloth_sim_ros.recording.content import in_force
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.simulation.clock import Pace, Rhythm, Slot
from cloth_sim_ros.simulation.frame import Frame
from cloth_sim_ros.simulation.hints import say_hints
from cloth_sim_ros.simulation.loop import SimulationLoop
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation

SNAPSHOT_SECONDS = 1.0


class OrderError(Exception):
    """Something was ordered that cannot be done now; the message says why."""


class FramePublisher(Protocol):
    """What frames go out through."""

    def publish_points(self, frame: Frame, stamp_ns: int) -> None:
        """Publish what must not wait."""

    def publish_rest(self, frame: Frame, stamp_ns: int) -> None:
        """Publish everything else."""


class Runner:
    """Steps a simulation from its start to :meth:`stop`.

    Args:
        simulation: what runs.
        pace: when it steps.
        outputs: publishes its frames.
        recorder: records them; None for no session.
        failures: is told of steps that went wrong.
        hints: is told of inputs that had no effect.
        ros_now: ROS time in ns.
        budget: share of a slot after which a step hurries up.
        on_reset: is called at every reset, also when the clock jumped back.
    """

    def __init__(
        self,
        simulation: Simulation,
        pace: Pace,
        outputs: FramePublisher,
        recorder: Recorder | None,
        failures: Notices,
        *,
        hints: Notices,
        ros_now: Callable[[], int],
        budget: float,
        on_reset: Callable[[], None],
    ) -> None:
        self.pace = pace
        self.rhythm = Rhythm()
        self.latest: Frame | None = None
        self._simulation = simulation
        self._outputs = outputs
        self._recorder = recorder
        self._failures = failures
        self._hints = hints
        self._ros_now = ros_now
        self._on_reset = on_reset
        config = simulation.solver.config
        self._snapshot_every = max(1, round(SNAPSHOT_SECONDS / config.dt))
        self._loop = SimulationLoop(
            simulation, pace, deliver=self._deliver, failed=self._fail, restart=self._reset, budget=budget
        )

    def start(self) -> None:
        """Begin to step."""
        self._record_snapshot(self._ros_now())
        self._loop.start()

    def stop(self) -> None:
        """End after the step at hand."""
        self._loop.stop()

    def pause(self, paused: bool) -> str:
        """Stop simulated time or let it go on; returns what happened, in words."""
        return self._order(lambda: self._set_paused(paused))

    def reset(self) -> str:
        """Begin a new episode; returns what happened, in words."""
        return self._order(self._reset)

    def step(self) -> str:
        """One step while paused; returns what happened, in words."""
        return self._order(self._step)

    def snapshot(self) -> str:
        """Keep the cloth as it is; returns what happened, in words."""
        return self._order(self._keep)

    def restore(self) -> str:
        """Back to the last :meth:`snapshot`; returns what happened, in words."""
        return self._order(self._restore)

    def adopt(self, solver: ClothSolver) -> str:
        """Go on with another solver; returns what happened, in words."""
        return self._order(lambda: self._adopt(solver))

    def set_budget(self, budget: float) -> None:
        """Share of a slot after which a step hurries up, from the next one on."""
        self._loop.budget = budget

    def _order(self, action: Callable[[], str]) -> str:
        """Have ``action`` done between two steps."""
        return self._loop.do(action).result(timeout=10.0)

    def _deliver(self, frame: Frame, slot: Slot) -> None:
        self.latest = frame
        try:
            self._outputs.publish_points(frame, slot.stamp_ns)
            self.rhythm.note(slot, frame.step_seconds)
            self._outputs.publish_rest(frame, slot.stamp_ns)
        finally:  # a session with a step left out could not be computed again
            self._record(frame, slot.stamp_ns)
        if frame.report.recovered:
            problem = f"step {frame.step_index} was not finite; the cloth was put to rest where it was before"
            self._failures.say("not finite, put to rest", problem)
        say_hints(self._hints, frame, self._simulation.solver.config.max_grasp_force)

    def _record(self, frame: Frame, stamp_ns: int) -> None:
        if self._recorder is not None:
            if frame.pins is not None:
                self._recorder.event("pins", frame.step_index - 1, stamp_ns, vertices=frame.pins.tolist())
            self._recorder.step(frame.step_index, frame.inputs, frame.report.sweeps, frame.digest, stamp_ns)
            if frame.step_index % self._snapshot_every == 0:
                self._record_snapshot(stamp_ns)

    def _record_snapshot(self, stamp_ns: int) -> None:
        if self._recorder is not None:
            state = self._simulation.state
            self._recorder.snapshot(self._simulation.solver.snapshot(state), state.step_index, stamp_ns)

    def _record_event(self, kind: str, stamp_ns: int, **details: Any) -> None:
        if self._recorder is not None:
            self._recorder.event(kind, self._simulation.state.step_index, stamp_ns, **details)

    def _fail(self, error: Exception) -> None:
        where = traceback.extract_tb(error.__traceback__)[-1]
        problem = f"{type(error).__name__}: {error} ({where.name}, line {where.lineno})"
        self._failures.say(type(error).__name__, f"a step failed, the cloth stays as it was: {problem}")

    def _set_paused(self, paused: bool) -> str:
        if paused == self._simulation.paused:
            return "was paused already" if paused else "was not paused"
        self._simulation.paused = paused
        self.rhythm.forget()
        self._record_event("pause" if paused else "resume", self._ros_now())
        step = self._simulation.state.step_index
        return f"paused after step {step}" if paused else f"goes on after step {step}"

    def _reset(self) -> str:
        now, step = self._ros_now(), self._simulation.state.step_index
        self._record_event("reset", now)
        self._simulation.reset()
        self._on_reset()
        self._begin_episode(now)
        return f"reset after step {step}"

    def _step(self) -> str:
        if not self._simulation.paused:
            raise OrderError("it is not paused: call ~/pause with true before")
        slot = Slot(self._ros_now(), None, round(1e9 * self._simulation.solver.config.dt))
        self._deliver(self._simulation.tick(time.monotonic()), slot)
        return f"paused after step {self._simulation.state.step_index}"

    def _adopt(self, solver: ClothSolver) -> str:
        self._simulation.adopt(solver)
        self._record_event("parameters", self._ros_now(), **in_force(solver))
        return f"in force after step {self._simulation.state.step_index}"

    def _keep(self) -> str:
        self._simulation.kept = kept = self._simulation.keep()
        self._record_event("snapshot", self._ros_now())
        return f"kept step {kept.step_index}"

    def _restore(self) -> str:
        kept = self._simulation.kept
        if kept is None:
            raise OrderError("nothing was kept: call ~/snapshot before")
        now, step = self._ros_now(), self._simulation.state.step_index
        self._record_event("restore", now, to=kept.step_index)
        self._simulation.restore(kept)
        self._on_reset()
        self._begin_episode(now)
        other = "" if kept.solver is self._simulation.solver else ", with other parameters than it was kept with"
        return f"back from step {step} to step {kept.step_index}{other}"

    def _begin_episode(self, now: int) -> None:
        """Record where the cloth is now, and show it while nothing else does."""
        self._record_snapshot(now)
        if self._simulation.paused:
            frame = self._simulation.present()
            self._outputs.publish_points(frame, now)
            self._outputs.publish_rest(frame, now)
