"""What takes long: a session simulated again, and an hour under an accelerated clock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

from marks.row import Row
from rosgraph_msgs.msg import Clock

from cloth_core.scene import Scene
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.recording.verify import verify
from cloth_sim_ros.share import find_scene
from cloth_sim_ros.simulation.simulation import Simulation
from soaking.node import NAME, Node, resources
from soaking.scenes import hanging

HOUR_S = 3600.0
WARM_STEPS = 500


def again(folder: Path, seconds: float) -> Iterator[Row]:
    """A session of the scarf (2,160 vertices), its hand, ball and gusts, simulated again and compared."""
    scene = Scene.load(find_scene("scarf"))
    simulation = Simulation(scene)
    recorder = Recorder.open(folder / "session", scene, {}, simulation.solver, NAME, record="inputs")
    state, solver, dt = simulation.state, simulation.solver, scene.solver.dt
    recorder.snapshot(solver.snapshot(state), 0, 1)
    for step in range(1, int(seconds / dt) + 1):
        inputs = scene.script.inputs_at(state.time, scene.inputs)
        state = solver.step(state, inputs)
        recorder.step(step, inputs, solver.report.sweeps, state.digest, 1 + round(step * dt * 1e9))
        if step % round(1.0 / dt) == 0:
            recorder.snapshot(solver.snapshot(state), step, 1 + round(step * dt * 1e9))
    recorder.close()
    result = verify(RecordedSession(folder / "session"))
    where = f"{seconds:g} s of the scarf simulated again"
    yield Row(f"{where}: not bit-equal", "", 0.0, 0.0, float(not result.bit_equal))
    note = f"{result.realtime_factor:.2f} times as fast as real time"
    yield Row(f"{where}: time", "s/s", 1 / 3, 1 / 8, 1.0 / result.realtime_factor, note=note)


def hour(folder: Path, seconds: float) -> Iterator[Row]:
    """Memory, files and threads while /clock drives the node as fast as it goes: an hour of it, or less."""
    simulated = HOUR_S if seconds >= 600.0 else 6.0 * seconds
    node = Node(hanging(folder, 15), folder, use_sim_time=True, record="inputs")
    clock = node.peer.node.create_publisher(Clock, "/clock", 10)
    try:
        node.wait(clock.get_subscription_count, 300.0)
        reached = _drive(node, clock, 0, WARM_STEPS)
        before = resources(node.process.pid)
        begin = time.monotonic()
        done = _drive(node, clock, reached, reached + int(simulated / 0.02)) - reached
        wall = time.monotonic() - begin
        after = resources(node.process.pid)
    finally:
        code = node.close()
    where = f"{done * 0.02:g} s under /clock"
    note = f"in {wall:.0f} s, {before[0]:.0f} MB before, exit code {code}"
    yield Row(f"{where}: memory grown", "MB", 5.0, 0.0, after[0] - before[0], note=note)
    yield Row(f"{where}: file handles grown", "", 0.0, 0.0, after[1] - before[1])
    yield Row(f"{where}: threads grown", "", 0.0, 0.0, after[2] - before[2])


def _drive(node: Node, clock: object, first: int, last: int) -> int:
    """Advance the clock step by step, some steps ahead of the node; returns the step reached."""
    step, ahead = first, 10
    while step < last:
        step = min(last, step + ahead)
        now = Clock()
        now.clock.sec, now.clock.nanosec = divmod(1_000_000_000_000 + step * 20_000_000, 10**9)
        count = len(node.clouds)
        clock.publish(now)
        node.wait(lambda count=count: len(node.clouds) > count + ahead // 2, 0.2)
        if len(node.clouds) > 1000:
            del node.clouds[:-10]
    return step
