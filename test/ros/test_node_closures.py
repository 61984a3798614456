"""Closures that come from a joystick and from a gripper's joint."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float64

NAMESPACE = "/mapped/cloth_sim"


@pytest.fixture(scope="module")
def node(start_node):
    closures = "['hand ~/joy axis 2 1.0 -1.0', 'hand /arm/joint_states joint finger 0.04 0.0']"
    return start_node("-r", "__ns:=/mapped", "-p", f"closures:={closures}")


def test_a_trigger_and_then_a_joint_close_and_open_the_hand(node, peer):
    held = peer.listen(Float64, f"{NAMESPACE}/stats/held")
    move = peer.speak(PoseStamped, f"{NAMESPACE}/grasp/hand/pose", 1)
    pull, grip = peer.speak(Joy, f"{NAMESPACE}/joy"), peer.speak(JointState, "/arm/joint_states")
    corner = PoseStamped()
    corner.pose.position.x, corner.pose.position.y, corner.pose.position.z = -0.2, -0.2, 0.5  # pinned
    corner.pose.orientation.w = 1.0

    def joy(trigger):
        move(corner)
        pull(Joy(axes=[0.0, 0.0, trigger]))

    def joint(opening):
        move(corner)
        grip(JointState(name=["wrist", "finger"], position=[0.0, opening]))

    peer.wait_until(lambda: held and held[-1].data > 1.0, "the trigger to take it", meanwhile=lambda: joy(-1.0))
    peer.wait_until(lambda: held[-1].data == 1.0, "the trigger to let go", meanwhile=lambda: joy(1.0))
    peer.wait_until(lambda: held[-1].data > 1.0, "the joint to take it", meanwhile=lambda: joint(0.0))
    peer.wait_until(lambda: held[-1].data == 1.0, "the joint to let go", meanwhile=lambda: joint(0.04))


def test_a_mapping_to_a_grasp_that_there_is_not_is_refused_in_one_line(start_node):
    node = start_node("-p", "closures:=['left ~/joy axis 2']", ready=False)
    assert node.wait() == 1
    assert "closures: there is no grasp left; this scene has hand" in node.output
