"""Local/global, then sweeps that move one vertex at a time to where its own springs and inertia want it."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.sparse import csr_matrix

from motion.cloth import Cloth
from motion.minimisers import local_global
from motion.stage import Field, Minimiser, Objective


def with_sweeps(count: int) -> Minimiser:
    """``count`` Gauss-Seidel sweeps of 3 x 3 Newton steps after the solves with W, there and back by turns.

    As in vertex block descent (Chen et al. 2024), with the Hessian of a compressed spring kept positive.
    """
    neighbours: dict[str, tuple[np.ndarray, ...]] = {}

    def minimise(phi: Objective, w: Field, z: np.ndarray, iterations: int) -> np.ndarray:
        if not neighbours:
            neighbours["of"] = _neighbours(phi.cloth)
        z = local_global(phi, w, z, iterations)
        order = np.setdiff1d(np.arange(len(z)), phi.cloth.pins)
        for number in range(count):
            _sweep(
                order if number % 2 == 0 else order[::-1].copy(), z, phi.y, phi.cloth.mass, phi.tau, *neighbours["of"]
            )
        return z

    return minimise


def _neighbours(cloth: Cloth) -> tuple[np.ndarray, ...]:
    """Rows of vertices: where each begins, neighbours, stiffness and rest length of the springs to them."""
    first, second = cloth.ends.T
    shape = (len(cloth.start),) * 2
    both = np.concatenate([first, second]), np.concatenate([second, first])
    stiffness, rest = (csr_matrix((np.tile(values, 2), both), shape) for values in (cloth.stiffness, cloth.rest))
    return stiffness.indptr, stiffness.indices, stiffness.data, rest.data


@njit(cache=True)
def _sweep(order, z, y, mass, tau, begin, neighbour, stiffness, rest):
    gradient, hessian, away = np.empty(3), np.empty((3, 3)), np.empty(3)
    for v in order:
        hessian[:] = 0.0
        for a in range(3):
            gradient[a] = mass * (z[v, a] - y[v, a])
            hessian[a, a] = mass
        for s in range(begin[v], begin[v + 1]):
            k, square = tau * tau * stiffness[s], 0.0
            for a in range(3):
                away[a] = z[v, a] - z[neighbour[s], a]
                square += away[a] * away[a]
            pull = 1.0 - rest[s] / np.sqrt(square)
            across = k * max(pull, 0.0)
            for a in range(3):
                gradient[a] += k * pull * away[a]
                hessian[a, a] += across
                for b in range(3):
                    hessian[a, b] += (k - across) * away[a] * away[b] / square
        # The inverse of a symmetric 3 x 3 matrix: cross products of its rows over its determinant.
        columns = _cross(hessian[1], hessian[2]), _cross(hessian[2], hessian[0]), _cross(hessian[0], hessian[1])
        determinant = 0.0
        for a in range(3):
            determinant += hessian[0, a] * columns[0][a]
        for a in range(3):
            z[v, a] -= (
                gradient[0] * columns[0][a] + gradient[1] * columns[1][a] + gradient[2] * columns[2][a]
            ) / determinant


@njit(cache=True)
def _cross(p, q):
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]
