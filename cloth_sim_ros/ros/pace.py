"""Which clock the steps follow: the machine's, or ``/clock`` under use_sim_time."""

from __future__ import annotations

from contextlib import ExitStack

from rclpy.clock import JumpThreshold
from rclpy.duration import Duration
from rclpy.node import Node

from cloth_sim_ros.simulation.clock import ClockPace, Pace, WallPace


def pace_of(node: Node, dt: float, undo: ExitStack) -> Pace:
    """The pace of steps of ``dt`` s; ``undo`` gets what ends it."""
    dt_ns = round(dt * 1e9)

    def now() -> int:
        return node.get_clock().now().nanoseconds

    if not node.get_parameter("use_sim_time").value:
        return WallPace(dt_ns, now)
    pace = ClockPace(dt_ns)
    pace.advance(now())
    any_change = JumpThreshold(
        min_forward=Duration(nanoseconds=1), min_backward=Duration(nanoseconds=-1), on_clock_change=False
    )
    # The clock's subscription comes first in a round of the executor, guard conditions last: so inputs that were sent
    # before a tick are heard before its step.
    heard = node.create_guard_condition(lambda: pace.advance(now()))
    undo.callback(node.destroy_guard_condition, heard)
    handle = node.get_clock().create_jump_callback(any_change, post_callback=lambda _jump: heard.trigger())
    undo.callback(handle.unregister)
    return pace
