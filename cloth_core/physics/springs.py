"""Masses and springs: what carries the stretching where no triangles do (paper, section 2)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import shares
from cloth_core.kernels import springs as kernels
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.physics.rest_scale import RestShape


class Springs:
    """What the springs of a mesh do; stands in the place of :class:`~cloth_core.physics.membrane.Membrane`."""

    def __init__(self, mesh: ClothMesh, material: Material) -> None:
        self._mesh, self._stiffness = mesh, mesh.spring_stiffness(material)
        self._rest, self._apart = mesh.spring_rest, shares.room(mesh.vertex_count)

    def resize(self, rest: RestShape) -> None:
        """Compute with other rest lengths from now on."""
        self._rest = rest.spring_rest

    def add_forces(self, position: np.ndarray, velocity: np.ndarray, viscosity_time: float, force: np.ndarray) -> None:
        """Add elastic forces and the paper's viscosity of ``viscosity_time`` s to ``force`` (V, 3) N."""
        mesh = self._mesh
        kernels.add_spring_forces(
            position, velocity, mesh.spring_vertex, self._rest, self._stiffness, viscosity_time, force
        )

    def energy(self, position: np.ndarray) -> float:
        """J, stored at ``position`` (V, 3) m."""
        return kernels.energy(position, self._mesh.spring_vertex, self._rest, self._stiffness)

    def add_impulses(
        self,
        position: np.ndarray,
        start: np.ndarray,
        tension: np.ndarray,
        viscosity: float,
        scale: float,
        right_side: np.ndarray,
    ) -> None:
        """The local step: add ``scale`` s^2 times the forces to ``right_side`` (V, 3) kg m, ``tension`` (S,) N."""
        mesh = self._mesh
        kernels.add_elastic_impulses(
            position, start, mesh.spring_ends, self._rest, self._stiffness,
            tension, viscosity, scale, right_side, self._apart,
        )  # fmt: skip

    def add_resistance(
        self, position: np.ndarray, tension: np.ndarray, scale: float, along: np.ndarray, across: np.ndarray
    ) -> None:
        """Add what resists a move of each vertex ``along`` (V, 6) kg, tensors, and ``across`` (V,) kg; see the kernel.

        ``scale`` in s^2, ``tension`` (S,) N.
        """
        kernels.add_resistance(
            position, self._mesh.spring_ends, self._rest, self._stiffness, tension, scale, along, across
        )  # fmt: skip
