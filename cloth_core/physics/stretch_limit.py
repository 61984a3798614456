"""The stretch limit: no thread gets longer than its material allows (paper, 3.3)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import springs as kernels
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh


class StretchLimit:
    """Shortens overlong springs in place, in a fixed order that alternates so that corrections cross the cloth."""

    def __init__(self, mesh: ClothMesh, material: Material, mass: np.ndarray) -> None:
        chosen = mesh.spring_limited
        self._vertex = np.ascontiguousarray(mesh.spring_vertex[chosen])
        self._longest = np.ascontiguousarray(mesh.spring_rest[chosen] * material.stretch_limit)
        self._free_inverse_mass = 1.0 / mass
        self.hold(np.zeros(0, dtype=np.int32))

    def hold(self, held: np.ndarray) -> None:
        """From now on these vertices stay and the other end moves all the way."""
        self._inverse_mass = self._free_inverse_mass.copy()
        self._inverse_mass[held] = 0.0

    def sweep(self, position: np.ndarray, number: int) -> float:
        """One pass over ``position`` (V, 3); odd numbers run backwards. Returns the worst excess it met (a ratio)."""
        return kernels.shorten_springs(position, self._vertex, self._longest, self._inverse_mass, number % 2 == 1)
