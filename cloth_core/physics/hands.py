"""The hands during one step: how their grips come on from substep to substep, stay behind, and lose the cloth."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Grasp
from cloth_core.physics.following import Followed
from cloth_core.physics.grasping import toward
from cloth_core.pose import Pose
from cloth_core.state import Grip

STUCK = 0.1
"""Share of its way in a step below which a grip counts as stuck."""
SLACK = 1.0 + 1e-6
"""On the speed limits, so that a grip arrives in spite of rounding."""


class Hands:
    """Carries grips evenly to where :func:`~cloth_core.physics.following.follow` wants them.

    Args:
        followed: what it said.
        grasps: the hands, by the same names.
        config: has the speed limits.
        substeps: in the step.
    """

    def __init__(self, followed: Followed, grasps: Mapping[str, Grasp], config: SolverConfig, substeps: int) -> None:
        self._followed, self._grasps, self._config, self._substeps = followed, grasps, config, substeps
        self._holding = {name: grip for name, grip in followed.grips.items() if len(grip.vertex)}
        self._pose = {name: grip.pose for name, grip in self._holding.items()}
        self._before = self._pose
        self._rows: dict[str, np.ndarray] = {}

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

    def end(self) -> tuple[dict[str, Grip], tuple[str, ...]]:
        """The grips after the step, and the names of those that slipped in it.

        Beside those that asked for more cloth than there is, a grip slips that hardly came on, while its hand is more
        than ``slip_distance`` away: the cloth hangs on something else than hands and pins.
        """
        grips = {name: replace(grip, pose=self._end_of(name)) for name, grip in self._followed.grips.items()}
        stuck = [name for name in self._holding if self._is_stuck(name)]
        for name in stuck:
            grips[name] = Grip(grips[name].pose, closed=True)
        return grips, tuple(sorted((*self._followed.slipped, *stuck)))

    def _end_of(self, name: str) -> Pose:
        return self._pose.get(name) or self._followed.poses[name]

    def _is_stuck(self, name: str) -> bool:
        begin, wanted, done = self._holding[name].pose, self._followed.poses[name], self._pose[name]
        if done == wanted or _between(begin, done) >= STUCK * _between(begin, wanted):
            return False
        return _between(done, self._grasps[name].pose) > self._grasps[name].slip_distance


def _between(one: Pose, other: Pose) -> float:
    return math.dist(one.position, other.position)
