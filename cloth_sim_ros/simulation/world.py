"""What acts on a cloth until something newer comes, and a cloth kept together with that."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cloth_core import ClothSolver, Pose, Wind
from cloth_core.fluids import Fluid
from cloth_sim_ros.simulation.jitter import Tracked


@dataclass(frozen=True)
class Hand:
    """The newest of one grasp: its pose and when it came, its closure."""

    tracked: Tracked | None = None
    closure: float = 0.0
    must_open: bool = False

    def seen(self, pose: Pose, now: float, cutoff: float) -> Hand:
        """The hand with another pose, received at ``now`` (monotonic s); ``cutoff`` Hz takes its jitter away."""
        tracked = self.tracked.next(pose, now, cutoff) if self.tracked else Tracked(pose, pose, now)
        return replace(self, tracked=tracked)


@dataclass(frozen=True, eq=False)
class World:
    """What acts on the cloth until something newer comes."""

    hands: dict[str, Hand]
    wind: Wind
    obstacles: dict[str, Pose]
    fluids: dict[str, Fluid]
    groups: dict[str, Pose] = field(default_factory=dict)
    rest_scale: dict[str, float] = field(default_factory=dict)

    def copy(self) -> World:
        """Another one, which later inputs do not change."""
        copied = {name: dict(value) for name, value in vars(self).items() if isinstance(value, dict)}
        return replace(self, **copied)


@dataclass(frozen=True, eq=False)
class Kept:
    """The cloth and what acts on it, at one instant.

    Args:
        arrays: what :meth:`ClothSolver.snapshot` gave.
        step_index: steps done until then.
        solver: what simulated it.
    """

    arrays: Mapping[str, np.ndarray]
    step_index: int
    solver: ClothSolver
    world: World
