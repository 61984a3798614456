"""Reading what the node says of itself."""

from __future__ import annotations

import os
from collections.abc import Sequence

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from cloth_sim_ros import interfaces
from cloth_sim_ros.ros.qos import profile


class DiagnosticsListener:
    """Keeps the newest values of the node's /diagnostics.

    ``node`` and ``executor`` are there for further subscriptions.

    Args:
        of: full name of the node that is listened to.
        ros_args: as on the command line, from ``--ros-args`` on.
    """

    def __init__(self, of: str = "/cloth_sim", ros_args: Sequence[str] = ()) -> None:
        self.values: dict[str, str] = {}
        """Values by key, of all the node's statuses."""
        self.updates = 0
        self._of = of
        rclpy.init(args=list(ros_args), signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node(f"cloth_run_{os.getpid()}")
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        diagnostics = interfaces.DIAGNOSTICS
        self.node.create_subscription(DiagnosticArray, diagnostics.name, self._receive, profile(diagnostics.qos))

    def wait(self, seconds: float) -> bool:
        """Wait for an update for some seconds; returns whether one came."""
        before = self.updates
        self.executor.spin_once(timeout_sec=seconds)
        return self.updates != before

    def close(self) -> None:
        """Leave the graph."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()

    def __enter__(self) -> DiagnosticsListener:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def _receive(self, message: DiagnosticArray) -> None:
        ours = [status for status in message.status if status.hardware_id == self._of]
        self.values.update({value.key: value.value for status in ours for value in status.values})
        self.updates += bool(ours)
