"""Bending and its viscosity, each in an implicit solve of its own, a few times in a step."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import sparse
from cloth_core.linear import ImplicitFilter
from cloth_core.physics.momentum import MomentumBalance

SLOWEST = 0.01
"""s that one solve may cover at most: bending is weak, and what it does within that time is little."""

LEAST_DAMPING = 0.005
"""s, the least ``bend_damping`` that is computed with: forces that hold for some substeps, while the cloth turns
beneath them, feed it a little energy, which as little viscosity takes away."""


class Bending:
    """What hinges do to the cloth, as accelerations that hold for some substeps.

    Bending has a constant Hessian, so one solve is exact. It has matrices of its own, for beside springs that are
    thousands of times stiffer a local/global iteration would take as many rounds to notice it. Viscosity acts
    first and on velocities, so that what is at rest feels none of it.

    Args:
        matrix: (V, V) N/m, Hessian of the bending energy.
        mass: (V,) kg.
        balance: restores the momenta of free parts, which W does not keep.
        elastic: (M + time^2 B)^-1.
        viscous: (M + time bend_damping B)^-1, or None.
        time: s between two solves.
    """

    def __init__(
        self,
        matrix: csr_matrix,
        mass: np.ndarray,
        balance: MomentumBalance,
        elastic: ImplicitFilter,
        viscous: ImplicitFilter | None,
        time: float,
    ) -> None:
        self._matrix, self._mass, self._balance, self._time = matrix, mass[:, None], balance, time
        self._elastic, self._viscous = elastic, viscous
        self.acceleration, self._right_side, self._force = (np.zeros((len(mass), 3)) for _ in range(3))

    def update(
        self, position: np.ndarray, velocity: np.ndarray, held: np.ndarray, lag: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """Renew ``acceleration`` (V, 3) m/s^2 for the time to come.

        Args:
            position: (V, 3) m.
            velocity: (V, 3) m/s.
            held: vertices that are pinned or grasped.
            lag: (V, 3) m/s, by which the motion is ahead of ``velocity``.

        Returns:
            ``velocity`` after the viscosity, a new array.
        """
        matrix, damped = self._matrix, velocity.copy()
        if self._viscous is not None:
            np.multiply(velocity, self._mass, out=self._right_side)
            self._viscous.solve(self._right_side, damped)
            self._balance.correct(position, velocity, damped, held)
        kick = np.zeros_like(position)
        np.add(damped, lag, out=self._right_side)
        self._right_side *= self._time
        self._right_side += position
        sparse.product(matrix.indptr, matrix.indices, matrix.data, -self._time, self._right_side, self._force)
        self._elastic.solve(self._force, kick)
        self._balance.correct(position, np.zeros_like(kick), kick, held)
        np.divide(kick, self._time, out=self.acceleration)
        return damped
