"""Publishing inputs on the topics that the node reads."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import rclpy
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Float64

from cloth_core import Inputs, Pose
from cloth_core.script import Script
from cloth_sim_ros import interfaces
from cloth_sim_ros.interfaces import Interface
from cloth_sim_ros.ros.qos import profile


class Hands:
    """A node of its own that publishes what a script moves.

    Args:
        script: says which grasps and obstacles there are, and whether the wind is scripted.
        namespace: full name of the cloth node.
        frame_id: frame of the poses and of the wind.
        ros_args: as on the command line, from ``--ros-args`` on.
    """

    def __init__(self, script: Script, namespace: str, frame_id: str, ros_args: Sequence[str] = ()) -> None:
        rclpy.init(args=list(ros_args), signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(f"cloth_operator_{os.getpid()}")
        self._root = "/" + namespace.strip("/") if namespace.strip("/") else ""
        self._frame_id = frame_id
        self._poses = {n: self._publisher(interfaces.GRASP_POSE, PoseStamped, n) for n in script.grasps}
        self._closures = {n: self._publisher(interfaces.GRASP_CLOSURE, Float64, n) for n in script.grasps}
        self._obstacles = {n: self._publisher(interfaces.OBSTACLE_POSE, PoseStamped, n) for n in script.obstacles}
        self._wind = self._publisher(interfaces.WIND, Vector3Stamped) if script.wind else None

    def are_watched(self) -> bool:
        """Whether somebody reads any of the topics."""
        return any(publisher.get_subscription_count() for publisher in self._all())

    def show(self, inputs: Inputs) -> None:
        """Publish these inputs, stamped with the present."""
        stamp = self._node.get_clock().now().to_msg()
        for name, publisher in self._poses.items():
            publisher.publish(self._pose(stamp, inputs.grasps[name].pose))
            self._closures[name].publish(Float64(data=inputs.grasps[name].closure))
        for name, publisher in self._obstacles.items():
            publisher.publish(self._pose(stamp, inputs.obstacles[name]))
        if self._wind is not None:
            message = Vector3Stamped()
            message.header.stamp, message.header.frame_id = stamp, self._frame_id
            message.vector.x, message.vector.y, message.vector.z = inputs.wind.velocity
            self._wind.publish(message)

    def close(self) -> None:
        """Leave the graph."""
        self._node.destroy_node()
        rclpy.try_shutdown()

    def __enter__(self) -> Hands:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def _all(self) -> list[Publisher]:
        wind = [self._wind] if self._wind is not None else []
        return [*self._poses.values(), *self._closures.values(), *self._obstacles.values(), *wind]

    def _publisher(self, interface: Interface, message: type, name: str = "") -> Publisher:
        topic = interface.named(name).replace("~", self._root)
        return self._node.create_publisher(message, topic, profile(interface.qos))

    def _pose(self, stamp: Any, pose: Pose) -> PoseStamped:
        message = PoseStamped()
        message.header.stamp, message.header.frame_id = stamp, self._frame_id
        position, orientation = message.pose.position, message.pose.orientation
        position.x, position.y, position.z = pose.position
        orientation.x, orientation.y, orientation.z, orientation.w = pose.orientation
        return message
