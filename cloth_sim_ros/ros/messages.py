"""The small messages, built from plain values."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Quaternion, Vector3, WrenchStamped
from rclpy.time import Time
from sensor_msgs.msg import JoyFeedback, JoyFeedbackArray
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from cloth_core import Pose
from cloth_core.fields.outline import Outline
from cloth_core.obstacles import Obstacle
from cloth_core.report import Wrench
from cloth_sim_ros.messages.obstacle_shapes import Shape, shapes_of
from cloth_sim_ros.simulation.diagnostics import Status

OBSTACLE_COLOUR = (0.62, 0.66, 0.72, 1.0)


def interface_class(type_name: str) -> Any:
    """The Python class of an interface such as ``std_msgs/msg/Float64``."""
    package, kind, name = type_name.split("/")
    return getattr(import_module(f"{package}.{kind}"), name)


def diagnostics(statuses: Sequence[Status], hardware: str, stamp_ns: int) -> DiagnosticArray:
    """A DiagnosticArray of ``statuses`` of the node ``hardware``."""
    array = DiagnosticArray()
    array.header.stamp = Time(nanoseconds=stamp_ns).to_msg()
    array.status = [
        DiagnosticStatus(
            level=bytes([status.level]),
            name=f"{hardware.lstrip('/')}: {status.name}",
            message=status.message,
            hardware_id=hardware,
            values=[KeyValue(key=key, value=value) for key, value in status.values.items()],
        )
        for status in statuses
    ]
    return array


def wrench_of(name: str, wrench: Wrench, stamp_ns: int) -> WrenchStamped:
    """The wrench on a hand, in the frame of that name."""
    message = WrenchStamped()
    message.header.frame_id, message.header.stamp = name, Time(nanoseconds=stamp_ns).to_msg()
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z = wrench.force
    torque.x, torque.y, torque.z = wrench.torque
    return message


def rumble_of(intensity: float) -> JoyFeedbackArray:
    """One motor that hums with ``intensity``."""
    return JoyFeedbackArray(array=[JoyFeedback(type=JoyFeedback.TYPE_RUMBLE, id=0, intensity=intensity)])


def obstacle_markers(
    obstacles: Mapping[str, Obstacle], poses: Mapping[str, Pose], frame_id: str, stamp_ns: int
) -> MarkerArray:
    """One marker per box, ball, cylinder and mesh; the namespace is the obstacle's name."""
    array = MarkerArray()
    for name, obstacle in obstacles.items():
        for number, shape in enumerate(shapes_of(obstacle, poses[name])):
            marker = _marker(shape)
            marker.header.frame_id = frame_id
            marker.header.stamp = Time(nanoseconds=stamp_ns).to_msg()
            marker.ns, marker.id = name, number
            array.markers.append(marker)
    return array


def _marker(shape: Shape) -> Marker:
    marker = Marker(type=shape.kind, action=Marker.ADD)
    x, y, z = shape.pose.position
    marker.pose.position = Point(x=x, y=y, z=z)
    x, y, z, w = shape.pose.orientation
    marker.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
    x, y, z = (float(extent) for extent in shape.scale)
    marker.scale = Vector3(x=x, y=y, z=z)
    r, g, b, a = OBSTACLE_COLOUR
    marker.color = ColorRGBA(r=r, g=g, b=b, a=a)
    if shape.outline is not None:
        marker.points = _corners(shape.outline)
    return marker


@functools.lru_cache(maxsize=64)
def _corners(outline: Outline) -> list[Point]:
    """Made once: it takes longer than all else that is sent."""
    return [Point(x=x, y=y, z=z) for x, y, z in outline.corners.tolist()]
