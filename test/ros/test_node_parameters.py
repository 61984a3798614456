"""Parameters of a running node: changed between two steps, refused in words, kept in the session; and its QoS."""

from __future__ import annotations

import pytest
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64

from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify


def setter(peer, namespace="/cloth_sim"):
    def change(**values):
        parameters = [Parameter(name.replace("__", "."), value=v).to_parameter_msg() for name, v in values.items()]
        answer = peer.call(SetParameters, f"{namespace}/set_parameters", SetParameters.Request(parameters=parameters))
        return [(result.successful, result.reason) for result in answer.results]

    return change


def test_a_change_takes_effect_between_two_steps_and_the_session_is_computed_again_bit_equal(start_node, peer):
    node = start_node()
    change = setter(peer)
    energies, clouds = peer.listen(Float64, "stats/kinetic_energy"), peer.listen(PointCloud2, "cloth/points")
    peer.wait_until(lambda: len(energies) > 5, "the cloth to swing")
    assert change(material__areal_density=2.0, material__friction=0.9) == [(True, "")] * 2
    assert "in force after step" in node.wait_for("material.friction 0.9")
    assert change(grasp_timeout=0.5, solver__substeps=4) == [(True, "")] * 2
    count = len(clouds)
    peer.wait_until(lambda: "solver.substeps 4" in node.output, "the other substep")
    peer.wait_until(lambda: len(clouds) > count + 20, "further clouds")
    session = node.wait_for("recording to").split("recording to ")[1].strip()
    assert node.stop() == 0
    recorded = RecordedSession(session)
    changes = [event for event in recorded.events() if event.kind == "parameters"]
    assert changes[0].details["material"]["areal_density"] == 2.0
    assert changes[-1].details["solver"]["substeps"] == 4
    assert {len(step.sweeps) for step in recorded.steps()} == {8, 4}
    assert verify(recorded).bit_equal


@pytest.fixture(scope="module")
def node(start_node):
    return start_node("-r", "__ns:=/judged")


@pytest.mark.parametrize(
    ("values", "parts"),
    [
        ({"material__friction": -1.0}, ("material.friction", "-1.0", "0.0", "10.0")),
        ({"material__friction": "slippery"}, ("DOUBLE", "STRING")),
        ({"solver__integrator": "euler"}, ("solver.integrator", "'euler'", "implicit_midpoint", "meyer2000")),
        ({"solver__dt": 0.01}, ("read-only", "solver.dt")),
        ({"scene": "flag"}, ("read-only", "scene")),
    ],
)
def test_a_change_that_cannot_be_is_refused_with_the_reason(node, peer, values, parts):
    ((done, reason),) = setter(peer, "/judged/cloth_sim")(**values)
    assert not done
    for part in parts:
        assert part in reason


def test_a_change_that_cannot_be_computed_is_taken_back(start_node, peer, tmp_path):
    tiny = tmp_path / "tiny.yaml"
    tiny.write_text("cloth: {grid: {width: 0.001, height: 0.001, columns: 5, rows: 5}}\n")
    node = start_node("-r", "__ns:=/tiny", scene=tiny)
    change = setter(peer, "/tiny/cloth_sim")
    change(material__areal_density=0.001, material__bend=1000.0)
    assert "too light" in node.wait_for("the parameters stay as they were")
    request = GetParameters.Request(names=["material.bend"])

    def bend():
        return peer.call(GetParameters, "/tiny/cloth_sim/get_parameters", request).values[0].double_value

    peer.wait_until(lambda: bend() < 1.0, "the old value to be shown again")


def test_the_quality_of_service_is_overruled_by_parameters_on_the_full_name_of_a_topic(start_node, peer):
    topic = "/overruled/cloth_sim/cloth/points"
    start_node(
        *("-r", "__ns:=/overruled", "-p", f"qos_overrides.{topic}.publisher.reliability:=best_effort"),
        *("-p", f"qos_overrides.{topic}.publisher.depth:=2"),
    )
    infos = peer.wait_until(lambda: peer.node.get_publishers_info_by_topic(topic), "the publisher")
    assert infos[0].qos_profile.reliability.name == "BEST_EFFORT"
