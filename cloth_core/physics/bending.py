"""Bending and its viscosity, each in an implicit solve of its own, a few times in a step."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import bending as kernels
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
    thousands of times stiffer a local/global iteration would take as many rounds to notice it. The elastic solve is
    a step of implicit Euler under gravity, of which bending's share is kept: without gravity, what is clamped would
    sag too far. (With all that accelerates the cloth it trembles where it lies on something.) Viscosity acts first
    and on velocities, so that what is at rest feels none of it.

    Args:
        matrix: (V, V) N/m, Hessian of the bending energy.
        mass: (V,) kg.
        balance: restores the momenta of free parts, which W does not keep.
        elastic: (M + time^2 B)^-1.
        viscous: (M + time bend_damping B)^-1.
        time: s between two solves.
    """

    def __init__(
        self,
        matrix: csr_matrix,
        mass: np.ndarray,
        balance: MomentumBalance,
        elastic: ImplicitFilter,
        viscous: ImplicitFilter,
        time: float,
    ) -> None:
        self._matrix, self._mass, self._balance, self._time = matrix, mass, balance, time
        self._elastic, self._viscous = elastic, viscous
        shape = (len(mass), 3)
        self.acceleration = np.zeros(shape)
        self._ahead, self._impulse, self._change, self._nothing = (np.zeros(shape) for _ in range(4))

    def damp(self, position: np.ndarray, velocity: np.ndarray, held: np.ndarray) -> np.ndarray:
        """What viscosity leaves of the ``velocity``, (V, 3) m/s.

        Args:
            position: (V, 3) m.
            velocity: (V, 3) m/s.
            held: vertices that are pinned or grasped.
        """
        damped = velocity.copy()
        np.multiply(velocity, self._mass[:, None], out=self._impulse)
        self._viscous.solve(self._impulse, damped)
        self._balance.correct(position, velocity, damped, held)
        return damped

    def bend(
        self, position: np.ndarray, velocity: np.ndarray, lag: np.ndarray, gravity: np.ndarray, held: np.ndarray
    ) -> None:
        """Renew ``acceleration`` (V, 3) m/s^2 for the time to come.

        Args:
            position: (V, 3) m.
            velocity: (V, 3) m/s.
            lag: (V, 3) m/s, by which the motion is ahead of ``velocity``.
            gravity: (3,) m/s^2.
            held: vertices that are pinned or grasped.
        """
        matrix, time, change = self._matrix, self._time, self._change
        kernels.look_ahead(position, velocity, lag, time, self._ahead)
        kernels.add_up_impulses(
            matrix.indptr, matrix.indices, matrix.data, self._ahead, self._mass, gravity, time, self._impulse
        )
        change[held] = 0.0
        self._elastic.solve(self._impulse, change)
        change -= time * gravity
        change[held] = 0.0
        self._balance.correct(position, self._nothing, change, held)
        np.divide(change, time, out=self.acceleration)
