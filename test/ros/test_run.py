"""cloth_run from end to end: real processes, real Fast DDS, a real session."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify

SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 9, rows: 9}, position: [0.0, 0.0, 0.35]}
obstacles: {ball: {sphere: {radius: 0.1, center: [0.0, 0.0, 0.2]}}}
grasps: {hand: {radius: 0.08, position: [0.2, 0.2, 0.35]}}
pins: [bottom_left, top_right]
script:
  grasps:
    hand:
      - {at: 0.0, position: [0.2, -0.2, 0.35], closure: 1.0}
      - {at: 1.0, position: [0.2, -0.2, 0.45], closure: 1.0}
  obstacles:
    ball:
      - {at: 0.0, position: [0.0, 0.0, 0.2]}
      - {at: 1.0, position: [0.1, 0.0, 0.22]}
  wind:
    - {at: 0.0, velocity: [0.0, 0.0, 0.0]}
    - {at: 1.0, velocity: [2.0, 1.0, 0.0]}
"""
STARTS_WITHIN_S = 240  # kernels may have to be compiled
STATUS = re.compile(r"^ *\d+\.\d\d s \| +\d+\.\d Hz \| step .* ms .* \| stretch \d\.\d+ \| holds ")


@pytest.fixture
def run(tmp_path):
    """Starts cloth_run on a small scene, recording below ``tmp_path``; what it started is ended after the test."""
    (tmp_path / "small.yaml").write_text(SCENE)
    started: list[subprocess.Popen[str]] = []

    def start(*options: str, parameters: tuple[str, ...] = ()) -> subprocess.Popen[str]:
        own = [sys.executable, "-m", "cloth_sim_ros.run", "--scene", str(tmp_path / "small.yaml")]
        all_parameters = (f"session_folder:={tmp_path / 'sessions'}", *parameters)
        for_ros = ["--ros-args", *(word for parameter in all_parameters for word in ("-p", parameter))]
        process = subprocess.Popen(
            [*own, *options, *for_ros],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(60)
        process.stdout.close()
        process.stderr.close()


def test_a_run_of_a_few_seconds_leaves_a_session_that_verifies_and_that_rosbags_reads(run, tmp_path):
    process = run("--duration", "3", parameters=("record:=outputs",))
    printed, complaints = process.communicate(timeout=STARTS_WITHIN_S)
    assert process.returncode == 0, printed + complaints
    lines = printed.splitlines()
    status = [line for line in lines if STATUS.match(line)]
    assert len(status) >= 2
    assert any("holds hand (" in line for line in status)
    (folder,) = (tmp_path / "sessions").iterdir()
    assert str(folder) in status[-1]
    assert any(line.startswith("Session:") and folder.name in line for line in lines)
    assert any("cloth_replay" in line and folder.name in line for line in lines)
    the_operator_s_messages_were_recorded(folder)
    a_foreign_reader_sees_the_same(folder)
    result = verify(RecordedSession(folder))
    assert result.bit_equal, result.first_difference
    assert result.steps >= 50


def the_operator_s_messages_were_recorded(folder: Path) -> None:
    session = RecordedSession(folder)
    assert session.complete
    for name in ("grasp/hand/pose", "grasp/hand/closure", "obstacle/ball/pose", "wind"):
        assert len(list(session.outputs(name))) > 10, name
    last = list(session.steps())[-1]
    assert last.inputs.grasps["hand"].closure == 1.0
    assert last.inputs.obstacles["ball"].position != (0.0, 0.0, 0.2)
    assert last.inputs.wind.velocity[0] > 0


def a_foreign_reader_sees_the_same(folder: Path) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel", reason="needs rosbags")
    with highlevel.AnyReader([folder]) as reader:
        points = [c for c in reader.connections if c.topic == "/cloth_sim/cloth/points"]
        clouds = [reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages(points)]
        steps = [c for c in reader.connections if c.topic == "/cloth_sim/session/step"]
        assert len(clouds) == sum(1 for _ in reader.messages(steps))
    assert {(cloud.height, cloud.width, cloud.header.frame_id) for cloud in clouds} == {(1, 81, "world")}


def test_ctrl_c_ends_everything_and_leaves_a_complete_session(run, tmp_path):
    process = run()
    wait_for_status(process)
    children = children_of(process.pid)
    assert len(children) == 2
    process.send_signal(signal.SIGINT)
    printed, complaints = process.communicate(timeout=60)
    assert process.returncode == 0, printed + complaints
    assert complaints == ""
    assert not [child for child in children if Path(f"/proc/{child}").exists()]
    (folder,) = (tmp_path / "sessions").iterdir()
    assert RecordedSession(folder).complete


def test_a_node_that_cannot_start_is_explained_in_its_own_words(run):
    process = run(parameters=("material.friction:=-3.0",))
    _, complaints = process.communicate(timeout=STARTS_WITHIN_S)
    assert process.returncode == 1
    assert "cloth_run: the node ended by itself, exit code 1" in complaints
    assert "friction" in complaints
    assert "Traceback" not in complaints


def test_a_scene_that_does_not_exist_is_refused_in_one_line():
    command = [sys.executable, "-m", "cloth_sim_ros.run", "--scene", "no_such_scene"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr.startswith("cloth_run: scene: 'no_such_scene'")
    assert done.stderr.count("\n") == 1


def wait_for_status(process: subprocess.Popen[str]) -> None:
    """Return at the first status line; the test's own deadline is the process being killed."""
    killer_armed = signal.signal(signal.SIGALRM, lambda *_: process.kill())
    signal.alarm(STARTS_WITHIN_S)
    try:
        for line in process.stdout:
            if STATUS.match(line):
                return
        raise AssertionError(f"no status line before the end: {process.stderr.read()}")
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, killer_armed)


def children_of(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(word) for word in text.split()]
