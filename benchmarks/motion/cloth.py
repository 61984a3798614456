"""The cloth of the release test, its springs and its energy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

GRAVITY = np.array([0.0, 0.0, -9.81])
SIDE, MASS = 1.0, 0.2  # m, kg
SHEAR, BEND = 1 / 2, 1 / 100  # stiffness of these springs, in that of the threads


@dataclass(frozen=True)
class Cloth:
    """Equal masses and springs.

    Args:
        start: (V, 3) m, the cloth before it is let go.
        difference: (S, V), +1 and -1 in each row: ``difference @ x`` are the springs as vectors.
        rest: (S,) m.
        stiffness: (S,) N/m.
        thread: (S,), whether a spring joins neighbours along a row or a column.
        pins: vertices that are held.
        mass: kg of each vertex.
    """

    start: np.ndarray
    difference: csr_matrix
    rest: np.ndarray
    stiffness: np.ndarray
    thread: np.ndarray
    pins: np.ndarray
    mass: float

    @property
    def ends(self) -> np.ndarray:
        """(S, 2), the vertices of each spring."""
        return self.difference.indices.reshape(-1, 2)

    def elastic_force(self, x: np.ndarray) -> np.ndarray:
        """(V, 3) N: each spring pulls with k (1 - rest / length) times itself."""
        spring = self.difference @ x
        pull = self.stiffness * (1.0 - self.rest / _lengths(spring))
        return self._gather @ (-pull[:, None] * spring)

    @cached_property
    def _gather(self) -> csr_matrix:
        return self.difference.T.tocsr()

    def elastic_energy(self, x: np.ndarray) -> float:
        """J."""
        return float(0.5 * self.stiffness @ (_lengths(self.difference @ x) - self.rest) ** 2)

    def acceleration(self, x: np.ndarray) -> np.ndarray:
        """(V, 3) m/s^2, as if nothing were held."""
        return GRAVITY + self.elastic_force(x) / self.mass

    def energy(self, x: np.ndarray, v: np.ndarray) -> float:
        """Kinetic, elastic and potential, J; zero for the cloth at ``start``."""
        return self.mass * float(0.5 * (v * v).sum() - (x @ GRAVITY).sum()) + self.elastic_energy(x)

    def stretch(self, x: np.ndarray) -> float:
        """Length of the most stretched thread, as a multiple of its rest length."""
        return float((_lengths(self.difference @ x) / self.rest)[self.thread].max())


def release_test(k: float, side: int = 30) -> Cloth:
    """A square of ``side`` x ``side`` vertices, flat, held by two neighbouring corners; threads of ``k`` N/m."""
    vertex = np.arange(side * side).reshape(side, side)
    families = {
        k: [(vertex[:-1], vertex[1:]), (vertex[:, :-1], vertex[:, 1:])],
        k * SHEAR: [(vertex[:-1, :-1], vertex[1:, 1:]), (vertex[1:, :-1], vertex[:-1, 1:])],
        k * BEND: [(vertex[:-2], vertex[2:]), (vertex[:, :-2], vertex[:, 2:])],
    }
    pairs = [(stiffness, pair) for stiffness, two in families.items() for pair in two]
    first, second = (np.concatenate([pair[end].ravel() for _, pair in pairs]) for end in (0, 1))
    stiffness = np.concatenate([np.full(pair[0].size, value) for value, pair in pairs])
    along = np.linspace(0.0, SIDE, side)
    x, y = np.meshgrid(along, along)
    start = np.column_stack([x.ravel(), y.ravel(), np.zeros(side * side)])
    rows = np.arange(len(first))
    difference = csr_matrix(
        (np.repeat([-1.0, 1.0], len(first)), (np.tile(rows, 2), np.concatenate([first, second]))),
        shape=(len(first), len(start)),
    )
    rest = _lengths(difference @ start)
    return Cloth(start, difference, rest, stiffness, stiffness == k, vertex[0, [0, -1]], MASS / len(start))


def _lengths(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
