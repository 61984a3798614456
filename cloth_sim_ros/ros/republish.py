"""Publishing the messages of a session again, as they were recorded."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from cloth_sim_ros.command_line import StopFlag
from cloth_sim_ros.recording.recorded import ForeignBag, RecordedSession
from cloth_sim_ros.ros.messages import interface_class
from cloth_sim_ros.ros.qos import profile
from cloth_sim_ros.session import Channel, Qos, Record, SessionError
from cloth_sim_ros.session.yaml_text import load

_ACKNOWLEDGED_WITHIN = Duration(seconds=2)
_LOOK_PERIOD_S = 0.05


class Republisher:
    """A node of its own with one publisher for every recorded topic.

    Args:
        session: what was recorded.
        namespace: takes the place of the recorded node's name in front of its topics; None leaves it.
        ros_args: as on the command line, from ``--ros-args`` on.

    Raises:
        SessionError: a recorded message type is not installed here.
    """

    def __init__(
        self, session: RecordedSession | ForeignBag, namespace: str | None, ros_args: Sequence[str] = ()
    ) -> None:
        self._session = session
        self._bookkeeping = session.bookkeeping
        self._from = session.namespace.rstrip("/") + "/"
        self._to = (
            self._from if namespace is None else "/" + namespace.strip("/") + "/" if namespace.strip("/") else "/"
        )
        rclpy.init(args=list(ros_args), signal_handler_options=SignalHandlerOptions.NO)
        self._node = rclpy.create_node(f"cloth_replay_{time.monotonic_ns() % 10**9}")
        self._publishers: dict[str, Publisher] = {}
        self.published = 0
        try:
            self._advertise()
        except BaseException:
            self.close()
            raise

    @property
    def topics(self) -> list[str]:
        """What is published, by its name on the graph."""
        return [publisher.topic_name for publisher in self._publishers.values()]

    def wait_for_subscriber(self, stop: StopFlag) -> None:
        """Return when somebody listens, or ``stop`` is set."""
        while not any(p.get_subscription_count() for p in self._publishers.values()):
            if stop.wait(_LOOK_PERIOD_S):
                return

    def play(
        self,
        stop: StopFlag,
        *,
        rate: float = 1.0,
        window_ns: tuple[int, int] | None = None,
        on_progress: Callable[[float], None] | None = None,
    ) -> None:
        """Publish everything once, ``rate`` times as fast as it was recorded, or until ``stop`` is set.

        Args:
            stop: ends it.
            rate: speed.
            window_ns: log times between which messages are published; before the first of them, what was latched then.
            on_progress: gets the s of the recording that are done, of everything from the first message on.
        """
        first, last = window_ns or self._session.reader.times_ns
        begin = time.monotonic()
        latched: dict[str, Record] = {}
        for record in self._session.reader.messages(self._publishers):
            if record.log_time_ns < first:
                if self._is_latched(record.topic):
                    latched[record.topic] = record
                continue
            if record.log_time_ns > last:
                break
            for earlier in latched.values():
                self._publish(earlier)
            latched.clear()
            due = begin + (record.log_time_ns - first) * 1e-9 / rate
            if stop.wait(max(0.0, due - time.monotonic())):
                return
            self._publish(record)
            if on_progress is not None:
                on_progress((record.log_time_ns - first) * 1e-9)

    def _publish(self, record: Record) -> None:
        self._publishers[record.topic].publish(record.cdr)
        self.published += 1

    def _is_latched(self, topic: str) -> bool:
        return self._publishers[topic].qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL

    def close(self) -> None:
        """Wait until reliable subscribers have everything, then leave the graph."""
        for publisher in self._publishers.values():
            if publisher.qos_profile.reliability == ReliabilityPolicy.RELIABLE:
                publisher.wait_for_all_acked(_ACKNOWLEDGED_WITHIN)
        self._node.destroy_node()
        rclpy.try_shutdown()

    def __enter__(self) -> Republisher:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def _advertise(self) -> None:
        # All of the file is read once before, so that every topic is discovered before its first message.
        for channel in dict.fromkeys(entry.channel for entry in self._session.reader.entries()):
            if channel.topic not in self._bookkeeping:
                message = _message_class(channel.type.name)
                qos = _qos(channel)
                self._publishers[channel.topic] = self._node.create_publisher(
                    message, self._renamed(channel.topic), qos
                )

    def _renamed(self, topic: str) -> str:
        return self._to + topic[len(self._from) :] if topic.startswith(self._from) else topic


def _message_class(type_name: str) -> Any:
    try:
        return interface_class(type_name)
    except (ImportError, AttributeError, ValueError) as error:
        problem = f"the session has messages of type {type_name}, which is not installed: {error}"
        raise SessionError(problem) from error


def _qos(channel: Channel) -> QoSProfile:
    """The first recorded profile; what it does not say is reliable, volatile, and ten deep."""
    offered = (load(channel.qos_profiles) or [{}])[0]
    known = {"reliability": ("reliable", "best_effort"), "durability": ("volatile", "transient_local")}
    words = {policy: offered[policy] for policy, choices in known.items() if offered.get(policy) in choices}
    return profile(Qos(**words, depth=max(1, int(offered.get("depth", 10)))))
