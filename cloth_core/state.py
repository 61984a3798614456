"""All that a step changes: positions, velocities, what is held, where the obstacles were."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cloth_core.errors import ClothError, InputError, shown
from cloth_core.inputs import pose_as_list, pose_from_list
from cloth_core.pose import Pose

FARTHEST = 1e7
"""m along each axis, beyond which no vertex may be: ten times as far as poses and rest shapes, so that whatever these
put side by side is within; lengths of a thread still have their digits there."""
FASTEST = 1e6
"""m/s along each axis, beyond which no vertex may move: ten times the speed of all that drives it."""


@dataclass(frozen=True, eq=False)
class Grip:
    """A grasp as the cloth feels it: the pose followed so far and the vertices it holds."""

    pose: Pose
    closed: bool = False
    vertex: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    """(K,) int32, sorted."""
    offset: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    """(K, 3) m: the held vertices in the gripper's frame."""
    load: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """N: what the cloth has been pulling with lately, in the world."""


@dataclass(frozen=True, eq=False)
class State:
    """The cloth at one instant. Together with the inputs it determines the next one.

    Args:
        position: (V, 3) m, within :data:`FARTHEST`.
        velocity: (V, 3) m/s, within :data:`FASTEST`.
        step_index: steps done since the start.
        time: s of simulated time.
        grips: by name of the grasp; ``group/`` and its name for a pinned group that has been moved.
        obstacles: poses of the obstacles, by name.
        rest_scale: rest lengths within groups, as multiples of those of the mesh, where they are not 1.
        history: what the integrator remembers of the last substep, by name; empty means that it starts afresh,
            as after an edit.
    """

    position: np.ndarray
    velocity: np.ndarray
    step_index: int = 0
    time: float = 0.0
    grips: Mapping[str, Grip] = field(default_factory=dict)
    obstacles: Mapping[str, Pose] = field(default_factory=dict)
    rest_scale: Mapping[str, float] = field(default_factory=dict)
    history: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def held(self) -> np.ndarray:
        """Sorted vertices that grasps hold, or moved groups."""
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
            "rest_scale": dict(self.rest_scale),
            "history": list(self.history),
            "grips": {name: [pose_as_list(g.pose), g.closed, list(g.load)] for name, g in self.grips.items()},
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
        """The state that :meth:`as_arrays` wrote.

        Raises:
            InputError: an array is missing, or is not what was written; the message names it.
        """
        text = entry(arrays, "rest")
        try:
            rest = json.loads(text.tobytes())
            grips = {name: (pose_from_list(p), bool(c), _vector(load)) for name, (p, c, load) in rest["grips"].items()}
            bare = cls(
                position=_floats(arrays, "position"),
                velocity=_floats(arrays, "velocity"),
                step_index=int(rest["step_index"]),
                time=float(rest["time"]),
                obstacles={name: pose_from_list(pose) for name, pose in rest["obstacles"].items()},
                rest_scale={str(name): float(scale) for name, scale in rest.get("rest_scale", {}).items()},
                history={name: _floats(arrays, f"history/{name}") for name in list(rest["history"])},
            )
        except ClothError:
            raise
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            problem = f"rest: is not the JSON text of step, time, poses and grips that as_arrays wrote: {error!r}"
            raise InputError(problem) from None
        held = {name: (entry(arrays, f"grip_vertex/{name}"), _floats(arrays, f"grip_offset/{name}")) for name in grips}
        made = {name: Grip(pose, closed, *held[name], load) for name, (pose, closed, load) in grips.items()}
        return replace(bare, grips=made)


def entry(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    """One of the arrays of a snapshot.

    Raises:
        InputError: it is missing or cannot be read.
    """
    if not isinstance(arrays, Mapping):
        raise InputError(f"{shown(arrays)} is not a mapping from names to arrays, as snapshot() gives")
    try:
        return np.asarray(arrays[name])
    except KeyError:
        raise InputError(f"{name}: missing; there are {', '.join(map(str, arrays)) or 'no arrays'}") from None
    except Exception as error:  # a file of arrays is read only here, and may be damaged in many ways
        raise InputError(f"{name}: cannot be read: {error}") from None


def _floats(arrays: Mapping[str, np.ndarray], name: str) -> np.ndarray:
    values = entry(arrays, name)
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: is not an array of numbers") from None


def _vector(numbers: list[float]) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in numbers)
    return x, y, z
