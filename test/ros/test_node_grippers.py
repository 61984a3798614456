"""A gripper whose fingers are obstacles is felt like any other hand."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import WrenchStamped
from small_scene import SMALL_SCENE

FINGERS = """  floor: {plane: {}}
  thumb: {box: {extents: [0.06, 0.06, 0.02], center: [0.17, 0.17, 0.487]}}
  finger: {box: {extents: [0.06, 0.06, 0.02], center: [0.17, 0.17, 0.513]}}
grippers:
  tongs: {left: thumb, right: finger, force: 50.0}
"""


@pytest.fixture(scope="module")
def node(start_node, tmp_path_factory):
    scene = tmp_path_factory.mktemp("scenes") / "tongs.yaml"
    scene.write_text(SMALL_SCENE.replace("  floor: {plane: {}}\n", FINGERS))
    return start_node(scene=scene)


def test_what_tongs_feel_is_published(node, peer):
    felt = peer.listen(WrenchStamped, "grasp/tongs/wrench")
    peer.wait_until(lambda: felt and felt[-1].wrench.force.z != 0.0, "a force on the tongs")
    assert felt[-1].header.frame_id == "tongs"
    assert "a step failed" not in node.output
