"""The stretch limit of a sheet of triangles: no warp and no weft in any of them gets longer than its material allows.

Shearing is free, as it is on a grid, whose diagonals have no limit: threads that cross turn against each other.
"""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import membrane as kernels
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.physics import stretch_limit
from cloth_core.physics.rest_scale import RestShape
from cloth_core.physics.stretch_limit import HeldMasses


class ThreadLimit(HeldMasses):
    """As :class:`~cloth_core.physics.stretch_limit.StretchLimit`, for threads of triangles."""

    def __init__(self, mesh: ClothMesh, material: Material, mass: np.ndarray) -> None:
        super().__init__(mass)
        self._triangles, self._longest = mesh.triangles, material.stretch_limit
        self._modulus = stretch_limit.SHARE * np.array(material.sheet_stiffness()[:2])
        self.resize(RestShape.of(mesh))
        self._room = np.arange(self._stiffness.size)
        self._taut = self._room.copy()

    def resize(self, rest: RestShape) -> None:
        """Compute with other rest lengths from now on."""
        self._slope, self._stiffness = rest.triangle_slope, rest.triangle_area[:, None] * self._modulus

    def slack(self) -> np.ndarray:
        """(T, 2) J, no tension yet: that of warp and weft, for a stretch of one."""
        return np.zeros(self._stiffness.shape)

    def find(self, position: np.ndarray, tension: np.ndarray) -> None:
        """Find the threads that :meth:`carry` and :meth:`sweep` shall look at, ``tension`` (T, 2) J as below."""
        shortest = (1.0 - stretch_limit.SLACK) * self._longest
        count = kernels.find_taut_threads(position, self._triangles, self._slope, shortest, tension, self._room)
        self._taut = self._room[:count]

    def carry(self, start: np.ndarray, position: np.ndarray, tension: np.ndarray) -> None:
        """Update the ``tension`` (T, 2) J by which threads at their limit pull beyond their stiffness, in place."""
        kernels.carry_thread_limit(
            start, position, self._taut, self._triangles, self._slope, self._longest, self._stiffness,
            stretch_limit.FADE, stretch_limit.YIELDING, stretch_limit.STEADY, tension,
        )  # fmt: skip

    def sweep(self, position: np.ndarray, number: int) -> float:
        """One pass over ``position`` (V, 3); odd numbers run backwards. Returns the worst excess it met (a ratio)."""
        return kernels.shorten_threads(
            position, self._taut, self._triangles, self._slope, self._longest, self._inverse_mass, number % 2 == 1
        )

    def calm(self, position: np.ndarray, velocity: np.ndarray, lag: np.ndarray) -> None:
        """As :meth:`StretchLimit.calm <cloth_core.physics.stretch_limit.StretchLimit.calm>`."""
        kernels.calm_overlong_threads(
            position, velocity, lag, self._taut, self._triangles, self._slope, self._longest, self._inverse_mass,
            stretch_limit.RECOVERY,
        )  # fmt: skip
