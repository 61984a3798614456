"""Friction grasps: a gripper whose fingers squeeze cloth is one more hand, which bears what friction does.

Cloth that is squeezed from both sides cannot keep out of both fingers: their pushes contradict each other, and would
throw it out. So while it sticks it is held, in the middle between them, and goes where they go; and near what they
squeeze the fingers keep half their gap as distance, no longer the whole shell. Whether it sticks is Coulomb's law for
the whole patch: the pull along the fingers against (mu + mu') times the force that closes them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.gripper import Gripper
from cloth_core.inputs import Grasp
from cloth_core.kernels import pinching as kernels
from cloth_core.obstacles import Obstacle
from cloth_core.pose import Pose
from cloth_core.state import Grip

LOOSE = 1.1
"""Gap, in thicknesses of the cloth, at which fingers that hold let go; a little more than that at which they grasp."""


@dataclass(frozen=True, eq=False)
class Pinch:
    """What a gripper does in a step.

    Args:
        grasp: the hand that it amounts to, half way between the fingers.
        between: (V,) which vertices it squeezes.
        strongest: N along the fingers that friction bears.
        across: (3,) unit vector from one finger to the other, in the world.
        gap: m between the fingers where they squeeze.
    """

    grasp: Grasp
    between: np.ndarray
    strongest: float
    across: np.ndarray
    gap: float


class Fingers:
    """The two obstacles of a gripper.

    Args:
        gripper: names them.
        obstacles: by name.
        friction: of the cloth, for fingers that have none of their own.
        config: has the shell.
    """

    def __init__(
        self, gripper: Gripper, obstacles: Mapping[str, Obstacle], friction: float, config: SolverConfig
    ) -> None:
        self.names = (gripper.left, gripper.right)
        self._config = config
        pair = [obstacles[name] for name in self.names]
        self._kind = np.array([finger.kind for finger in pair], np.int64)
        self._size = np.array([finger.size for finger in pair], float)
        self._reach = np.array([min(finger.reach, 1e9) for finger in pair])
        self._strongest = gripper.force * sum(friction if f.friction is None else f.friction for f in pair)

    def pinch(self, grip: Grip | None, position: np.ndarray, poses: Mapping[str, Pose]) -> tuple[Grip | None, Pinch]:
        """Squeeze what is between the fingers at ``poses``; ``grip`` is what they held so far.

        Returns:
            The grip, what it holds a little nearer to the middle, and the pinch. It is closed as long as the fingers
            squeeze anything, or hold something that they have not let go of.
        """
        one, other = (poses[name] for name in self.names)
        thick, across = 2.0 * self._config.contact_shell, np.subtract(other.position, one.position)
        pose = Pose(tuple((0.5 * np.add(one.position, other.position)).tolist()), one.orientation)
        if grip is not None and len(grip.vertex):
            loose = LOOSE * thick
            place = pose.apply(grip.offset)
            gap, shift = self._squeeze(place, one, other, loose)
            way = np.maximum(np.sqrt((shift**2).sum(axis=1, keepdims=True)), 1e-12)
            eased = place + shift * np.minimum(1.0, self._config.max_push_speed * self._config.dt / way)
            grip = replace(grip, offset=pose.inverse_apply(eased))
        else:
            loose, gap = thick, np.zeros(0)
        everywhere, _ = self._squeeze(position, one, other, thick)
        squeezed = everywhere < thick
        gap = np.concatenate([gap[gap < loose], everywhere[squeezed]])
        return grip, Pinch(
            grasp=Grasp(pose=pose, closure=float(len(gap) > 0), slip_distance=self._config.contact_shell),
            between=squeezed,
            strongest=self._strongest,
            across=across / max(float(np.linalg.norm(across)), 1e-12),
            gap=float(gap.min(initial=thick)),
        )

    def _squeeze(self, place: np.ndarray, one: Pose, other: Pose, near: float) -> tuple[np.ndarray, np.ndarray]:
        gap, shift = np.empty(len(place)), np.empty((len(place), 3))
        rotation, origin = np.array([one.rotation, other.rotation]), np.array([one.position, other.position])
        kernels.squeeze(
            np.ascontiguousarray(place), self._kind, self._size, rotation, origin, self._reach, near, gap, shift
        )
        return gap, shift
