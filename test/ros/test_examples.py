"""The examples of the README, run as a reader would run them."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from sensor_msgs.msg import PointCloud2

ROOT = Path(__file__).parents[2]


def lift(*arguments: str) -> str:
    """What the lifter says; it looks itself what became of the cloth."""
    command = [sys.executable, str(ROOT / "examples" / "lift_a_corner.py"), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout + done.stderr


def test_the_lifter_takes_the_lowest_point_of_a_cloth_and_lifts_it(start_node, peer):
    start_node()
    clouds = peer.listen(PointCloud2, "/cloth_sim/cloth/points")
    peer.wait_until(lambda: len(clouds) > 50, "a cloth that lies")
    assert re.search(r"caught vertex \d+ and lifted it by 0\.[123]\d m", lift())


def test_the_lifter_says_that_the_cloth_did_not_come_along(start_node, peer):
    """The hand bears less than the part of the cloth that it lifts."""
    node = start_node("-r", "__ns:=/weak", "-p", "solver.max_grasp_force:=0.1")
    clouds = peer.listen(PointCloud2, "/weak/cloth_sim/cloth/points")
    peer.wait_until(lambda: len(clouds) > 50, "a cloth that lies")
    said = lift("/weak/cloth_sim")
    assert re.search(r"caught nothing that stayed in the hand: vertex \d+ rose by -?0\.[01]", said)
    node.wait_for("grasp hand lost the cloth: it had to bear 0.")
