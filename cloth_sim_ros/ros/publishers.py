"""The node's publishers: made from the table of interfaces, one for each declared name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.lifecycle import LifecycleNode, LifecyclePublisher

from cloth_sim_ros.interfaces import Interface
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.ros.messages import interface_class
from cloth_sim_ros.ros.qos import IncompatibleQos, overridable, profile


class Publishers:
    """Sends bytes to a topic, and into the session.

    Args:
        node: the managed node; it publishes while it is active.
        those: what to publish.
        declared: names by what declares them, such as ``grasps``.
        incompatible: is told of subscribers that cannot be served.
    """

    def __init__(
        self,
        node: LifecycleNode,
        those: Iterable[Interface],
        declared: Mapping[str, Iterable[str]],
        incompatible: IncompatibleQos,
    ) -> None:
        self.recorder: Recorder | None = None
        self._node = node
        self._incompatible = incompatible
        self._made = {(i, name): self._make(i, name) for i in those for name in declared.get(i.declared, [""])}

    def heard(self, interface: Interface, name: str = "") -> bool:
        """Whether somebody listens."""
        return self._made[interface, name].get_subscription_count() > 0

    def wanted(self, interface: Interface, name: str = "") -> bool:
        """Whether somebody listens, or the session shall have it."""
        return (self.recorder is not None and self.recorder.wants(interface.type_name)) or self.heard(interface, name)

    def send(self, interface: Interface, cdr: bytes, stamp_ns: int, name: str = "") -> None:
        """Publish a serialised message, and record it."""
        publisher = self._made[interface, name]
        publisher.publish(cdr)
        if self.recorder is not None:
            self.recorder.output(publisher.topic_name, interface.type_name, cdr, stamp_ns, qos=interface.qos)

    def destroy(self) -> None:
        """Take the topics off the graph."""
        for publisher in self._made.values():
            self._node.destroy_lifecycle_publisher(publisher)
        self._made.clear()

    def _make(self, interface: Interface, name: str) -> LifecyclePublisher:
        relative = interface.named(name)
        topic = self._node.resolve_topic_name(relative)
        return self._node.create_lifecycle_publisher(
            interface_class(interface.type_name),
            relative,
            profile(interface.qos),
            event_callbacks=PublisherEventCallbacks(incompatible_qos=self._incompatible.of_publisher(topic)),
            qos_overriding_options=overridable(),
        )
