"""The sheet that triangles make, where springs cannot: the same in every mesh, with the threads where they run."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import membrane as kernels
from cloth_core.kernels import shares
from cloth_core.linear.gauges import gauges
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.physics.rest_scale import RestShape


class Membrane:
    """What the triangles of a mesh do as a sheet of a material (see :func:`~cloth_core.linear.gauges.gauges`)."""

    def __init__(self, mesh: ClothMesh, material: Material) -> None:
        self._mesh, self._area, self._slope = mesh, mesh.triangle_area, mesh.triangle_slope
        self._direction, self._modulus = gauges(material)
        self._apart = shares.room(mesh.vertex_count)

    def resize(self, rest: RestShape) -> None:
        """Compute with other rest lengths from now on."""
        self._area, self._slope = rest.triangle_area, rest.triangle_slope

    def add_forces(self, position: np.ndarray, velocity: np.ndarray, viscosity_time: float, force: np.ndarray) -> None:
        """Add elastic forces and the paper's viscosity of ``viscosity_time`` s to ``force`` (V, 3) N."""
        mesh = self._mesh
        kernels.add_membrane_forces(
            position, velocity, mesh.triangles, self._slope, self._area,
            self._direction, self._modulus, viscosity_time, force,
        )  # fmt: skip

    def energy(self, position: np.ndarray) -> float:
        """J, stored at ``position`` (V, 3) m."""
        triangles = self._mesh.triangles
        return kernels.energy(position, triangles, self._slope, self._area, self._direction, self._modulus)

    def add_impulses(
        self,
        position: np.ndarray,
        start: np.ndarray,
        tension: np.ndarray,
        viscosity: float,
        scale: float,
        right_side: np.ndarray,
    ) -> None:
        """The local step: add ``scale`` s^2 times the forces to ``right_side`` (V, 3) kg m, ``tension`` (T, 2) J."""
        mesh = self._mesh
        kernels.add_membrane_impulses(
            position, start, mesh.triangles, self._slope, self._area,
            self._direction, self._modulus, tension, viscosity, scale, right_side, self._apart,
        )  # fmt: skip

    def add_resistance(
        self, position: np.ndarray, tension: np.ndarray, scale: float, along: np.ndarray, across: np.ndarray
    ) -> None:
        """Add what resists a move of each vertex ``along`` (V, 6) kg, tensors, and ``across`` (V,) kg; see the kernel.

        ``scale`` in s^2, ``tension`` (T, 2) J.
        """
        kernels.add_resistance(
            position, self._mesh.triangles, self._slope, self._area, self._direction, self._modulus, tension, scale,
            along, across,
        )  # fmt: skip
