"""Anchors: pinned groups that are moved, each as one rigid body in a frame of its own.

A pinned vertex stays where it is until a pose of its group comes. Then the frame of the group is laid into the mean of
those of its vertices that are pinned, with the axes of the world; from there on they ride in it, wherever the poses
send it. It keeps its frame until none of them is pinned any more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cloth_core.mesh import ClothMesh
from cloth_core.pose import Pose
from cloth_core.state import Grip

PREFIX = "group/"
"""Stands before the names of groups among those of grasps."""
MOST = 1e6
"""m along each axis, as far as a pose can be; what is beyond rides in a frame at its side."""


@dataclass(frozen=True)
class Anchor:
    """Where a moved group shall be; unlike a hand, it never loses the cloth."""

    pose: Pose
    slip_distance: float = math.inf


def anchored(
    grips: Mapping[str, Grip], poses: Mapping[str, Pose], mesh: ClothMesh, position: np.ndarray, pinned: np.ndarray
) -> tuple[dict[str, Grip], dict[str, Anchor]]:
    """The groups that have been moved or shall be, as grips and where each shall go; names have the ``PREFIX``.

    Those without a pose stay. Of groups that share a pinned vertex, the first by name has it.

    Args:
        grips: of the state, those of hands included.
        poses: of groups, by name.
        mesh: has the groups.
        position: (V, 3) m.
        pinned: vertices, sorted.
    """
    free = np.zeros(len(position), dtype=bool)
    free[pinned] = True
    moved, wanted = {}, {}
    for group in sorted(poses.keys() | {name[len(PREFIX) :] for name in grips if name.startswith(PREFIX)}):
        name, members = PREFIX + group, np.unique(mesh.group(group))
        members = members[free[members]].astype(np.int32)
        free[members] = False
        if len(members):
            grip = moved[name] = _with_exactly(grips.get(name), members, position)
            wanted[name] = Anchor(poses.get(group, grip.pose))
    return moved, wanted


def _with_exactly(grip: Grip | None, members: np.ndarray, position: np.ndarray) -> Grip:
    """The grip with these vertices: what it had stays as it is in its frame, the rest as it is in the world."""
    if grip is None:
        middle = np.clip(position[members].mean(axis=0), -MOST, MOST)
        grip = Grip(Pose(tuple(middle.tolist())), closed=True)
    if np.array_equal(grip.vertex, members):
        return grip
    offset = grip.pose.inverse_apply(position[members])
    _, new, old = np.intersect1d(members, grip.vertex, assume_unique=True, return_indices=True)
    offset[new] = grip.offset[old]
    return replace(grip, vertex=members, offset=offset)
