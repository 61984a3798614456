"""The node as a process: how it starts, is configured, is managed, keeps time, and ends."""

from __future__ import annotations

import functools
import itertools
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2

from cloth_sim_ros.recording.recorded import RecordedSession


def session_of(node):
    return node.wait_for("recording to").split("recording to ")[1].strip()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_without_a_traceback_and_with_a_readable_session(start_node, number):
    node = start_node()
    session = session_of(node)
    node.send(number)
    node.send(number)  # an impatient second one changes nothing
    assert node.wait() == 0
    assert "Traceback" not in node.output
    assert "session closed" in node.output
    recorded = RecordedSession(session)
    assert recorded.complete
    assert recorded.scene.name == "small"


def test_a_mesh_file_that_was_mended_is_told_in_one_line_for_each_fault(start_node, tmp_path):
    corners = "v 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nv 7 7 7\n"
    (tmp_path / "sheet.obj").write_text(f"{corners}f 1 2 3\nf 2 3 4\nf 3 2 1\n")
    scene = tmp_path / "sheet.yaml"
    scene.write_text("cloth: {mesh: {file: sheet.obj}}\n")
    node = start_node(scene=scene)
    warned = [line.split("]: ")[1].strip() for line in node.output.splitlines() if line.startswith("[WARN]")]
    assert warned == [
        f"{tmp_path}/sheet.obj: vertices that belong to no triangle were dropped: 4",
        f"{tmp_path}/sheet.obj: triangles that repeat an earlier one were dropped: 2",
        f"{tmp_path}/sheet.obj: triangles wound against their neighbours were turned: 1",
    ]
    assert "MeshWarning" not in node.output


def test_ctrl_c_while_it_is_still_starting_ends_it_quietly(start_node):
    node = start_node(ready=False)
    node.wait_for("compiling kernels")
    node.send(signal.SIGINT)
    assert node.wait() == 0
    assert "Traceback" not in node.output


@pytest.mark.parametrize(
    ("arguments", "scene", "parts"),
    [
        ((), "skarf", ("scene: 'skarf'", "scarf")),
        (
            (),
            "cloth: {grid: {width: -1.0, height: 1.0, columns: 3, rows: 3}}",
            ("cloth.grid.width", "-1.0", "0.001 .. 1000 m"),
        ),
        ((), "cloth: {grid: {widht: 1.0, height: 1.0, columns: 3, rows: 3}}", ("widht", "did you mean width?")),
        ((), "cloth: [}", ("not valid YAML",)),
        (("-p", "material.areal_density:=-3.0"), None, ("areal_density", "-3.0", "0.001 .. 20 kg/m^2")),
        (("-p", "solver.dt:=fast"), None, ("solver.dt", "'fast'", "0.001 .. 0.1 s")),
        (("-p", "record:=some"), None, ("record", "'some'", "none, inputs, outputs, all")),
        (("-p", "static_transforms:=['world table']"), None, ("static_transforms", "'world table'")),
    ],
)
def test_what_cannot_start_says_why_in_one_line_and_exits_with_1(
    start_node, small_scene, tmp_path, arguments, scene, parts
):
    file = scene or small_scene
    if scene and scene != "skarf":
        file = tmp_path / "bad.yaml"
        file.write_text(scene + "\n")
    node = start_node(*arguments, scene=file, ready=False)
    assert node.wait() == 1
    errors = [line for line in node.output.splitlines() if "[ERROR]" in line]
    assert len(errors) == 1
    assert "Traceback" not in node.output
    for part in parts:
        assert part in errors[0]


def test_a_session_folder_that_cannot_be_written_is_named_and_the_cloth_runs_without(start_node, peer, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    node = start_node("-p", f"session_folder:={blocked}", "-r", "__ns:=/unrecorded", ready=False)
    line = node.wait_for("going on without recording")
    assert str(blocked) in line
    assert "[ERROR]" in line
    clouds = peer.listen(PointCloud2, "/unrecorded/cloth_sim/cloth/points")
    reports = peer.listen(DiagnosticArray, "/diagnostics")

    def reported():
        statuses = [status for report in reports for status in report.status if status.hardware_id.startswith("/unrec")]
        return any(str(blocked) in status.message for status in statuses if status.name.endswith("session"))

    peer.wait_until(lambda: clouds and reported(), "clouds, and the reason in diagnostics")
    assert node.stop() == 0


def test_namespace_parameter_file_and_remap_are_followed(start_node, small_scene, peer, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    frame_id: lab\n    record: none\n"
        "    material: {areal_density: 1}\n    solver: {dt: 0.01, iterrations: 3}\n"
    )
    node = start_node(
        "--params-file", str(file), "-r", "__ns:=/lab", "-r", "~/wind:=/weather/wind", ready=False
    )  # fmt: skip
    assert "did you mean solver.iterations?" in node.wait_for("solver.iterrations")
    clouds = peer.listen(PointCloud2, "/lab/cloth_sim/cloth/points")
    peer.speak(Vector3Stamped, "/weather/wind", 1)
    peer.wait_until(lambda: len(clouds) > 10, "clouds in the namespace")
    assert clouds[-1].header.frame_id == "lab"
    request = GetParameters.Request(names=["material.areal_density", "solver.dt", "scene", "record"])
    values = peer.call(GetParameters, "/lab/cloth_sim/get_parameters", request).values
    assert [values[0].double_value, values[1].double_value] == [1.0, 0.01]
    assert [values[2].string_value, values[3].string_value] == [str(small_scene), "none"]
    describe = DescribeParameters.Request(names=["material.areal_density"])
    (described,) = peer.call(DescribeParameters, "/lab/cloth_sim/describe_parameters", describe).descriptors
    assert described.read_only
    assert "kg/m^2" in described.description
    assert described.floating_point_range[0].to_value == 20.0
    change = SetParameters.Request(parameters=[Parameter("solver.dt", value=0.02).to_parameter_msg()])
    (result,) = peer.call(SetParameters, "/lab/cloth_sim/set_parameters", change).results
    assert not result.successful
    assert node.stop() == 0
    assert "recording to" not in node.output


def test_the_shipped_parameter_file_is_one_that_ros_reads(start_node):
    node = start_node("--params-file", str(Path(__file__).parents[2] / "config" / "cloth.yaml"))
    assert node.stop() == 0
    assert "[WARN]" not in node.output


def test_it_goes_through_all_states_of_a_managed_node(start_node, peer):
    node = start_node("-p", "autostart:=false", "-r", "__ns:=/managed", ready=False)
    name = "/managed/cloth_sim"

    def change(transition):
        return peer.call(
            ChangeState, f"{name}/change_state", ChangeState.Request(transition=Transition(id=transition))
        ).success

    def state():
        return peer.call(GetState, f"{name}/get_state", GetState.Request()).current_state.label

    def publishers():
        return peer.node.count_publishers(f"{name}/cloth/points")

    clouds = peer.listen(PointCloud2, f"{name}/cloth/points")
    assert state() == "unconfigured"
    for _ in range(2):
        assert change(Transition.TRANSITION_CONFIGURE)
        assert state() == "inactive"
        assert change(Transition.TRANSITION_ACTIVATE)
        assert state() == "active"
        count = len(clouds)
        peer.wait_until(lambda count=count: len(clouds) > count + 5, "clouds of the active node")
        assert change(Transition.TRANSITION_DEACTIVATE)
        assert change(Transition.TRANSITION_ACTIVATE)  # goes on where it stood
        assert change(Transition.TRANSITION_DEACTIVATE)
        assert state() == "inactive"
        assert change(Transition.TRANSITION_CLEANUP)
        assert state() == "unconfigured"
        peer.wait_until(lambda: publishers() == 0, "the topics to leave the graph")
    assert change(Transition.TRANSITION_CONFIGURE)
    assert change(Transition.TRANSITION_ACTIVATE)
    assert change(Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert state() == "finalized"
    assert node.output.count("session closed") == 3
    assert node.stop() == 0
    assert "Traceback" not in node.output


def test_with_use_sim_time_every_20_ms_of_the_clock_are_one_step(start_node, peer):
    node = start_node("-p", "use_sim_time:=true", "-r", "__ns:=/lockstep")
    clouds = peer.listen(PointCloud2, "/lockstep/cloth_sim/cloth/points")
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    peer.wait_until(
        lambda: any("waiting for /clock" in status.message for report in reports for status in report.status),
        "a node that says that it waits",
    )
    publish = peer.speak(Clock, "/clock")

    def tell(milliseconds):
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(milliseconds * 1_000_000, 1_000_000_000)
        publish(message)

    def stamps():
        return [round((c.header.stamp.sec * 10**9 + c.header.stamp.nanosec) / 1e6) for c in clouds]

    peer.wait_until(
        lambda: not any(waiting(report) for report in reports[-1:]),
        "the clock to be heard",
        meanwhile=lambda: tell(100_000),
    )
    # The node may not know yet that somebody listens: what it sends until then reaches nobody.
    early = list(range(100_020, 110_000, 20))
    peer.wait_until(lambda: clouds, "a node that knows its listener", meanwhile=lambda: tell(early.pop(0)))
    first = early.pop(0)
    peer.wait_until(lambda: stamps()[-1] == first, "all steps until now", meanwhile=lambda: tell(first))
    clouds.clear()
    # Told again and again, for /clock is best effort; the same time twice is no step.
    for now in range(first + 20, first + 501, 20):
        told = functools.partial(tell, now)
        done = functools.partial(lambda now: stamps()[-1:] == [now], now)
        peer.wait_until(done, f"the step of {now} ms", meanwhile=told)
    peer.wait_until(
        lambda: stamps()[-1:] == [first + 560],
        "the three steps that are due at once",
        meanwhile=lambda: tell(first + 570),
    )
    assert stamps() == list(range(first + 20, first + 561, 20))
    back_in_time = itertools.count(50_000, 20)
    peer.wait_until(lambda: stamps()[-1] < 100_000, "a new episode", meanwhile=lambda: tell(next(back_in_time)))
    session = session_of(node)
    assert node.stop() == 0
    events = [event.kind for event in RecordedSession(session).events()]
    assert events == ["reset"]


def waiting(report):
    return any("waiting for /clock" in status.message for status in report.status)


def test_help_needs_no_ros_and_names_scenes_topics_and_an_example():
    # In a Python that cannot import rclpy at all.
    code = "import sys; sys.modules['rclpy'] = None; from cloth_sim_ros.node import main; main(['--help'])"
    text = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for part in ("scarf", "~/grasp/<name>/pose", "--ros-args -p scene:=", "cloth.yaml"):
        assert part in text


def test_an_argument_that_it_does_not_know_is_refused():
    command = [sys.executable, "-m", "cloth_sim_ros.node", "--scene", "flag"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "--scene" in done.stderr
