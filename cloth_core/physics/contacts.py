"""Contacts with obstacles that stand or move: who touches, push-out, friction, impact (paper, 4.2)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.kernels import contact as kernels
from cloth_core.material import Material
from cloth_core.obstacles import Obstacle
from cloth_core.pose import Pose


class Contacts:
    """The obstacles of a scene as arrays, and the pairs of vertex and obstacle that touch in the substep at hand."""

    def __init__(
        self, obstacles: Mapping[str, Obstacle], material: Material, config: SolverConfig, vertex_count: int
    ) -> None:
        self.names = list(obstacles)
        count = len(self.names)
        shapes = list(obstacles.values())
        self._kind = np.array([shape.kind for shape in shapes], dtype=np.int64)
        self._size = np.array([shape.size for shape in shapes], dtype=float).reshape(count, 3)
        self._reach = np.array([min(shape.reach, 1e9) for shape in shapes], dtype=float)
        self._friction = np.array(
            [material.friction if s.friction is None else s.friction for s in shapes], dtype=float
        )
        self._restitution = material.restitution
        self._shell = config.contact_shell
        self._config = config
        self._rotation = np.tile(np.eye(3), (count, 1, 1))
        self._origin = np.zeros((count, 3))
        self._rotation_before = self._rotation.copy()
        self._origin_before = self._origin.copy()
        self._turn = np.zeros((count, 3))
        self._travel = np.zeros(count)
        self._pair_vertex = np.zeros(vertex_count * count, dtype=np.int32)
        self._pair_obstacle = np.zeros(vertex_count * count, dtype=np.int32)
        self._pair_depth = np.zeros(vertex_count * count)
        self._pushed = np.zeros(vertex_count * count)
        self._spent = np.zeros(vertex_count * count)
        self._normal = np.zeros((vertex_count * count, 3))
        self._left = np.zeros((vertex_count * count, 3))
        self._pairs = 0

    def begin_step(self, before: Mapping[str, Pose], after: Mapping[str, Pose]) -> list[str]:
        """Set the way of every obstacle for the coming step; returns the names of those too fast to follow.

        An obstacle faster than ``max_obstacle_speed`` (at its farthest point) is teleported: it stands at
        its new place from the start, and its surface drags nothing along.
        """
        self._way: list[tuple[Pose, Pose]] = []
        teleported = []
        for number, name in enumerate(self.names):
            start, end = before[name], after[name]
            way = float(np.linalg.norm(np.subtract(end.position, start.position)))
            lever = self._reach[number] if self._reach[number] < 1e9 else 1.0
            turn = float(np.linalg.norm(start.rotation_vector_to(end)))
            if (
                way > self._config.max_obstacle_speed * self._config.dt
                or turn * lever > self._config.max_obstacle_speed * self._config.dt
            ):
                teleported.append(name)
                start = end
            self._way.append((start, end))
            self._place(number, start)
        self._pairs = 0
        return teleported

    def _place(self, number: int, pose: Pose) -> None:
        self._rotation[number] = pose.rotation
        self._origin[number] = pose.position

    def begin_substep(self, share: float) -> None:
        """Move the obstacles to ``share`` (0..1] of their way through the step."""
        self._rotation_before[:] = self._rotation
        self._origin_before[:] = self._origin
        self._turn[:] = 0.0
        self._travel[:] = 0.0
        for number, (start, end) in enumerate(self._way):
            if start is end or start == end:
                continue
            pose = start.toward(end, share)
            before = self._rotation_before[number]
            self._place(number, pose)
            turn = self._rotation[number] @ before.T
            # The vector of a small rotation, read off its skew part.
            self._turn[number] = 0.5 * np.array(
                [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
            )
            lever = self._reach[number] if self._reach[number] < 1e9 else 1.0
            self._travel[number] = np.linalg.norm(
                self._origin[number] - self._origin_before[number]
            ) + lever * np.linalg.norm(self._turn[number])

    def find(self, start: np.ndarray, predicted: np.ndarray, h: float, free: np.ndarray) -> None:
        """List what may touch while the vertices go from ``start`` to about ``predicted`` (V, 3) m in ``h`` s."""
        self._pairs = kernels.find_contacts(
            start, predicted, self._kind, self._size, self._reach,
            self._rotation_before, self._origin_before, self._travel,
            self._shell, self._config.max_push_speed * h, free,
            self._pair_vertex, self._pair_obstacle, self._pair_depth, self._left,
        )  # fmt: skip
        self._pushed[: self._pairs] = 0.0
        self._spent[: self._pairs] = 0.0

    @property
    def touching(self) -> int:
        """Pairs that were pushed in this substep."""
        return int(np.count_nonzero(self._pushed[: self._pairs]))

    @property
    def touched(self) -> np.ndarray:
        """Vertices that were pushed in this substep."""
        return self._pair_vertex[: self._pairs][self._pushed[: self._pairs] > 0.0]

    def push_out(self, position: np.ndarray) -> float:
        """Bring what is too deep back to the shell, in place; returns the farthest push in m."""
        n = self._pairs
        if n == 0:
            return 0.0
        return kernels.push_out(
            position, self._kind, self._size, self._rotation, self._origin, self._shell,
            self._pair_vertex[:n], self._pair_obstacle[:n], self._pair_depth[:n], self._left[:n],
            self._pushed[:n], self._normal[:n],
        )  # fmt: skip

    def apply_friction(self, start: np.ndarray, position: np.ndarray) -> None:
        """Coulomb friction against the surfaces, which may move, on the displacement from ``start``; in place.

        To be called after every push: the friction of a substep is bounded by all of its pushes together. What the
        next sweep does not move is left alone by the next push: friction takes it off the surface in second order
        only, and the next substep sees it again.
        """
        n = self._pairs
        if n:
            kernels.apply_friction(
                start, position, self._origin, self._origin_before, self._turn, self._friction,
                self._pair_vertex[:n], self._pair_obstacle[:n], self._pushed[:n], self._normal[:n],
                self._spent[:n], self._left[:n],
            )  # fmt: skip

    def settle_velocity(
        self, velocity: np.ndarray, before: np.ndarray, position: np.ndarray, h: float, rest_speed: float
    ) -> None:
        """Give touched vertices the surface's normal velocity, or bounce them; ``velocity`` (V, 3) in place."""
        n = self._pairs
        if n:
            kernels.contact_velocity(
                velocity, before, position, h,
                self._origin, self._origin_before, self._turn, self._restitution, rest_speed,
                self._pair_vertex[:n], self._pair_obstacle[:n], self._pushed[:n], self._normal[:n],
            )  # fmt: skip
