"""ROS messages in, numbers of the core out; damaged fields are refused by name, value, range and unit.

Works on anything that has a message's attributes; knows no rclpy.
"""

from __future__ import annotations

import math
from typing import Any

from cloth_core import InputError, Pose
from cloth_core.inputs import REST_SCALE
from cloth_sim_ros.vision.camera import Lens

NANOSECONDS = 1_000_000_000
POSITION_LIMIT = 1e6
MOST_PIXELS = 100_000


class RefusedError(InputError):
    """A message whose value cannot be used.

    Args:
        field: the field that is wrong, such as ``pose.position``.
        problem: its value, and what would be allowed.
    """

    def __init__(self, field: str, problem: str) -> None:
        self.field = field
        super().__init__(f"{field} {problem}")


def read_pose(message: Any) -> Pose:
    """The pose of a geometry_msgs/PoseStamped, in its own frame.

    Raises:
        RefusedError: a component is not finite or too large, or the quaternion is (nearly) zero.
    """
    p, q = message.pose.position, message.pose.orientation
    position, orientation = (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
    if not all(math.isfinite(c) and abs(c) < POSITION_LIMIT for c in position):
        allowed = f"allowed are finite numbers within +-{POSITION_LIMIT:g} m"
        raise RefusedError("pose.position", f"= {_numbers(position)} m: {allowed}")
    try:
        return Pose(position, orientation)
    except InputError:
        problem = f"= {_numbers(orientation)} (x, y, z, w): allowed is a finite quaternion, not zero"
        raise RefusedError("pose.orientation", problem) from None


def read_wind(message: Any) -> tuple[float, float, float]:
    """The vector of a geometry_msgs/Vector3Stamped, m/s, in its own frame.

    Raises:
        RefusedError: a component is not finite.
    """
    vector = (float(message.vector.x), float(message.vector.y), float(message.vector.z))
    if not all(math.isfinite(c) for c in vector):
        raise RefusedError("vector", f"= {_numbers(vector)} m/s: allowed are finite numbers")
    return vector


def read_closure(message: Any) -> float:
    """The closure of a std_msgs/Float64: 0 open .. 1 closed.

    Raises:
        RefusedError: it is not within 0 .. 1.
    """
    closure = float(message.data)
    if not 0.0 <= closure <= 1.0:
        raise RefusedError("data", f"= {closure:g} (closure): allowed is 0 (open) .. 1 (closed), without unit")
    return closure


def read_rest_scale(message: Any) -> float:
    """The scale of a std_msgs/Float64: rest lengths over those that the cloth was made with.

    Raises:
        RefusedError: it is out of range.
    """
    scale = float(message.data)
    if not REST_SCALE.low <= scale <= REST_SCALE.high:
        raise RefusedError("data", f"= {scale:g} (rest scale): allowed is {REST_SCALE.allowed} ({REST_SCALE.help})")
    return scale


def read_lens(message: Any) -> Lens:
    """The pinhole of a sensor_msgs/CameraInfo.

    Raises:
        RefusedError: the size or the focal length is not positive, as of a camera that was not calibrated.
    """
    fx, _, cx, _, fy, cy, *_ = (float(number) for number in message.k)
    if not 0 < message.width <= MOST_PIXELS or not 0 < message.height <= MOST_PIXELS:
        allowed = f"allowed are 1 .. {MOST_PIXELS} pixels each way"
        raise RefusedError("width, height", f"= {message.width}, {message.height}: {allowed}")
    if not all(math.isfinite(number) for number in (fx, fy, cx, cy)) or fx <= 0.0 or fy <= 0.0:
        allowed = "allowed are finite numbers, focal lengths above 0 pixels"
        raise RefusedError("k", f"says fx, fy, cx, cy = {_numbers((fx, fy, cx, cy))}: {allowed}")
    return Lens(int(message.width), int(message.height), fx, fy, cx, cy)


def stamp_ns(message: Any) -> int:
    """The header's stamp in ns; 0 means that the publisher set none."""
    return int(message.header.stamp.sec) * NANOSECONDS + int(message.header.stamp.nanosec)


def _numbers(values: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ")"
