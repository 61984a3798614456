"""What the world does to the cloth during one step: plain numbers in the world frame, no stamps, no frame names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cloth_core.errors import InputError, SettingError, shown
from cloth_core.fluids import Fluid
from cloth_core.pose import Pose
from cloth_core.settings import Setting, Settings, check_kind, check_named, setting

REST_SCALE = Setting("float", "rest lengths within a group over those of the mesh", "m/m", low=0.3, high=3.0)
"""What a scale may be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Grasp(Settings):
    """A gripper or hand: where it is and how far it is closed.

    Closing past ``close_at`` captures the vertices within ``radius`` of the frame's origin and holds
    them rigidly in that frame; opening below ``open_at`` releases them with the velocity they have.
    In between it stays as it is; ``open_at`` equal to ``close_at`` makes a plain switch.
    A hand that goes farther than the cloth reaches leaves it behind, and loses it after ``slip_distance``.

    Raises:
        SettingError: a value has a wrong type or range, or ``open_at`` is above ``close_at``: in between, the hand
            would open and close from step to step.
    """

    pose: Pose
    closure: float = setting("float", 0.0, low=0.0, high=1.0, help="0 open .. 1 closed")
    radius: float = setting(
        "float", 0.03, unit="m", low=1e-4, high=1.0, help="distance within which a closing grasp captures"
    )
    close_at: float = setting("float", 0.6, low=0.0, high=1.0, help="closure at which an open grasp closes")
    open_at: float = setting("float", 0.4, low=0.0, high=1.0, help="closure at which a closed grasp opens")
    slip_distance: float = setting(
        "float",
        0.05,
        unit="m",
        low=0.0,
        high=10.0,
        help="how far beyond the reach of the cloth a hand may go before the cloth slips out of it",
    )

    def __post_init__(self) -> None:
        check_kind("pose", self.pose, Pose, "Pose((x, y, z)) (m)")
        Settings.__post_init__(self)
        if self.open_at > self.close_at:
            allowed = f"allowed is 0 .. close_at, which is {self.close_at:g}"
            raise SettingError("open_at", f"{self.open_at:g} is above close_at: {allowed}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Wind(Settings):
    """Velocity of the air; gusts are smooth in time and place and follow from the seed alone."""

    velocity: tuple[float, float, float] = setting(
        "vector", (0.0, 0.0, 0.0), size=3, unit="m/s", help="mean velocity of the wind"
    )
    gust_intensity: float = setting(
        "float", 0.0, low=0.0, high=1.0, help="root mean square of the gusts, as a share of the mean speed"
    )
    gust_time: float = setting("float", 1.0, unit="s", low=0.05, high=60.0, help="time in which gusts come and go")
    gust_length: float = setting("float", 2.0, unit="m", low=0.05, high=1000.0, help="size of a gust")
    gust_seed: int = setting("int", 1, low=0, high=2**31 - 1, help="the same seed gives the same gusts")


@dataclass(frozen=True, slots=True, kw_only=True)
class Inputs:
    """Everything that drives one step.

    Args:
        grasps: grippers by name; one that disappears lets go.
        wind: the air; no wind by default.
        fluids: regions full of something else, by name; they may be others, or elsewhere, in every step. Where they
            overlap, the first in the order of the alphabet counts.
        obstacles: where declared obstacles stand at the end of the step; those not named stay.
        groups: where the frames of pinned groups shall be, by name; those not named stay. The frame of a group stands
            at the mean of its pinned vertices, along the axes of the world, when a pose of it comes for the first time
            since they were pinned. They follow rigidly, no faster than ``max_grasp_turn`` and none of them faster
            than ``max_grasp_speed``, as far as the cloth reaches. A group of which nothing is pinned is not moved.
        rest_scale: rest lengths within groups, as multiples of those of the mesh, by name of the group; 1 for those not
            named. They get there at no more than 100 %/s of their length.
        gravity: m/s^2.

    Raises:
        InputError: one of them has a wrong type; or gravity or a scale a wrong range.
    """

    grasps: Mapping[str, Grasp] = field(default_factory=dict)
    wind: Wind = Wind()
    fluids: Mapping[str, Fluid] = field(default_factory=dict)
    obstacles: Mapping[str, Pose] = field(default_factory=dict)
    groups: Mapping[str, Pose] = field(default_factory=dict)
    rest_scale: Mapping[str, float] = field(default_factory=dict)
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)

    def __post_init__(self) -> None:
        try:
            check_named("grasps", self.grasps, Grasp, "Grasp(pose=Pose((x, y, z)), closure=1.0)")
            check_kind("wind", self.wind, Wind, "Wind(velocity=(x, y, z)) (m/s)")
            check_named("fluids", self.fluids, Fluid, "Fluid(shape=Plane(), velocity=(x, y, z))")
            check_named("obstacles", self.obstacles, Pose, "Pose((x, y, z)) (m)")
            check_named("groups", self.groups, Pose, "Pose((x, y, z)) (m)")
            object.__setattr__(self, "rest_scale", _scales(self.rest_scale))
        except SettingError as error:
            raise InputError(str(error)) from None
        object.__setattr__(self, "gravity", _acceleration(self.gravity))

    def as_mapping(self) -> dict[str, Any]:
        """Plain lists and numbers; :meth:`from_mapping` gives back bit-equal inputs, through JSON too."""
        return {
            "grasps": {name: {**g.as_mapping(), "pose": pose_as_list(g.pose)} for name, g in self.grasps.items()},
            "wind": self.wind.as_mapping(),
            "fluids": {name: fluid.as_mapping() for name, fluid in self.fluids.items()},
            "obstacles": {name: pose_as_list(pose) for name, pose in self.obstacles.items()},
            "groups": {name: pose_as_list(pose) for name, pose in self.groups.items()},
            "rest_scale": dict(self.rest_scale),
            "gravity": list(self.gravity),
        }

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Inputs:
        """Read what :meth:`as_mapping` wrote."""
        return cls(
            grasps={n: Grasp(**{**g, "pose": pose_from_list(g["pose"])}) for n, g in values["grasps"].items()},
            wind=Wind.from_mapping(values["wind"]),
            fluids={name: Fluid.from_mapping(fluid) for name, fluid in values.get("fluids", {}).items()},
            obstacles={name: pose_from_list(pose) for name, pose in values["obstacles"].items()},
            groups={name: pose_from_list(pose) for name, pose in values.get("groups", {}).items()},
            rest_scale=values.get("rest_scale", {}),
            gravity=tuple(values["gravity"]),
        )


def pose_as_list(pose: Pose) -> list[float]:
    """Seven numbers: position, then quaternion x, y, z, w."""
    return [*pose.position, *pose.orientation]


def pose_from_list(numbers: list[float]) -> Pose:
    """The pose that :func:`pose_as_list` wrote."""
    return Pose(tuple(numbers[:3]), tuple(numbers[3:]))


def _scales(given: Any) -> dict[str, float]:
    check_named("rest_scale", given, object, "0.8")
    return {name: REST_SCALE.check(f"rest_scale.{name}", scale) for name, scale in given.items()}


def _acceleration(given: Any) -> tuple[float, float, float]:
    try:
        x, y, z = (float(c) for c in given)
        if isinstance(given, str) or not all(abs(c) <= 1000.0 for c in (x, y, z)):
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        allowed = "three numbers within +-1000 m/s^2, such as (0.0, 0.0, -9.81)"
        raise InputError(f"gravity {shown(given)} is not {allowed}") from None
    return x, y, z
