"""From a hand's pose to the first cloud that answers to it."""

from __future__ import annotations

import random
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PoseStamped
from marks.row import Row
from std_msgs.msg import Float64

from soaking.node import NAME, Node, positions, running
from soaking.scenes import hanging

SIDE = 50
CORNER = SIDE * SIDE - 1
STEP_M = 0.01


def rows(folder: Path, seconds: float) -> Iterator[Row]:
    """Poses at random times, each a centimetre from the last; the corner that is held tells when it answered."""
    with running(hanging(folder, SIDE), folder) as node:
        node.keep_clouds = True
        move = node.peer.node.create_publisher(PoseStamped, f"{NAME}/grasp/hand/pose", 1)
        close = node.peer.node.create_publisher(Float64, f"{NAME}/grasp/hand/closure", 10)
        home = _take(node, move, close)
        delays = [_answer(node, move, home, STEP_M * (number % 2)) for number in range(max(50, int(seconds * 4)))]
    found = np.array([delay for delay in delays if delay is not None])
    note = f"{len(found)} of {len(delays)} answered, p50 {np.median(found):.1f} ms"
    yield Row("input to effect, 2,500 vertices, p95", "ms", 25.0, 21.0, float(np.percentile(found, 95)), note=note)


def _take(node: Node, move: object, close: object) -> np.ndarray:
    """Close the hand at a free corner; returns where."""
    node.wait(lambda: node.clouds[-1][3])
    at = positions(node.clouds[-1][3], SIDE * SIDE)[CORNER].astype(float)

    def grip() -> None:
        move.publish(_pose(at))
        close.publish(Float64(data=1.0))
        node.spin(0.02)

    if not node.wait(lambda: "hand" in node.peer.values.get("held_by", ""), meanwhile=grip):
        raise RuntimeError("the hand could not take the corner")
    return at


def _answer(node: Node, move: object, home: np.ndarray, offset: float) -> float | None:
    """ms until a cloud shows the corner moving to where the hand has gone."""
    for _ in range(20):  # keeps the hand from going stale; the corner comes to rest
        node.spin(0.01)
    node.spin(random.uniform(0.0, 0.02))
    before = positions(node.clouds[-1][3], SIDE * SIDE)[CORNER, 2]
    node.clouds.clear()
    sent = time.time_ns()
    move.publish(_pose(np.add(home, (0.0, 0.0, offset))))
    node.wait(lambda: any(_moved(cloud, before) for cloud in node.clouds), 0.5)
    answers = [published for _, published, _, cdr in node.clouds if _moved((0, 0, 0, cdr), before)]
    return (answers[0] - sent) * 1e-6 if answers else None


def _moved(cloud: tuple[int, int, int, bytes], before: float) -> bool:
    return abs(positions(cloud[3], SIDE * SIDE)[CORNER, 2] - before) > 0.2 * STEP_M


def _pose(at: np.ndarray) -> PoseStamped:
    message = PoseStamped()
    message.pose.position.x, message.pose.position.y, message.pose.position.z = (float(c) for c in at)
    message.pose.orientation.w = 1.0
    return message
