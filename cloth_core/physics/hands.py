"""The hands during one step: how their grips come on from substep to substep, stay behind, and lose the cloth.

A hand that carries or pulls with more than ``max_grasp_force`` loses the cloth, too. What counts is the mean of the
last :data:`LOAD_TIME`, for the grip follows its hand at once, and a jerk would ask for any force at all in a substep.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Grasp
from cloth_core.physics.anchoring import Anchor
from cloth_core.physics.following import Followed
from cloth_core.physics.grasping import toward
from cloth_core.physics.pinching import Pinch
from cloth_core.pose import Pose
from cloth_core.report import Slip, Wrench
from cloth_core.state import Grip

STUCK = 0.1
"""Share of its way in a step below which a grip counts as stuck."""
LOAD_TIME = 0.2
"""s, over which what a grip has to bear is averaged; older loads fade exponentially."""
SLACK = 1.0 + 1e-6
"""On the speed limits, so that a grip arrives in spite of rounding."""


class Hands:
    """Carries grips evenly to where :func:`~cloth_core.physics.following.follow` wants them.

    Args:
        followed: what it said.
        grasps: the hands, by the same names, and anchors, which feel nothing and lose nothing.
        config: has the speed limits.
        substeps: in the step.
        pinches: those of the hands that are fingers, which hold by friction.
    """

    def __init__(
        self,
        followed: Followed,
        grasps: Mapping[str, Grasp | Anchor],
        config: SolverConfig,
        substeps: int,
        pinches: Mapping[str, Pinch] | None = None,
    ) -> None:
        self._pinches = pinches or {}
        self._followed, self._grasps, self._config, self._substeps = followed, grasps, config, substeps
        self._holding = {name: grip for name, grip in followed.grips.items() if len(grip.vertex)}
        self._pose = {name: grip.pose for name, grip in self._holding.items()}
        self._before = self._pose
        self._rows: dict[str, np.ndarray] = {}
        self._load = {name: grip.load for name, grip in self._holding.items()}

    def targets(self, number: int, held: np.ndarray, position: np.ndarray) -> np.ndarray:
        """Go on to the end of substep ``number``, from 0; (len(held), 3) m, where the ``held`` vertices shall be then.

        ``held`` is the same in all of them. Pinned vertices stay at their ``position`` (V, 3) m, grasped ones ride in
        their gripper's frame.
        """
        left, time = self._substeps - number, SLACK * self._config.dt / self._substeps
        self._before = self._pose
        self._pose = {
            name: toward(pose, self._followed.poses[name], time, self._config, 1.0 / left)
            for name, pose in self._pose.items()
        }
        target = position[held]
        for name, grip in self._holding.items():
            if number == 0:
                self._rows[name] = np.searchsorted(held, grip.vertex)
            target[self._rows[name]] = self._pose[name].apply(grip.offset)
        return target

    def hold_back(self, restrained: np.ndarray, start: np.ndarray, end: np.ndarray) -> None:
        """Hear which vertices went another way from ``start`` to ``end`` (V, 3) m in the substep than they should."""
        for name, grip in self._holding.items():
            vertex = grip.vertex[0]
            if vertex in restrained:
                self._pose[name] = self._before[name].shifted(end[vertex] - start[vertex])

    def wrenches(self, position: np.ndarray, held: np.ndarray, reaction: np.ndarray) -> dict[str, Wrench]:
        """What the ``reaction`` (len(held), 3) N of the ``held`` vertices amounts to, by name of the grasp.

        Moments are about the origin of the pose followed so far; ``position`` is (V, 3) m.
        """
        felt = {name: Wrench() for name in self._followed.grips if not self._is_anchor(name)}
        for name in felt.keys() & self._holding.keys():
            grip = self._holding[name]
            own = reaction[np.searchsorted(held, grip.vertex)]
            felt[name] = Wrench.of(own, position[grip.vertex] - self._pose[name].position)
        return felt

    def bear(self, wrenches: Mapping[str, Wrench]) -> None:
        """Hear what the cloth did to the hands in this step, by name."""
        share = -math.expm1(-self._config.dt / LOAD_TIME)
        for name in wrenches.keys() & self._holding.keys():
            now = np.array(wrenches[name].force)
            if np.isfinite(now).all():
                before = np.array(self._load[name])
                self._load[name] = tuple((before + share * (now - before)).tolist())

    def end(self) -> tuple[dict[str, Grip], tuple[Slip, ...]]:
        """The grips after the step, and which of them slipped in it.

        Beside those that asked for more cloth than there is, a grip slips that hardly came on, while its hand is more
        than ``slip_distance`` away: the cloth hangs on something else than hands and pins. So does one that has had to
        bear more than ``max_grasp_force``; fingers, along themselves, more than their friction.
        """
        grips = {
            name: replace(grip, pose=self._end_of(name), load=self._load.get(name, grip.load))
            for name, grip in self._followed.grips.items()
        }
        slips = [slip for name in self._holding if (slip := self._slip(name)) is not None]
        for slip in slips:
            grips[slip.name] = Grip(grips[slip.name].pose, closed=True)
        return grips, tuple(sorted((*self._followed.slips, *slips), key=lambda slip: slip.name))

    def _is_anchor(self, name: str) -> bool:
        return isinstance(self._grasps[name], Anchor)

    def _slip(self, name: str) -> Slip | None:
        if self._is_anchor(name):
            return None
        if self._is_stuck(name):
            return Slip(name, beyond=_between(self._pose[name], self._grasps[name].pose))
        load, strongest = np.array(self._load[name]), self._config.max_grasp_force
        if name in self._pinches:
            pinch = self._pinches[name]
            load, strongest = load - (load @ pinch.across) * pinch.across, pinch.strongest
        size = math.hypot(*load)
        return Slip(name, load=size) if size > strongest else None

    def _end_of(self, name: str) -> Pose:
        return self._pose.get(name) or self._followed.poses[name]

    def _is_stuck(self, name: str) -> bool:
        begin, wanted, done = self._holding[name].pose, self._followed.poses[name], self._pose[name]
        if done == wanted or _between(begin, done) >= STUCK * _between(begin, wanted):
            return False
        return _between(done, self._grasps[name].pose) > self._grasps[name].slip_distance


def _between(one: Pose, other: Pose) -> float:
    return math.dist(one.position, other.position)
