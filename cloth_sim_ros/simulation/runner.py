"""An active simulation: every frame is published, timed and recorded; pause and reset come in between."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Protocol

from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.simulation.clock import Pace, Rhythm, Slot
from cloth_sim_ros.simulation.loop import SimulationLoop
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Frame, Simulation

SNAPSHOT_SECONDS = 1.0


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
        return self._loop.do(lambda: self._set_paused(paused)).result(timeout=10.0)

    def reset(self) -> str:
        """Begin a new episode; returns what happened, in words."""
        return self._loop.do(self._reset).result(timeout=10.0)

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

        self._hint(frame)

    def _hint(self, frame: Frame) -> None:
        """Say of grasps that hold nothing, or nothing any more, why that is."""
        for name in frame.report.empty:
            grasp = frame.inputs.grasps[name]
            where = ", ".join(f"{c:.3f}" for c in grasp.pose.position)
            nothing = f"no vertex is within its radius of {grasp.radius:g} m around ({where})"
            self._hints.say(f"grasp {name} closed on nothing", f"grasp {name} closed on nothing: {nothing}")
        for slip in frame.report.slips:
            if slip.load:
                most = self._simulation.solver.config.max_grasp_force
                why = f"it had to bear {slip.load:.3g} N, solver.max_grasp_force is {most:g} N"
            else:
                most = frame.inputs.grasps[slip.name].slip_distance
                why = f"its hand was {slip.beyond:.3g} m ahead of the cloth, slip_distance is {most:g} m"
            text = f"grasp {slip.name} lost the cloth: {why}; open and close it again"
            self._hints.say(f"grasp {slip.name} slipped", text)

    def _record(self, frame: Frame, stamp_ns: int) -> None:
        if self._recorder is not None:
            self._recorder.step(frame.step_index, frame.inputs, frame.report.sweeps, frame.digest, stamp_ns)
            if frame.step_index % self._snapshot_every == 0:
                self._record_snapshot(stamp_ns)

    def _record_snapshot(self, stamp_ns: int) -> None:
        if self._recorder is not None:
            state = self._simulation.state
            self._recorder.snapshot(self._simulation.solver.snapshot(state), state.step_index, stamp_ns)

    def _record_event(self, kind: str, stamp_ns: int) -> None:
        if self._recorder is not None:
            self._recorder.event(kind, self._simulation.state.step_index, stamp_ns)

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
        self._record_snapshot(now)
        return f"reset after step {step}"
