"""Rigid poses: a position and a unit quaternion in the order x, y, z, w."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cloth_core.errors import InputError, shown


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a frame stands in the world.

    Args:
        position: m.
        orientation: quaternion x, y, z, w; normalised here.

    Raises:
        InputError: a component is no finite number, or the quaternion is zero.
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        position = _numbers("position", self.position, "three finite numbers within +-1e6 m")
        quaternion = _numbers("orientation", self.orientation, "a quaternion (x, y, z, w)")
        if len(position) != 3 or not all(math.isfinite(c) and abs(c) <= 1e6 for c in position):
            raise InputError(f"position {position} m is not three finite numbers within +-1e6")
        length = math.sqrt(sum(c * c for c in quaternion)) if len(quaternion) == 4 else math.nan
        if not 1e-6 < length < 1e6:
            raise InputError(f"orientation {quaternion} is not a quaternion (x, y, z, w) that can be normalised")
        if abs(length - 1.0) > 1e-12:  # exact when read back from a log
            quaternion = tuple(c / length for c in quaternion)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "orientation", quaternion)

    @property
    def rotation(self) -> np.ndarray:
        """(3, 3) rotation matrix, frame to world."""
        x, y, z, w = self.orientation
        return np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
        )

    def apply(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) points of this frame, in the world."""
        return points @ self.rotation.T + self.position

    def inverse_apply(self, points: np.ndarray) -> np.ndarray:
        """(N, 3) points of the world, in this frame."""
        return (points - self.position) @ self.rotation

    def compose(self, inner: Pose) -> Pose:
        """The pose ``inner``, given in this frame, in the world."""
        px, py, pz, pw = self.orientation
        qx, qy, qz, qw = inner.orientation
        turned = (
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
            pw * qw - px * qx - py * qy - pz * qz,
        )
        return Pose(tuple(self.apply(np.array([inner.position]))[0]), turned)

    def rotation_vector_to(self, other: Pose) -> np.ndarray:
        """(3,) rad: axis times angle of the shortest turn from here to ``other``, in the world."""
        if self.orientation == other.orientation:
            return np.zeros(3)
        ax, ay, az, aw = self.orientation
        bx, by, bz, bw = other.orientation
        # other * conjugate(self)
        turn = np.array(
            [
                -bw * ax + bx * aw - by * az + bz * ay,
                -bw * ay + bx * az + by * aw - bz * ax,
                -bw * az - bx * ay + by * ax + bz * aw,
            ]
        )
        cosine = bw * aw + bx * ax + by * ay + bz * az
        sine = math.hypot(*turn)
        if sine < 1e-15:
            return np.zeros(3)
        angle = 2.0 * math.atan2(sine, abs(cosine))
        return turn * (math.copysign(1.0, cosine) * angle / sine)

    def turned(self, rotation_vector: np.ndarray) -> tuple[float, float, float, float]:
        """The orientation after a further turn by ``rotation_vector`` (world axes, rad)."""
        angle = math.hypot(*rotation_vector)
        if angle < 1e-15:
            return self.orientation
        x, y, z = (float(c) for c in np.asarray(rotation_vector) * (math.sin(angle / 2) / angle))
        return Pose(orientation=(x, y, z, math.cos(angle / 2))).compose(Pose(orientation=self.orientation)).orientation

    def shifted(self, way: np.ndarray) -> Pose:
        """The pose moved by ``way`` (3,) m, in the world."""
        return Pose(tuple(float(c) for c in np.add(self.position, way)), self.orientation)

    def toward(self, target: Pose, fraction: float) -> Pose:
        """The pose a ``fraction`` (0..1) of the way to ``target``, along the shortest turn; exact at both ends."""
        if fraction <= 0.0:
            return self
        if fraction >= 1.0:
            return target
        position = tuple(a + fraction * (b - a) for a, b in zip(self.position, target.position, strict=True))
        return Pose(position, self.turned(fraction * self.rotation_vector_to(target)))


def _numbers(name: str, given: Any, allowed: str) -> tuple[float, ...]:
    try:
        if isinstance(given, str):
            raise TypeError
        return tuple(float(c) for c in given)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} {shown(given)} is not {allowed}") from None
