"""The process around the node: start, spin, and an end without tracebacks."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Sequence

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.logging import get_logger
from rclpy.signals import SignalHandlerOptions

from cloth_core import SettingError
from cloth_sim_ros.command_line import complain, on_end_signals
from cloth_sim_ros.ros.cloth_node import ClothNode

_SPIN_SECONDS = 0.1
"""How long a signal may go unnoticed: Python runs its handlers only between two waits."""

_SWITCH_SECONDS = 1e-4
"""How long another thread may keep the interpreter from the simulation. Each kernel lets go of it, some 600
times a step; at Python's own 5 ms a recorder at work delays a tenth of the steps past their slot."""


class StopRequest:
    """Ctrl-C, SIGTERM or a closed terminal: interrupts the start, merely asks a node that runs, and is then ignored."""

    def __init__(self) -> None:
        self.asked = False
        self.interrupts = True
        on_end_signals(self._ask)

    def _ask(self) -> None:
        self.asked = True
        if self.interrupts:
            self.interrupts = False
            raise KeyboardInterrupt


def run(ros_arguments: Sequence[str]) -> int:
    """Run the node until a signal ends it; returns the exit code."""
    sys.setswitchinterval(_SWITCH_SECONDS)
    stop = StopRequest()
    node: ClothNode | None = None
    try:
        rclpy.init(args=list(ros_arguments), signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # which one depends on what is wrong with the arguments
        complain("cloth_node", " ".join(str(error).split()))
        return 2
    try:
        node = ClothNode(asked_to_end=lambda: stop.asked)
        if node.settings.autostart and not _bring_up(node):
            return 0 if stop.asked else 1
        stop.interrupts = False
        _spin(node, stop)
        return 0
    except SettingError as error:
        get_logger("cloth_sim").error(f"cannot start: {error}")
        return 1
    except KeyboardInterrupt:
        return 0
    finally:
        stop.interrupts = False
        if node is not None:
            node.close()
            node.destroy_node()
        rclpy.try_shutdown()


def _bring_up(node: ClothNode) -> bool:
    """Configure and activate, as a lifecycle manager would; whether it worked."""
    done = TransitionCallbackReturn.SUCCESS
    return node.trigger_configure() == done and node.trigger_activate() == done


def _spin(node: ClothNode, stop: StopRequest) -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    while not stop.asked and rclpy.ok():
        try:
            executor.spin_once(timeout_sec=_SPIN_SECONDS)
        except Exception:  # one bad callback must not take the cloth away from everybody else
            node.get_logger().error(f"a callback failed:\n{traceback.format_exc()}")
    executor.shutdown()
