"""Quality of service: from the table of interfaces to rclpy, and the peers that ask for another one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSPolicyKind,
    QoSProfile,
    ReliabilityPolicy,
    qos_policy_name_from_kind,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from cloth_sim_ros.session import Qos


def profile(qos: Qos) -> QoSProfile:
    """The rclpy profile of ``qos``."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
    )


def overridable() -> QoSOverridingOptions:
    """Lets parameters ``qos_overrides.<topic>.publisher.reliability`` and the like overrule a profile.

    ``<topic>`` is the full name, remapped.
    """
    kinds = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH, QoSPolicyKind.RELIABILITY, QoSPolicyKind.DURABILITY)
    return QoSOverridingOptions(kinds)


class IncompatibleQos:
    """Peers whose quality of service does not fit ours: said once each, kept for diagnostics.

    Args:
        log: writes one line.
    """

    def __init__(self, log: Callable[[str], None]) -> None:
        self.seen: dict[str, None] = {}
        self._log = log

    def of_publisher(self, topic: str) -> Callable[[Any], None]:
        """The event callback of our publisher on ``topic``."""
        return lambda event: self._note(topic, "a subscriber asks for", "gets nothing from it", event)

    def of_subscription(self, topic: str) -> Callable[[Any], None]:
        """The event callback of our subscription to ``topic``."""
        return lambda event: self._note(topic, "a publisher offers", "is not heard", event)

    def _note(self, topic: str, who: str, so: str, event: Any) -> None:
        policy = qos_policy_name_from_kind(event.last_policy_kind)
        problem = f"{topic} ({policy})"
        if problem not in self.seen:
            self.seen[problem] = None
            self._log(f"{topic}: {who} an incompatible {policy} and {so}")
