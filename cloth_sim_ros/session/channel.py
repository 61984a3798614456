"""A topic as a session file knows it: its name, type and offered quality of service."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cloth_sim_ros.session.schemas import MessageType
from cloth_sim_ros.session.yaml_text import dump, load

# What rmw writes for a duration without end.
_INFINITE = {"sec": 9223372036, "nsec": 854775807}


@dataclass(frozen=True)
class Qos:
    """The quality of service a topic's publisher offers, in the words of rosbag2's metadata."""

    reliability: str = "reliable"
    durability: str = "volatile"
    depth: int = 5
    history: str = "keep_last"

    def to_yaml(self) -> str:
        """The list of one profile that a channel carries as ``offered_qos_profiles``."""
        profile = {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": _INFINITE,
            "lifespan": _INFINITE,
            "liveliness": "automatic",
            "liveliness_lease_duration": _INFINITE,
            "avoid_ros_namespace_conventions": False,
        }
        return dump([profile])


@dataclass(frozen=True)
class Channel:
    """One topic in one file. ``qos_profiles`` is the YAML text of rosbag2's ``offered_qos_profiles``."""

    topic: str
    type: MessageType
    qos_profiles: str

    @property
    def metadata(self) -> dict[str, str]:
        """What the MCAP channel carries, under the keys rosbag2 uses."""
        return {"offered_qos_profiles": self.qos_profiles, "topic_type_hash": self.type.type_hash}

    def to_mapping(self) -> dict[str, Any]:
        """The channel's ``topic_metadata`` in metadata.yaml, version 9."""
        return {
            "name": self.topic,
            "type": self.type.name,
            "serialization_format": "cdr",
            "offered_qos_profiles": load(self.qos_profiles) or [],
            "type_description_hash": self.type.type_hash,
        }
