"""Grasps: which vertices a closing gripper captures, and where it carries them."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Grasp
from cloth_core.pose import Pose
from cloth_core.state import Grip


def update_grips(
    grips: Mapping[str, Grip],
    grasps: Mapping[str, Grasp],
    position: np.ndarray,
    pinned: np.ndarray,
    between: Mapping[str, np.ndarray] | None = None,
) -> dict[str, Grip]:
    """Close and open grippers: capture, keep or release vertices. Poses are not moved here.

    What is ``between`` the fingers of those named there is what they capture.

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
            near = np.linalg.norm(position - grasp.pose.position, axis=1) <= grasp.radius
            if between and name in between:
                near = np.isin(np.arange(len(position)), between[name])
            vertex = np.flatnonzero(near & ~taken).astype(np.int32)
            taken[vertex] = True
            grip = Grip(grasp.pose, True, vertex, grasp.pose.inverse_apply(position[vertex]))
        updated[name] = grip
    return updated


def followed_pose(grip: Grip, grasp: Grasp, config: SolverConfig) -> Pose:
    """Where the grip shall be at the end of the step: at the grasp, or as far toward it as the speed limits let."""
    return toward(grip.pose, grasp.pose, config.dt, config) if len(grip.vertex) else grasp.pose


def toward(start: Pose, goal: Pose, time: float, config: SolverConfig, share: float = 1.0) -> Pose:
    """The pose a ``share`` of the way from ``start`` to ``goal``, or less if it takes more than ``time`` s."""
    if start == goal:
        return goal
    way = math.dist(goal.position, start.position)
    turn = math.hypot(*start.rotation_vector_to(goal))
    fastest = min(config.max_grasp_speed * time / max(way, 1e-12), config.max_grasp_turn * time / max(turn, 1e-12))
    return start.toward(goal, min(share, fastest))
