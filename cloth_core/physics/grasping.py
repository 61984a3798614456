"""Grasps: which vertices a closing gripper captures, and where it carries them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Grasp
from cloth_core.physics.anchoring import Anchor
from cloth_core.pose import Pose
from cloth_core.state import Grip


def update_grips(
    grips: Mapping[str, Grip],
    grasps: Mapping[str, Grasp],
    position: np.ndarray,
    pinned: np.ndarray,
    between: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> dict[str, Grip]:
    """Close and open grippers: capture, keep or release vertices. Poses are not moved here.

    Those named in ``between`` capture the vertices (V,) that are so marked, and those that come between them later.

    A gripper captures the vertices of ``position`` (V, 3) within its radius that are neither ``pinned`` nor
    held by another; where two close at once, the first by name has them. Without its grasp a grip is gone.
    """
    taken = np.zeros(len(position), dtype=bool)
    taken[pinned] = True
    for name in grips.keys() & grasps.keys():
        if grips[name].closed and grasps[name].closure >= grasps[name].open_at:
            taken[grips[name].vertex] = True
    updated = {}
    for name in sorted(grasps):
        grasp = grasps[name]
        grip = grips.get(name) or Grip(grasp.pose)
        if grip.closed and grasp.closure < grasp.open_at:
            grip = Grip(grip.pose)
        elif not grip.closed and grasp.closure >= grasp.close_at:
            # Capture where the hand is now, not where the speed limit let us follow it to.
            apart = np.linalg.norm(position - grasp.pose.position, axis=1)
            grip = _with_more(Grip(grasp.pose, True), between.get(name, apart <= grasp.radius), taken, position)
        elif name in between and len(grip.vertex):
            grip = _with_more(grip, between[name], taken, position)
        updated[name] = grip
    return updated


def _with_more(grip: Grip, near: np.ndarray, taken: np.ndarray, position: np.ndarray) -> Grip:
    """The grip with all that is ``near`` (V,) it and not ``taken`` (V,) yet; it is then."""
    vertex = np.flatnonzero(near & ~taken).astype(np.int32)
    if len(vertex) == 0:
        return grip
    taken[vertex] = True
    offset = np.concatenate([grip.offset, grip.pose.inverse_apply(position[vertex])])
    vertex = np.concatenate([grip.vertex, vertex])
    order = np.argsort(vertex)
    return replace(grip, vertex=vertex[order], offset=np.ascontiguousarray(offset[order]))


def followed_pose(grip: Grip, grasp: Grasp | Anchor, config: SolverConfig) -> Pose:
    """Where the grip shall be at the end of the step: at the grasp, or as far toward it as the speed limits let."""
    if not len(grip.vertex):
        return grasp.pose
    goal = toward(grip.pose, grasp.pose, config.dt, config)
    if not isinstance(grasp, Anchor):
        return goal
    # A group may be so wide that what turns at its ends is too fast.
    way = np.linalg.norm(goal.apply(grip.offset) - grip.pose.apply(grip.offset), axis=1).max()
    return grip.pose.toward(goal, min(1.0, (1.0 + 1e-9) * config.max_grasp_speed * config.dt / max(way, 1e-12)))


def toward(start: Pose, goal: Pose, time: float, config: SolverConfig, share: float = 1.0) -> Pose:
    """The pose a ``share`` of the way from ``start`` to ``goal``, or less if it takes more than ``time`` s."""
    if start == goal:
        return goal
    way = math.dist(goal.position, start.position)
    turn = math.hypot(*start.rotation_vector_to(goal))
    fastest = min(config.max_grasp_speed * time / max(way, 1e-12), config.max_grasp_turn * time / max(turn, 1e-12))
    return start.toward(goal, min(share, fastest))
