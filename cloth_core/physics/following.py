"""Following: how far the grips go along with the hands, held back by speed and by the cloth, and when they lose it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from cloth_core.config import SolverConfig
from cloth_core.inputs import Grasp
from cloth_core.physics.anchoring import Anchor
from cloth_core.physics.grasping import followed_pose
from cloth_core.physics.reach import PINS, Reach, Tether, Tethers
from cloth_core.pose import Pose
from cloth_core.report import Slip
from cloth_core.state import Grip

PASSES = 32
"""Corrections in a step before the motion is cut instead."""
HALVINGS = 8
"""Cuts of the motion, by half each, before it is given up for this step."""
TAUT = 0.005
"""m of slack that pass for none."""
NEGLIGIBLE = 1e-6
"""m; no cloth is torn by so much."""


@dataclass(frozen=True)
class Followed:
    """Where the grips go in a step.

    Args:
        grips: as given, less what slipped out of them.
        poses: where each shall be at the end of the step.
        slowed: names of those whose hands are too fast to follow.
        taut: names of those that stay behind their hand because the cloth gives no more.
        slips: those that lost the cloth in this step.
    """

    grips: dict[str, Grip]
    poses: dict[str, Pose]
    slowed: tuple[str, ...] = ()
    taut: tuple[str, ...] = ()
    slips: tuple[Slip, ...] = ()


def follow(
    grips: Mapping[str, Grip],
    grasps: Mapping[str, Grasp | Anchor],
    config: SolverConfig,
    reach: Reach,
    position: np.ndarray,
    pinned: np.ndarray,
) -> Followed:
    """Let the grips follow their hands, as far as the speed limits let and the cloth between them and the pins reaches.

    A hand that goes on leaves its grip behind at the end of the cloth. One that asks for more than its
    ``slip_distance`` more cloth than there is loses it: first the one that asks for most, then the rest is tried
    anew without it. What slipped stays closed and empty until the hand opens.

    Args:
        grips: what each hand holds, where it was followed to so far.
        grasps: the hands, by the same names; anchors lose nothing.
        config: has the speed limits.
        reach: of the cloth.
        position: (V, 3) m.
        pinned: vertices, sorted.
    """
    wanted = {name: followed_pose(grip, grasps[name], config) for name, grip in grips.items()}
    slowed = tuple(name for name in grips if wanted[name] != grasps[name].pose)
    grips, slipped = dict(grips), list[Slip]()
    while True:
        held = {PINS: pinned, **{name: grip.vertex for name, grip in grips.items()}}
        ends = _Ends(grips, position)
        tethers = reach.tethers(held)
        poses = _within_reach(tethers, ends, wanted)
        taut = [name for name in grips if poses[name] != wanted[name]]
        asked = {name: ends.excess(tethers, name, grasps[name].pose, poses) for name in taut}
        # What is still slack is pulled taut first.
        lost = [
            name
            for name in taut
            if asked[name] > grasps[name].slip_distance and ends.excess(tethers, name, ends.now[name], ends.now) > -TAUT
        ]
        if not lost:
            return Followed(grips, poses, slowed, tuple(taut), tuple(slipped))
        slips = max(lost, key=asked.__getitem__)  # of equals, the first by name
        slipped.append(Slip(slips, beyond=asked[slips]))
        wanted[slips] = grasps[slips].pose
        grips[slips] = Grip(grasps[slips].pose, closed=True)


class _Ends:
    """Both ends of every tether: where their vertices are if the grips stand at given poses."""

    def __init__(self, grips: Mapping[str, Grip], position: np.ndarray) -> None:
        self._grips, self._position = grips, position
        self.now = {name: grip.pose for name, grip in grips.items()}

    def places(self, name: str, rim: np.ndarray, poses: Mapping[str, Pose]) -> np.ndarray:
        """(N, 3) m."""
        if name == PINS:
            return self._position[rim]
        grip = self._grips[name]
        return poses[name].apply(grip.offset[np.searchsorted(grip.vertex, rim)])

    def apart(self, tether: Tether, poses: Mapping[str, Pose]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Places of both ends, and their distances (N, M) m."""
        first = self.places(tether.first, tether.first_rim, poses)
        second = self.places(tether.second, tether.second_rim, poses)
        return first, second, cdist(first, second)

    def way(self, name: str, pose: Pose) -> float:
        """m, the farthest that a held vertex goes if the grip goes to ``pose``; 0 for pins."""
        if name == PINS:
            return 0.0
        grip = self._grips[name]
        return float(np.linalg.norm(pose.apply(grip.offset) - grip.pose.apply(grip.offset), axis=1).max(initial=0.0))

    def excess(self, tethers: Tethers, name: str, pose: Pose, poses: Mapping[str, Pose]) -> float:
        """m of cloth that are missing if the grip ``name`` stood at ``pose`` and the others at ``poses``."""
        poses = {**poses, name: pose}
        mine = (tether for tether in tethers if name in (tether.first, tether.second))
        return max(float((self.apart(tether, poses)[2] - tether.longest).max()) for tether in mine)


def _within_reach(tethers: Tethers, ends: _Ends, wanted: Mapping[str, Pose]) -> dict[str, Pose]:
    """The poses nearest to those ``wanted`` that the cloth allows, more or less.

    Whoever moves gives way, in the ratio of the ways they want to go; where the cloth asks for more than the
    limit already, it may stay so, but no more.
    """
    places = [ends.places(name, rim, wanted) for name, rim in tethers.rims.items()]
    if not tethers or tethers.slack(np.concatenate(places), NEGLIGIBLE):  # as far as straight lines reach: mostly
        return dict(wanted)
    if not any(_worst(tether, tether.longest, ends, wanted)[0] > NEGLIGIBLE for tether in tethers):
        return dict(wanted)
    longest = {id(t): np.maximum(t.longest, ends.apart(t, ends.now)[2]) for t in tethers}
    way = {name: ends.way(name, pose) for name, pose in wanted.items()} | {PINS: 0.0}
    poses = dict(wanted)
    for _ in range(PASSES):
        excess, pull, tether = max(
            ((*_worst(tether, longest[id(tether)], ends, poses), tether) for tether in tethers), key=lambda one: one[0]
        )
        if excess <= NEGLIGIBLE:
            return poses
        both = max(way[tether.first] + way[tether.second], 1e-12)
        for name, sign in ((tether.first, -1.0), (tether.second, 1.0)):
            if way[name] > 0.0:
                poses[name] = poses[name].shifted(sign * way[name] / both * pull)
    return _cut(tethers, longest, ends, poses)


def _worst(tether: Tether, longest: np.ndarray, ends: _Ends, poses: Mapping[str, Pose]) -> tuple[float, np.ndarray]:
    """m by which the two ends are too far apart, and the vector (3,) m by which the second should follow the first."""
    first, second, apart = ends.apart(tether, poses)
    excess = apart - longest
    i, j = np.unravel_index(np.argmax(excess), excess.shape)
    return float(excess[i, j]), (first[i] - second[j]) * (excess[i, j] / max(apart[i, j], 1e-12))


def _cut(
    tethers: Tethers, longest: Mapping[int, np.ndarray], ends: _Ends, poses: Mapping[str, Pose]
) -> dict[str, Pose]:
    """Half of the way to ``poses``, or half of that, ... for all whose tethers are too short."""
    share = dict.fromkeys(ends.now, 1.0)
    for _ in range(len(share) * (HALVINGS + 1)):
        tried = {name: ends.now[name].toward(poses[name], share[name]) for name in share}
        over = [t for t in tethers if _worst(t, longest[id(t)], ends, tried)[0] > NEGLIGIBLE]
        if not over:
            return tried
        for name in {name for t in over for name in (t.first, t.second)} - {PINS}:
            share[name] = 0.5 * share[name] if share[name] > 0.5**HALVINGS else 0.0
    return dict(ends.now)
