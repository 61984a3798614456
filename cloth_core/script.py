"""A scripted user: keyframes of grasps, obstacles and wind, for demonstrations, pictures and tests."""

from __future__ import annotations

import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from cloth_core.errors import InputError, SettingError
from cloth_core.inputs import Grasp, Inputs, Wind
from cloth_core.pose import Pose
from cloth_core.settings import Settings, check_keys, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseKey(Settings):
    """Where something is at one time."""

    at: float = setting("float", unit="s", low=0.0, high=1e5, help="time of the keyframe in the script")
    position: tuple[float, float, float] = setting("vector", size=3, unit="m", low=-1e6, high=1e6, help="position then")
    orientation: tuple[float, float, float, float] = setting(
        "vector", (0.0, 0.0, 0.0, 1.0), size=4, low=-1.0, high=1.0, help="quaternion x, y, z, w then"
    )
    closure: float = setting("float", 0.0, low=0.0, high=1.0, help="0 open .. 1 closed (grasps only)")


@dataclass(frozen=True, slots=True, kw_only=True)
class WindKey(Settings):
    """The mean wind at one time."""

    at: float = setting("float", unit="s", low=0.0, high=1e5, help="time of the keyframe in the script")
    velocity: tuple[float, float, float] = setting(
        "vector", size=3, unit="m/s", low=-200.0, high=200.0, help="mean wind then"
    )


@dataclass(frozen=True, kw_only=True)
class Script:
    """Keyframes by name; between two of them everything moves smoothly and rests at both.

    Args:
        period: s after which the script begins again; 0 plays it once and then stays.
        grasps: keyframes of each gripper.
        obstacles: keyframes of each moving obstacle.
        wind: keyframes of the mean wind.
    """

    period: float = 0.0
    grasps: Mapping[str, Sequence[PoseKey]] = field(default_factory=dict)
    obstacles: Mapping[str, Sequence[PoseKey]] = field(default_factory=dict)
    wind: Sequence[WindKey] = ()

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Script:
        """Read the ``script`` section of a scene file.

        Raises:
            SettingError: a key is unknown, out of range, or a keyframe comes before the one above it.
        """
        check_keys(values, ("period", "grasps", "obstacles", "wind"))
        period = values.get("period", 0.0)
        if isinstance(period, bool) or not isinstance(period, (int, float)) or not 0.0 <= period <= 1e5:
            raise SettingError("period", f"{period!r} is not a number 0 .. 1e+05 s (0 plays the script once)")
        tracks = {
            part: {name: _track(PoseKey, keys, f"{part}.{name}") for name, keys in _section(values, part).items()}
            for part in ("grasps", "obstacles")
        }
        return cls(period=float(period), wind=_track(WindKey, values.get("wind", ()), "wind"), **tracks)

    def inputs_at(self, time: float, rest: Inputs) -> Inputs:
        """The scripted inputs at ``time`` s; what the script does not mention is taken from ``rest``."""
        if self.period > 0.0:
            time = time % self.period
        grasps = {**rest.grasps}
        for name, keys in self.grasps.items():
            pose, closure = _pose_at(keys, time)
            known = rest.grasps.get(name)
            grasps[name] = replace(known, pose=pose, closure=closure) if known else Grasp(pose=pose, closure=closure)
        obstacles = {**rest.obstacles, **{name: _pose_at(keys, time)[0] for name, keys in self.obstacles.items()}}
        return replace(rest, grasps=grasps, obstacles=obstacles, wind=self._wind_at(time, rest.wind))

    def _wind_at(self, time: float, rest: Wind) -> Wind:
        if not self.wind:
            return rest
        a, b, share = _between(self.wind, time)
        velocity = tuple(float(v) for v in (1 - share) * np.array(a.velocity) + share * np.array(b.velocity))
        return replace(rest, velocity=velocity)


def _section(values: Mapping[str, Any], part: str) -> Mapping[str, Any]:
    section = values.get(part, {})
    if not isinstance(section, Mapping):
        raise SettingError(part, f"{section!r} is not a section of named keyframe lists")
    return section


def _track(kind: Any, keys: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(keys, (list, tuple)) or (where != "wind" and not keys):
        raise SettingError(where, f"{keys!r} is not a list of keyframes")
    track = []
    for number, values in enumerate(keys):
        try:
            track.append(kind.from_mapping(values))
            if kind is PoseKey:
                Pose(track[-1].position, track[-1].orientation)
        except SettingError as error:
            raise error.under(f"{where}[{number}]") from None
        except InputError as error:
            raise SettingError(f"{where}[{number}]", str(error)) from None
        if number and track[-1].at <= track[-2].at:
            raise SettingError(f"{where}[{number}].at", f"{track[-1].at:g} s is not after the keyframe before it")
    return tuple(track)


def _between(keys: Sequence[Any], time: float) -> tuple[Any, Any, float]:
    """The keyframes around ``time`` and the smooth share of the way between them, without a jerk at either."""
    following = bisect.bisect_right([key.at for key in keys], time)
    a, b = keys[max(following - 1, 0)], keys[min(following, len(keys) - 1)]
    if a is b or time <= a.at:
        return a, b, 0.0
    s = (time - a.at) / (b.at - a.at)
    return a, b, s * s * s * (10 - 15 * s + 6 * s * s)


def _pose_at(keys: Sequence[PoseKey], time: float) -> tuple[Pose, float]:
    a, b, share = _between(keys, time)
    pose = Pose(a.position, a.orientation).toward(Pose(b.position, b.orientation), share)
    return pose, min(1.0, max(0.0, a.closure + share * (b.closure - a.closure)))
