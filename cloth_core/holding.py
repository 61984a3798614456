"""Who holds the cloth in a step: pins, pinned groups that are moved, hands, and fingers that pinch it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.gripper import Gripper
from cloth_core.inputs import Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.anchoring import anchored
from cloth_core.physics.following import Followed, follow
from cloth_core.physics.grasping import update_grips
from cloth_core.physics.hands import Hands
from cloth_core.physics.pinching import Fingers, Pinch
from cloth_core.physics.reach import Reach
from cloth_core.physics.restraint import Restraint
from cloth_core.physics.ways import Ways
from cloth_core.pose import Pose
from cloth_core.state import Grip, State


@dataclass(frozen=True, eq=False)
class Hold:
    """What holds the cloth during one step.

    Args:
        hands: carry what they hold through the substeps; moved groups are among them.
        followed: where they go, and which lost the cloth before they went.
        grasped: vertices that hands hold, sorted.
        held: vertices that are grasped or pinned, sorted.
        empty: grasps that closed in this step on nothing.
        gaps: m that fingers keep from what they squeeze, by name of the obstacle.
    """

    hands: Hands
    followed: Followed
    grasped: np.ndarray
    held: np.ndarray
    empty: tuple[str, ...]
    gaps: Mapping[str, float]


class Holding:
    """Decides in every step what is held, and by whom.

    Args:
        mesh: the cloth.
        material: has the stretch limit and the friction.
        config: has the speeds and forces.
        obstacles: among which the fingers are.
        grippers: pairs of fingers, by name.
        ways: over the mesh.
    """

    def __init__(
        self,
        mesh: ClothMesh,
        material: Material,
        config: SolverConfig,
        obstacles: Mapping[str, Obstacle],
        grippers: Mapping[str, Gripper],
        ways: Ways,
    ) -> None:
        self._mesh, self._config = mesh, config
        self._reach = Reach(mesh, material.stretch_limit, ways)
        self._fingers = {
            name: Fingers(gripper, obstacles, material.friction, config) for name, gripper in grippers.items()
        }
        self.restraint = Restraint(mesh, material, config.max_grasp_force)
        """Holds back what would tear between those that hold."""

    def begin_step(
        self, state: State, inputs: Inputs, poses: Mapping[str, Pose], pinned: np.ndarray, substeps: int
    ) -> Hold:
        """Let hands capture, release and follow.

        Args:
            state: at the beginning.
            inputs: of the step.
            poses: of the obstacles at its end.
            pinned: vertices, sorted.
            substeps: in the step.
        """
        grips, pinches = self._pinched(state, poses)
        grasps = {**inputs.grasps, **{name: pinch.grasp for name, pinch in pinches.items()}}
        between = {name: pinch.between for name, pinch in pinches.items()}
        grips = update_grips(grips, grasps, state.position, pinned, between)
        empty = tuple(name for name, grip in grips.items() if _closed_on_nothing(state.grips.get(name), grip))
        anchors, goals = anchored(state.grips, inputs.groups, self._mesh, state.position, pinned)
        drivers = {**grasps, **goals}
        fixed = np.setdiff1d(pinned, _vertices(anchors.values()))
        self._reach.loosen(max([1.0, *inputs.rest_scale.values(), *state.rest_scale.values()]))
        followed = follow({**grips, **anchors}, drivers, self._config, self._reach, state.position, fixed)
        self._tell_restraint(followed, anchors, pinned)
        grasped = _vertices(followed.grips[name] for name in grips)
        return Hold(
            hands=Hands(followed, drivers, self._config, substeps, pinches),
            followed=followed,
            grasped=grasped,
            held=np.union1d(pinned, grasped),
            empty=empty,
            gaps={finger: pinch.gap for name, pinch in pinches.items() for finger in self._fingers[name].names},
        )

    def _tell_restraint(self, followed: Followed, anchors: Mapping[str, Grip], pinned: np.ndarray) -> None:
        """What moves may stay behind, of the pinned too; what stands must not give way."""
        resting = {name for name, grip in anchors.items() if followed.poses[name] == grip.pose}
        moving = [grip for name, grip in followed.grips.items() if name not in resting]
        self.restraint.hold((grip.vertex for grip in moving), np.setdiff1d(pinned, _vertices(moving)))

    def _pinched(self, state: State, poses: Mapping[str, Pose]) -> tuple[dict[str, Grip], dict[str, Pinch]]:
        """The grips that there are, and what grippers do whose fingers stand at ``poses``."""
        grips, pinches = dict(state.grips), {}
        for name, fingers in self._fingers.items():
            grip, pinches[name] = fingers.pinch(grips.get(name), state.position, poses)
            if grip is not None:
                grips[name] = grip
        return grips, pinches


def _vertices(grips: Iterable[Grip]) -> np.ndarray:
    """(K,) int64, sorted: all that the grips hold."""
    parts = [grip.vertex for grip in grips if len(grip.vertex)]
    return np.sort(np.concatenate(parts)).astype(np.int64) if parts else np.zeros(0, np.int64)


def _closed_on_nothing(before: Grip | None, now: Grip) -> bool:
    return now.closed and len(now.vertex) == 0 and not (before is not None and before.closed)
