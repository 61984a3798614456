"""All that a step changes: positions, velocities, what is held, where the obstacles were."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cloth_core.inputs import pose_as_list, pose_from_list
from cloth_core.pose import Pose


@dataclass(frozen=True, eq=False)
class Grip:
    """A grasp as the cloth feels it: the pose followed so far and the vertices it holds."""

    pose: Pose
    closed: bool = False
    vertex: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    """(K,) int32, sorted."""
    offset: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    """(K, 3) m: the held vertices in the gripper's frame."""


@dataclass(frozen=True, eq=False)
class State:
    """The cloth at one instant. Together with the inputs it determines the next one.

    Args:
        position: (V, 3) m.
        velocity: (V, 3) m/s.
        step_index: steps done since the start.
        time: s of simulated time.
        grips: by name of the grasp.
        obstacles: poses of the obstacles, by name.
        history: what the integrator remembers of the last substep, by name; empty means that it starts afresh,
            as after an edit.
    """

    position: np.ndarray
    velocity: np.ndarray
    step_index: int = 0
    time: float = 0.0
    grips: Mapping[str, Grip] = field(default_factory=dict)
    obstacles: Mapping[str, Pose] = field(default_factory=dict)
    history: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def held(self) -> np.ndarray:
        """Sorted vertices that grasps hold."""
        parts = [grip.vertex for grip in self.grips.values()]
        return np.unique(np.concatenate(parts)) if parts else np.zeros(0, np.int32)

    @property
    def digest(self) -> str:
        """Short SHA-256 of positions and velocities: equal if and only if they are bit-equal."""
        return hashlib.sha256(self.position.tobytes() + self.velocity.tobytes()).hexdigest()[:16]

    def as_arrays(self) -> dict[str, np.ndarray]:
        """Everything as named arrays (for ``numpy.savez``); :meth:`from_arrays` is exact."""
        rest = {
            "step_index": self.step_index,
            "time": self.time,
            "obstacles": {name: pose_as_list(pose) for name, pose in self.obstacles.items()},
            "history": list(self.history),
            "grips": {name: [pose_as_list(grip.pose), grip.closed] for name, grip in self.grips.items()},
        }
        arrays = {"position": self.position, "velocity": self.velocity}
        arrays.update({f"history/{name}": array for name, array in self.history.items()})
        for name, grip in self.grips.items():
            arrays[f"grip_vertex/{name}"] = grip.vertex
            arrays[f"grip_offset/{name}"] = grip.offset
        arrays["rest"] = np.frombuffer(json.dumps(rest).encode(), np.uint8)
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> State:
        """The state that :meth:`as_arrays` wrote."""
        rest = json.loads(bytes(arrays["rest"]))
        grips = {
            name: Grip(pose_from_list(pose), closed, arrays[f"grip_vertex/{name}"], arrays[f"grip_offset/{name}"])
            for name, (pose, closed) in rest["grips"].items()
        }
        return cls(
            position=np.array(arrays["position"], dtype=float),
            velocity=np.array(arrays["velocity"], dtype=float),
            step_index=rest["step_index"],
            time=rest["time"],
            grips=grips,
            obstacles={name: pose_from_list(pose) for name, pose in rest["obstacles"].items()},
            history={name: np.array(arrays[f"history/{name}"]) for name in rest.get("history", ())},
        )
