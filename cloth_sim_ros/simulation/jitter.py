"""The jitter of tracked hands, taken away where a hand holds still and let through where it moves.

A first-order low-pass whose cutoff rises with the speed of the hand: Casiez, Roussel and Vogel 2012, *1 EUR Filter*.
What comes out is never farther from what came in than ``LEASH``, so however a hand starts, no lag is felt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cloth_core import Pose

LEASH = (0.002, 0.02)
"""m and rad by which the result may differ from what was measured."""
_SLOPE = (60.0, 6.0)
"""Hz of cutoff for every m/s, and every rad/s."""
_SPEED_CUTOFF_HZ = 3.0
_GAP_S = 0.1
"""Without a pose for so long, the next one is taken as it is."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """A hand as it was measured last, and what the filter makes of it.

    Args:
        pose: the result.
        raw: what was measured.
        at: when, monotonic s.
        speed: (2, 3) m/s and rad/s, low-passed.
    """

    pose: Pose
    raw: Pose
    at: float
    speed: np.ndarray = field(default_factory=lambda: np.zeros((2, 3)))

    def next(self, raw: Pose, at: float, cutoff: float) -> Tracked:
        """The hand measured anew, ``cutoff`` Hz being enough while it holds still; 0 turns the filter off."""
        dt = at - self.at
        if cutoff <= 0.0 or not 0.0 < dt < _GAP_S:
            return Tracked(raw, raw, at)
        measured = np.stack([np.subtract(raw.position, self.raw.position), self.raw.rotation_vector_to(raw)]) / dt
        speed = self.speed + _share(_SPEED_CUTOFF_HZ, dt) * (measured - self.speed)
        way = np.stack([np.subtract(raw.position, self.pose.position), self.pose.rotation_vector_to(raw)])
        done = [_portion(cutoff + _SLOPE[k] * math.hypot(*speed[k]), dt, math.hypot(*way[k]), LEASH[k]) for k in (0, 1)]
        position = np.add(self.pose.position, done[0] * way[0])
        pose = Pose((float(position[0]), float(position[1]), float(position[2])), self.pose.turned(done[1] * way[1]))
        return Tracked(pose, raw, at, speed)


def _share(cutoff: float, dt: float) -> float:
    """What a first-order low-pass takes of a step within ``dt`` s."""
    return 1.0 - math.exp(-2.0 * math.pi * cutoff * dt)


def _portion(cutoff: float, dt: float, way: float, leash: float) -> float:
    """The share of the way to what was measured that is gone."""
    return max(_share(cutoff, dt), 1.0 - leash / way if way > leash else 0.0)
