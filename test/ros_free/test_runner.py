"""An active simulation: frames go out and into the session; nothing that fails ends it."""

from __future__ import annotations

import re
import threading
from dataclasses import replace

import pytest

from cloth_core import Inputs, Pose
from cloth_core.scene import Scene
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.recording.verify import verify
from cloth_sim_ros.simulation import diagnostics
from cloth_sim_ros.simulation.clock import ClockPace
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.runner import Runner
from cloth_sim_ros.simulation.simulation import Simulation

SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 5, rows: 5}, position: [0.0, 0.0, 0.5]}
grasps: {hand: {radius: 0.1}, other: {radius: 0.1}}
"""
DT = 20_000_000
START = 1_000_000_000


class Outputs:
    """Collects the frames; ``troubles`` are raised once each, by step."""

    def __init__(self):
        self.frames = []
        self.troubles = {}
        self._changed = threading.Condition()

    def publish_points(self, frame, stamp_ns):
        with self._changed:
            self.frames.append((frame.step_index, stamp_ns))
            self._changed.notify()
        if frame.step_index in self.troubles:
            raise self.troubles.pop(frame.step_index)

    def publish_rest(self, frame, stamp_ns):
        pass

    def wait_for(self, count):
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.frames) >= count, 30.0), self.frames


class Kit:
    """A runner in step with a clock that the test drives."""

    def __init__(self, folder):
        self.said = []
        self.hints = Notices(self.said.append)
        self.outputs = Outputs()
        self.scene = Scene.parse(SCENE, name="small")
        self.simulation = Simulation(self.scene)
        self.recorder = Recorder.open(folder, self.scene, {}, self.simulation.solver, "/cloth_sim", record="inputs")
        self.pace = ClockPace(DT)
        self.pace.advance(START)
        self.now = START
        self.resets = 0
        self.runner = Runner(
            self.simulation,
            self.pace,
            self.outputs,
            self.recorder,
            Notices(self.said.append),
            hints=self.hints,
            ros_now=lambda: self.now,
            budget=0.8,
            on_reset=self.count_reset,
        )
        self.runner.start()

    def count_reset(self):
        self.resets += 1

    def steps(self, count):
        """Let the clock advance by so many steps, and wait until all are done."""
        done = len(self.outputs.frames)
        self.now += count * DT
        self.pace.advance(self.now)
        self.outputs.wait_for(done + count)

    def session(self):
        self.runner.stop()
        health = self.recorder.close()
        assert health.error is None
        return RecordedSession(health.folder)


@pytest.fixture
def kit(tmp_path):
    kit = Kit(tmp_path / "session")
    yield kit
    kit.runner.stop()
    kit.recorder.close()


def test_every_frame_is_published_and_recorded_with_the_stamp_of_its_slot(kit):
    kit.steps(60)
    session = kit.session()
    assert kit.outputs.frames == [(k, START + k * DT) for k in range(1, 61)]
    assert [step.index for step in session.steps()] == list(range(1, 61))
    assert [snapshot.index for snapshot in session.snapshots()] == [0, 50]
    assert verify(session).bit_equal


def test_pause_and_reset_happen_between_steps_and_stand_in_the_session(kit):
    kit.steps(5)
    assert kit.runner.pause(True) == "paused after step 5"
    assert kit.runner.pause(True) == "was paused already"
    kit.now += 3 * DT
    kit.pace.advance(kit.now)
    assert kit.runner.reset() == "reset after step 5"
    assert kit.runner.pause(False) == "goes on after step 0"
    kit.steps(4)
    session = kit.session()
    assert [index for index, _ in kit.outputs.frames] == [1, 2, 3, 4, 5, 1, 2, 3, 4]
    assert [(event.kind, event.index) for event in session.events()] == [("pause", 5), ("reset", 5), ("resume", 0)]
    assert [snapshot.index for snapshot in session.snapshots()] == [0, 0]
    assert kit.resets == 1
    assert verify(session).bit_equal


def test_a_clock_that_goes_back_resets(kit):
    kit.steps(5)
    kit.now = START // 2
    kit.pace.advance(kit.now)
    kit.steps(2)
    session = kit.session()
    assert [index for index, _ in kit.outputs.frames] == [1, 2, 3, 4, 5, 1, 2]
    assert [event.kind for event in session.events()] == ["reset"]
    assert verify(session).bit_equal


def test_a_publisher_that_fails_is_said_and_its_step_is_in_the_session_all_the_same(kit):
    kit.outputs.troubles[3] = OSError("no route")
    kit.steps(6)
    session = kit.session()
    assert [step.index for step in session.steps()] == [1, 2, 3, 4, 5, 6]
    assert len(kit.said) == 1
    assert "OSError: no route" in kit.said[0]
    assert verify(session).bit_equal


def test_a_step_that_fails_is_said_and_the_cloth_goes_on_from_where_it_was(kit):
    kit.steps(2)
    solver, good = kit.simulation.solver, kit.simulation.solver.step
    failed = threading.Event()

    def fail(*_arguments):
        failed.set()
        raise FloatingPointError("overflow")

    solver.step = fail
    kit.now += DT
    kit.pace.advance(kit.now)
    assert failed.wait(30.0)
    kit.runner.pause(True)  # comes after the failed step
    solver.step = good
    kit.runner.pause(False)
    kit.steps(2)
    session = kit.session()
    assert [index for index, _ in kit.outputs.frames] == [1, 2, 3, 4]
    assert "FloatingPointError: overflow" in kit.said[0]
    assert verify(session).bit_equal


def test_a_step_that_the_solver_had_to_mend_is_said(kit):
    kit.steps(2)
    solver, step = kit.simulation.solver, kit.simulation.solver.step

    def mended(*arguments):
        state = step(*arguments)
        solver.report = replace(solver.report, recovered=True)
        return state

    solver.step = mended
    kit.steps(1)
    kit.runner.pause(True)
    assert "step 3 was not finite" in kit.said[0]


def test_a_grasp_that_slips_is_said_and_stays_in_the_diagnostics_for_a_while(kit):
    for name, x in (("hand", -0.2), ("other", 0.2)):
        kit.simulation.set_grasp_pose(name, Pose((x, 0.0, 0.5)), 0.0)
        kit.simulation.set_closure(name, 1.0)
    kit.steps(2)
    assert not kit.said
    kit.simulation.set_grasp_pose("other", Pose((0.9, 0.0, 0.5)), 0.0)
    kit.steps(20)
    kit.runner.pause(True)
    assert not kit.runner.latest.report.slipped  # long ago
    assert re.match(
        r"grasp other lost the cloth: its hand was 0\.\d+ m ahead .*, slip_distance is 0.05 m; ", kit.said[0]
    )
    status = diagnostics.inputs(Notices(print), kit.hints, stale=(), undeclared=(), incompatible=())
    assert (status.level, status.message) == (diagnostics.Level.WARN, kit.said[0])
    assert status.values["grasps_without_cloth"] == "grasp other slipped: 1"


def test_a_grasp_that_had_to_bear_too_much_says_how_much(kit):
    solver = kit.simulation.solver
    kit.simulation.solver = solver.changed(config=replace(solver.config, max_grasp_force=0.1))
    kit.simulation.set_grasp_pose("hand", Pose((-0.2, 0.0, 0.5)), 0.0)
    kit.simulation.set_closure("hand", 1.0)
    kit.steps(40)
    kit.runner.pause(True)
    bore = (
        r"grasp hand lost the cloth: it had to bear 0\.\d+ N, solver.max_grasp_force is 0.1 N; open and close it again"
    )
    assert re.match(bore, kit.said[0])


def test_an_order_that_raises_gives_its_error_to_who_ordered(kit):
    def broken():
        raise KeyError("order")

    with pytest.raises(KeyError, match="order"):
        kit.runner._loop.do(broken).result(timeout=30.0)
    kit.steps(1)
    assert kit.runner.latest.inputs == Inputs(wind=kit.scene.inputs.wind)
