"""Publishes ``/diagnostics``."""

from __future__ import annotations

from rclpy.lifecycle import LifecycleNode
from rclpy.serialization import serialize_message

from cloth_sim_ros.interfaces import DIAGNOSTICS
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.ros import messages
from cloth_sim_ros.ros.parts import Parts
from cloth_sim_ros.ros.qos import profile
from cloth_sim_ros.simulation import diagnostics
from cloth_sim_ros.simulation.clock import ClockPace
from cloth_sim_ros.simulation.diagnostics import Status
from cloth_sim_ros.simulation.runner import Runner


class Report:
    """Gathers how the parts of a node do, and publishes it.

    Args:
        node: the node.
        parts: what it consists of.
    """

    def __init__(self, node: LifecycleNode, parts: Parts) -> None:
        self._node = node
        self._parts = parts
        self._missed_before = 0
        kind = messages.interface_class(DIAGNOSTICS.type_name)
        # Not a managed publisher: an inactive node has something to say too.
        self._publisher = node.create_publisher(kind, DIAGNOSTICS.name, profile(DIAGNOSTICS.qos))

    def publish(self, runner: Runner | None, recorder: Recorder | None, session_problem: str) -> None:
        """Publish once; ``runner`` is None while the node is not active."""
        parts, running = self._parts, runner is not None
        statuses = self._of_runner(runner) if running else []
        statuses.append(
            diagnostics.inputs(
                parts.refused,
                parts.hints,
                stale=parts.simulation.stale if running else (),
                undeclared=parts.inputs.undeclared(),
                incompatible=list(parts.incompatible.seen),
            )
        )
        statuses.append(diagnostics.session(recorder.health if recorder else None, session_problem))
        now = self._node.get_clock().now().nanoseconds
        cdr = serialize_message(messages.diagnostics(statuses, self._node.get_fully_qualified_name(), now))
        self._publisher.publish(cdr)
        if recorder is not None:
            recorder.output(self._publisher.topic_name, DIAGNOSTICS.type_name, cdr, now, qos=DIAGNOSTICS.qos)

    def destroy(self) -> None:
        """Take the topic off the graph."""
        self._node.destroy_publisher(self._publisher)

    def _of_runner(self, runner: Runner) -> list[Status]:
        rhythm, follows_clock = runner.rhythm, isinstance(runner.pace, ClockPace)
        missed_lately = max(0, rhythm.missed - self._missed_before)
        self._missed_before = rhythm.missed
        timing = diagnostics.timing(
            rhythm,
            nominal=0.0 if follows_clock else 1.0 / self._parts.simulation.solver.config.dt,
            skipped=runner.pace.skipped,
            missed_lately=missed_lately,
            paused=self._parts.simulation.paused,
            waiting=follows_clock and runner.pace.waiting_for_clock,
        )
        cloth = diagnostics.cloth(
            runner.latest,
            self._parts.representation,
            self._parts.failures,
            self._parts.simulation.solver.material.stretch_limit,
        )
        return [timing, cloth]
