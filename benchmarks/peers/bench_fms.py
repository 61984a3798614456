"""The lower bound of cost: "Fast Simulation of Mass-Spring Systems" (Liu et al. 2013) in numpy and scipy.

Local/global projective dynamics with a sparse LU factor made beforehand: no package, but what a competent user would
write instead of installing an engine. Obstacles act once a frame, after the solve.
"""

from __future__ import annotations

from typing import Any

import common
import numpy as np
from workload import FRICTION, SPHERE_CENTER, SPHERE_RADIUS, Scene

GRAVITY = 9.81
KEPT_VELOCITY = 0.999  # of a frame


class Engine:
    """Springs along the grid, across its cells, and over every second vertex against bending."""

    name = "fms"
    variants = ("scipy",)

    @staticmethod
    def collides_with_itself(variant: str) -> bool:
        """It does not."""
        return False

    @staticmethod
    def settings(n: int, scenario: str, variant: str) -> dict[str, Any]:
        """Ten iterations a frame, springs of 1000 N/m."""
        return dict(substeps=1, iters=10, k=1000.0)

    @staticmethod
    def load() -> None:
        """Import the sparse matrices."""
        global sparse, splu
        from scipy import sparse
        from scipy.sparse.linalg import splu

    @staticmethod
    def version() -> str:
        """Of the two packages."""
        import scipy

        return f"scipy {scipy.__version__} numpy {np.__version__}"

    def __init__(self, scene: Scene, settings: dict[str, Any], variant: str) -> None:
        self.scene, self.iterations = scene, settings["iters"]
        self.h = scene.frame_dt / settings["substeps"]
        self.mass = scene.mass / scene.n**2
        self.x, self.v = scene.start.copy(), np.zeros_like(scene.start)
        self._tie_springs(settings)
        self._factorise()

    def _tie_springs(self, settings: dict[str, Any]) -> None:
        number = np.arange(self.scene.n**2).reshape(self.scene.n, self.scene.n)
        structural = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
        shear = [(number[:-1, :-1], number[1:, 1:]), (number[1:, :-1], number[:-1, 1:])]
        bend = [(number[:-2], number[2:]), (number[:, :-2], number[:, 2:])]
        ends, stiffness = [], []
        for family, k in ((structural, settings["k"]), (shear, 0.3 * settings["k"]), (bend, 1e-2)):
            for one, other in family:
                ends.append(np.stack([one.ravel(), other.ravel()], axis=1))
                stiffness.append(np.full(one.size, k * settings["stiffness"]))
        ends, stiffness = np.concatenate(ends), np.concatenate(stiffness)
        start, count = self.scene.start, len(ends)
        self.rest = np.linalg.norm(start[ends[:, 0]] - start[ends[:, 1]], axis=1)
        signs = np.tile([1.0, -1.0], count)
        self.difference = sparse.csr_matrix((signs, ends.ravel(), np.arange(0, 2 * count + 1, 2)), (count, len(start)))
        self.pull = (self.h**2 * self.difference.T @ sparse.diags(stiffness)).tocsr()

    def _factorise(self) -> None:
        count = self.scene.n**2
        self.held = np.array(self.scene.held, int)
        self.free = np.setdiff1d(np.arange(count), self.held)
        matrix = (sparse.eye(count) * self.mass + self.pull @ self.difference).tocsc()
        rows = matrix[self.free]
        self.lu = splu(rows[:, self.free].tocsc(), permc_spec="MMD_AT_PLUS_A", options=dict(SymmetricMode=True))
        self.to_held = rows[:, self.held]

    def step(self, targets: np.ndarray | None) -> None:
        """Predict, iterate local and global step, push out of the obstacles."""
        before = self.x
        predicted = before + self.h * KEPT_VELOCITY * self.v
        predicted[:, 2] -= GRAVITY * self.h**2
        x = predicted.copy()
        if targets is not None:
            x[self.held] = targets
        from_held = self.to_held @ x[self.held] if len(self.held) else 0.0
        inertia = self.mass * predicted[self.free]
        for _ in range(self.iterations):
            d = self.difference @ x
            d *= (self.rest / np.sqrt(np.einsum("ij,ij->i", d, d)))[:, None]
            x[self.free] = self.lu.solve(inertia + (self.pull @ d)[self.free] - from_held)
        if self.scene.sphere:
            self._leave_sphere(before, x)
        if self.scene.ground:
            self._leave_ground(before, x)
        self.v = (x - before) / self.h
        self.x = x

    def _leave_sphere(self, before: np.ndarray, x: np.ndarray) -> None:
        away = x - SPHERE_CENTER
        distance = np.linalg.norm(away, axis=1)
        inside = np.flatnonzero(distance < SPHERE_RADIUS)
        if len(inside) == 0:
            return
        away, depth = away[inside], SPHERE_RADIUS - distance[inside]
        normal = away / distance[inside, None]
        x[inside] += normal * depth[:, None]
        surface = self.h * self.scene.spin * np.stack([-away[:, 1], away[:, 0], np.zeros_like(depth)], axis=1)
        slip = x[inside] - before[inside] - surface
        slip -= normal * (slip * normal).sum(axis=1)[:, None]
        x[inside] -= _rubbed(slip, depth)

    def _leave_ground(self, before: np.ndarray, x: np.ndarray) -> None:
        below = np.flatnonzero(x[:, 2] < 0)
        if len(below) == 0:
            return
        depth = -x[below, 2]
        x[below, 2] = 0
        x[below, :2] -= _rubbed((x[below] - before[below])[:, :2], depth)

    def positions(self) -> np.ndarray:
        """In the order of the scene."""
        return self.x


def _rubbed(slip: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """The part of ``slip`` that Coulomb friction takes back."""
    length = np.linalg.norm(slip, axis=1) + 1e-12
    return slip * np.minimum(1.0, FRICTION * depth / length)[:, None]


if __name__ == "__main__":
    common.run(Engine)
