"""Closures that come as a trigger of a joystick, or as a joint of a gripper."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from cloth_core import SettingError
from cloth_sim_ros.messages.conversions import RefusedError

FORM = "'grasp topic axis|button|joint which [open closed]'"
_KINDS = ("axis", "button", "joint")


@dataclass(frozen=True)
class ClosureMapping:
    """Where the closure of a grasp is read from.

    Args:
        grasp: name of the grasp.
        topic: of sensor_msgs/Joy, or sensor_msgs/JointState for a joint.
        kind: ``axis``, ``button`` or ``joint``.
        which: number of the axis or button, from 0; name of the joint.
        open: value of an open hand.
        closed: value of a closed one; what is beyond counts as this.
    """

    grasp: str
    topic: str
    kind: str
    which: int | str
    open: float = 0.0
    closed: float = 1.0

    @classmethod
    def parse(cls, text: str) -> ClosureMapping:
        """Read ``text`` of the form :data:`FORM`.

        Raises:
            SettingError: it is not of that form.
        """
        words = text.split()
        try:
            if len(words) not in (4, 6) or words[2] not in _KINDS:
                raise ValueError
            grasp, topic, kind, which = words[:4]
            ends = [float(word) for word in words[4:]] or [0.0, 1.0]
            number = which if kind == "joint" else int(which)
            if not all(math.isfinite(end) for end in ends) or ends[0] == ends[1] or (kind != "joint" and number < 0):
                raise ValueError
        except ValueError:
            problem = (
                f"'{text}' is not of the form {FORM}, open and closed being different numbers (0 and 1 if left out)"
            )
            raise SettingError("closures", problem) from None
        return cls(grasp, topic, kind, number, *ends)

    def read(self, message: Any) -> float | None:
        """The closure in ``message``, 0 open .. 1 closed; None if it is not about this joint.

        Raises:
            RefusedError: there is no such axis or button, or its value is no finite number.
        """
        value = self._joint(message) if self.kind == "joint" else self._control(message)
        if value is None:
            return None
        if not math.isfinite(value):
            raise RefusedError(f"{self.kind} {self.which}", f"= {value:g}: allowed are finite numbers")
        return min(1.0, max(0.0, (value - self.open) / (self.closed - self.open)))

    def _control(self, message: Any) -> float:
        values = message.axes if self.kind == "axis" else message.buttons
        if self.which >= len(values):
            there = f"0 .. {len(values) - 1}" if values else "none"
            raise RefusedError(f"{self.kind} {self.which}", f"is not in the message: there are {there}")
        return float(values[self.which])

    def _joint(self, message: Any) -> float | None:
        try:
            return float(message.position[list(message.name).index(self.which)])
        except (ValueError, IndexError):  # of another part of the robot, or a driver that tells no position
            return None


def mappings(texts: Sequence[str], grasps: Collection[str]) -> tuple[ClosureMapping, ...]:
    """The mappings of the parameter ``closures``.

    Raises:
        SettingError: one is malformed, names a grasp that is not in ``grasps``, or a topic is to have two types.
    """
    found = tuple(ClosureMapping.parse(text) for text in texts)
    for mapping in found:
        if mapping.grasp not in grasps:
            known = ", ".join(grasps) or "none"
            raise SettingError("closures", f"there is no grasp {mapping.grasp}; this scene has {known}")
        if len({m.kind == "joint" for m in found if m.topic == mapping.topic}) > 1:
            raise SettingError("closures", f"{mapping.topic} cannot hold both joints and axes or buttons")
    return found
