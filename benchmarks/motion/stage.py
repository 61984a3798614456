"""The one equation that every implicit scheme here has to solve: z = y + tau^2 a(z)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.sparse import diags, identity
from scipy.sparse.linalg import splu

from motion.cloth import GRAVITY, Cloth

Field = Callable[[np.ndarray], np.ndarray]
Minimiser = Callable[["Objective", Field, np.ndarray, int], np.ndarray]


class Objective:
    """Phi(z) = |z - y|^2 m / 2 + tau^2 E(z); where its gradient vanishes, z = y + tau^2 f(z) / m."""

    def __init__(self, cloth: Cloth, tau: float, y: np.ndarray) -> None:
        self.cloth, self.tau, self.y = cloth, tau, y

    def __call__(self, z: np.ndarray) -> float:
        """kg m^2."""
        away = z - self.y
        return 0.5 * self.cloth.mass * float((away * away).sum()) + self.tau**2 * self.cloth.elastic_energy(z)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """(V, 3) kg m; without meaning at held vertices."""
        return self.cloth.mass * (z - self.y) - self.tau**2 * self.cloth.elastic_force(z)


class Stage:
    """Solves z = y + tau^2 a(z) with so many products with W = (M + tau^2 K)^-1, the pins eliminated.

    Args:
        cloth: what moves.
        minimise: from :mod:`motion.minimisers`.
        iterations: solves with W each time.
        hinge: whether to give back the angular momentum about the line through the pins that W took.
        softer: K in W is multiplied by this; below 1 the iteration is over-relaxed.
        warm: the share of the last z - y that is added to y to start from.
    """

    def __init__(
        self,
        cloth: Cloth,
        minimise: Minimiser,
        iterations: int,
        *,
        hinge: bool = False,
        softer: float = 1.0,
        warm: float = 0.0,
    ) -> None:
        self._cloth, self._minimise, self._iterations = cloth, minimise, iterations
        self._hinge, self._warm, self._last = hinge, warm, 0.0
        self._filter = cache(lambda tau: _filter(cloth, tau, softer))  # the paper's point: one for the whole run

    def __call__(self, y: np.ndarray, tau: float) -> np.ndarray:
        """z (V, 3) m for a ``y`` (V, 3) m without gravity; held vertices stay where they were at the start."""
        cloth = self._cloth
        y = y + tau**2 * GRAVITY
        y[cloth.pins] = cloth.start[cloth.pins]
        begin = y + self._warm * self._last
        z = self._minimise(Objective(cloth, tau, y), self._filter(tau), begin, self._iterations)
        self._last = z - y
        return give_back_turn(cloth, y, z) if self._hinge else z


def give_back_turn(cloth: Cloth, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Turn ``z`` about the line through the two pins until z - y has no moment about it.

    The exact z has none, for internal forces and the pins' reactions turn nothing about that line. A few solves
    with W leave one: its springs pull towards where the last iterate pointed, not along themselves.
    """
    pivot, other = cloth.start[cloth.pins]
    axis = (other - pivot) / np.linalg.norm(other - pivot)
    turning = (z - pivot) @ np.cross(axis, np.eye(3))  # axis x arm: the displacement by a turn of 1 rad
    return z + turning * ((turning * (y - z)).sum() / (turning * turning).sum())


def _filter(cloth: Cloth, tau: float, softer: float) -> Field:
    """W as a function of a right side (V, 3); zero at held vertices."""
    vertices = len(cloth.start)
    laplacian = cloth.difference.T @ diags(softer * cloth.stiffness) @ cloth.difference
    free = np.setdiff1d(np.arange(vertices), cloth.pins)
    matrix = (cloth.mass * identity(vertices) + tau**2 * laplacian).tocsc()[free][:, free]
    factor = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(right_side: np.ndarray) -> np.ndarray:
        solution = np.zeros((vertices, 3))
        solution[free] = factor.solve(right_side[free])
        return solution

    return solve
