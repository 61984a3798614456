"""What comes in over topics: checked, brought into the cloth's frame, and handed to the simulation.

A message that cannot be used changes nothing: the last good value stays, and one line says why. An empty ``frame_id``
is no fault: it means the cloth's frame, as the short way to publish by hand.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from cloth_core import InputError, Pose
from cloth_core.physics.drag import capped
from cloth_core.scene import Scene
from cloth_sim_ros import interfaces
from cloth_sim_ros.interfaces import Interface
from cloth_sim_ros.messages import conversions
from cloth_sim_ros.messages.conversions import NANOSECONDS, RefusedError
from cloth_sim_ros.simulation.closures import ClosureMapping
from cloth_sim_ros.simulation.frames import FrameTree
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation
from cloth_sim_ros.vision.camera import Viewpoint

NEW_EPOCH_AFTER = 1.0
"""s without an accepted message after which an older stamp is taken as a clock that was set back (a bag
that starts again, a headset that restarts) and no longer as a late message."""
_IN_TOPIC = re.compile("[A-Za-z][A-Za-z0-9_]*")  # what may stand between two slashes


@dataclass(frozen=True)
class Source:
    """One input topic: its full name, what it is, the grasp or obstacle that it belongs to, closures read from it."""

    topic: str
    interface: Interface
    name: str = ""
    closures: tuple[ClosureMapping, ...] = ()


def sources(
    scene: Scene, closures: Sequence[ClosureMapping], full_name: Callable[[str], str]
) -> list[tuple[str, Source]]:
    """What a scene and mappings of closures listen to: names relative to the node, each with its source.

    Args:
        scene: declares the names of grasps and obstacles.
        closures: name further topics.
        full_name: resolves and remaps a topic.
    """
    groups = [name for name in scene.mesh.groups if _IN_TOPIC.fullmatch(name)]
    declared = {"": [""], "grasps": scene.inputs.grasps, "obstacles": scene.obstacles}
    declared |= {"fluids": scene.inputs.fluids, "groups": groups}
    named = [(i, i.named(name), name) for i in interfaces.INPUTS for name in declared.get(i.declared, [])]
    found = [(topic, Source(full_name(topic), interface, name)) for interface, topic, name in named]
    for topic in dict.fromkeys(mapping.topic for mapping in closures):
        those = tuple(mapping for mapping in closures if mapping.topic == topic)
        interface = interfaces.JOINTS if those[0].kind == "joint" else interfaces.JOY
        found.append((topic, Source(full_name(topic), interface, closures=those)))
    return found


class Intake:
    """Takes messages of the input topics.

    Args:
        simulation: gets what was accepted.
        frames: knows where the frames of the messages are.
        notices: says and counts what was refused.
    """

    def __init__(self, simulation: Simulation, frames: FrameTree, notices: Notices) -> None:
        self.pointer_speed = 4.0
        """m/s of the wind that a pointer directs."""
        self.viewpoint = Viewpoint()
        """The camera."""
        self._simulation = simulation
        self._frames = frames
        self._notices = notices
        self._accepted: dict[str, tuple[int, float]] = {}  # stamp in ns and receipt in s, by topic

    def forget_stamps(self) -> None:
        """Accept any stamp again: time begins anew."""
        self._accepted.clear()

    def receive(self, source: Source, message: Any, now: float) -> bool:
        """Use ``message``, received at ``now`` (monotonic s); returns whether it was accepted."""
        try:
            if source.interface is interfaces.GRASP_CLOSURE:
                self._simulation.set_closure(source.name, conversions.read_closure(message))
                return True
            if source.interface is interfaces.GROUP_PIN:
                self._simulation.pin(source.name, bool(message.data))
                return True
            if source.interface is interfaces.GROUP_REST_SCALE:
                self._simulation.set_rest_scale(source.name, conversions.read_rest_scale(message))
                return True
            if source.closures:
                self._read_closures(source, message)
                return True
            if source.interface is interfaces.CAMERA_INFO:
                self._read_camera(message)
                return True
            stamp = self._checked_stamp(source, message, now)
            frame = self._frames.to_cloth(message.header.frame_id)
            self._apply(source, message, frame, now)
        except InputError as error:
            field = error.field if isinstance(error, RefusedError) else "value"
            self.refuse(source.topic, field, str(error))
            return False
        if stamp:
            self._accepted[source.topic] = (stamp, now)
        return True

    def refuse(self, topic: str, field: str, problem: str) -> None:
        """Count and say that a message was not used."""
        self._notices.say(f"{topic} {field}", f"{topic}: {problem}; ignored, the last good value stays")

    def _read_closures(self, source: Source, message: Any) -> None:
        for mapping in source.closures:
            closure = mapping.read(message)
            if closure is not None:
                self._simulation.set_closure(mapping.grasp, closure)

    def _read_camera(self, message: Any) -> None:
        self.viewpoint.lens = conversions.read_lens(message)
        if not self.viewpoint.follows_topic:
            self.viewpoint.pose = self._frames.to_cloth(message.header.frame_id)

    def _apply(self, source: Source, message: Any, frame: Pose, now: float) -> None:
        if source.interface is interfaces.WIND:
            velocity = frame.rotation @ conversions.read_wind(message)
            self._set_wind(source, tuple(float(c) for c in velocity))  # type: ignore[arg-type]
        elif source.interface is interfaces.GRASP_POSE:
            self._simulation.set_grasp_pose(source.name, frame.compose(conversions.read_pose(message)), now)
        elif source.interface is interfaces.FLUID_VELOCITY:
            velocity = frame.rotation @ conversions.read_wind(message)
            self._simulation.set_fluid(source.name, tuple(float(c) for c in velocity))  # type: ignore[arg-type]
        elif source.interface is interfaces.WIND_POSE:
            ahead = self.pointer_speed * frame.compose(conversions.read_pose(message)).rotation[:, 0]
            self._set_wind(source, tuple(float(c) for c in ahead))  # type: ignore[arg-type]
        elif source.interface is interfaces.GROUP_POSE:
            self._simulation.set_group_pose(source.name, frame.compose(conversions.read_pose(message)))
        elif source.interface is interfaces.CAMERA_POSE:
            self.viewpoint.pose = frame.compose(conversions.read_pose(message))
            self.viewpoint.follows_topic = True
        else:
            self._simulation.set_obstacle(source.name, frame.compose(conversions.read_pose(message)))

    def _set_wind(self, source: Source, velocity: tuple[float, float, float]) -> None:
        limit = self._simulation.solver.config.max_wind_speed
        used, was_capped = capped(velocity, limit)
        if was_capped:
            shown = ", ".join(f"{c:g}" for c in velocity)
            allowed = f"allowed is a speed of 0 .. {limit:g} m/s (solver.max_wind_speed)"
            self._notices.say(f"{source.topic} capped", f"{source.topic}: vector = ({shown}) m/s: {allowed}; capped")
        self._simulation.set_wind(used)

    def _checked_stamp(self, source: Source, message: Any, now: float) -> int:
        stamp = conversions.stamp_ns(message)
        newest, received = self._accepted.get(source.topic, (0, now))
        if stamp == 0 or stamp >= newest:
            return stamp
        behind = f"{(newest - stamp) / NANOSECONDS:.3f} s"
        if now - received < NEW_EPOCH_AFTER:
            allowed = f"{behind} before the last one: allowed are later or equal ones, or 0"
            raise RefusedError("header.stamp", f"= {stamp / NANOSECONDS:.3f} s is {allowed}")
        cause = f"{source.topic} header.stamp set back"
        self._notices.say(cause, f"{source.topic}: header.stamp went back by {behind}; followed")
        return stamp
