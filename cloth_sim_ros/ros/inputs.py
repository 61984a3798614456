"""Subscribes to the inputs that the scene declares, records them as they come, and passes them on."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from cloth_core.scene import Scene
from cloth_sim_ros import interfaces
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.ros.messages import interface_class
from cloth_sim_ros.ros.qos import IncompatibleQos, overridable, profile
from cloth_sim_ros.simulation.closures import ClosureMapping
from cloth_sim_ros.simulation.intake import Intake, Source, sources


class Subscriptions:
    """One raw subscription per declared input.

    Args:
        node: the node.
        scene: declares the names of grasps and obstacles.
        closures: which topics closures come from, beside those of the grasps.
        intake: gets the messages.
        incompatible: is told of publishers that cannot be heard.
    """

    def __init__(
        self,
        node: Node,
        scene: Scene,
        closures: Sequence[ClosureMapping],
        intake: Intake,
        incompatible: IncompatibleQos,
    ) -> None:
        self.recorder: Recorder | None = None
        self.active = False
        """Messages are used only while this is set."""
        self._node = node
        self._intake = intake
        self._undeclared: dict[str, None] = {}
        self._subscriptions: dict[str, Subscription] = {}
        for relative, source in sources(scene, closures, node.resolve_topic_name):
            self._subscriptions[source.topic] = node.create_subscription(
                interface_class(source.interface.type_name),
                relative,
                self._receiver(source),
                profile(source.interface.qos),
                event_callbacks=SubscriptionEventCallbacks(incompatible_qos=incompatible.of_subscription(source.topic)),
                qos_overriding_options=overridable(),
                raw=True,
            )
        self._names = {
            "grasps": [*scene.inputs.grasps],
            "obstacles": [*scene.obstacles],
            "groups": [*scene.mesh.groups],
        }
        self._forms = {kind: self._form(kind) for kind in self._names}

    def _form(self, kind: str) -> re.Pattern[str]:
        """What the topics of all inputs look like that something of this ``kind`` could have."""
        mark = "NAME"
        inputs = [i for i in interfaces.INPUTS if i.declared == kind]
        topics = [re.escape(self._node.resolve_topic_name(i.named(mark))) for i in inputs]
        return re.compile("|".join(topic.replace(mark, "[^/]+") for topic in topics))

    def undeclared(self) -> list[str]:
        """Topics published for a grasp or obstacle that the scene does not have; warns once of each."""
        for topic, _types in self._node.get_topic_names_and_types():
            if topic in self._subscriptions or topic in self._undeclared:
                continue
            kind = next((kind for kind, form in self._forms.items() if form.fullmatch(topic)), None)
            if kind is not None and self._node.count_publishers(topic):
                self._undeclared[topic] = None
                known = ", ".join(self._names[kind]) or "none"
                self._node.get_logger().warning(f"{topic}: nobody listens; the scene declares these {kind}: {known}")
        return [topic for topic in self._undeclared if self._node.count_publishers(topic)]

    def destroy(self) -> None:
        """Take the subscriptions off the graph."""
        for subscription in self._subscriptions.values():
            self._node.destroy_subscription(subscription)
        self._subscriptions.clear()

    def _receiver(self, source: Source) -> Callable[[bytes], None]:
        kind = interface_class(source.interface.type_name)

        def receive(cdr: bytes) -> None:
            if not self.active:
                return
            if self.recorder is not None:
                receipt = self._node.get_clock().now().nanoseconds
                self.recorder.raw_input(
                    source.topic, source.interface.type_name, cdr, receipt, qos=source.interface.qos
                )
            try:
                message = deserialize_message(cdr, kind)
            except Exception as error:  # what rmw raises for damaged bytes differs between implementations
                self._intake.refuse(
                    source.topic, "bytes", f"{len(cdr)} bytes are not a {source.interface.type_name}: {error}"
                )
                return
            self._intake.receive(source, message, time.monotonic())

        return receive
