"""The default step: local/global from the inertial prediction, implicit Euler, small substeps, on the paper's W.

From the inertial prediction, bending first (its Hessian is constant: one solve is exact), then stretching:
|x - y|^2_M / (2 h^2) + E(x)  with y the bent prediction is minimised by alternating between the direction that
each spring would like (local) and one product with the constant W (global), after Liu, Bargteil, O'Brien and
Kavan 2013, "Fast simulation of mass-spring systems". Unlike the paper's predictor it does not damp what moves
without deforming.
"""

from __future__ import annotations

import numpy as np

from cloth_core.integrators.model import Model, Substep
from cloth_core.kernels import springs, surface


class ImplicitEuler:
    """Default integrator: ``substeps`` 8, ``iterations`` 2, ``stretch_sweeps`` 6."""

    substeps, iterations, stretch_sweeps = 8, 2, 6

    def __init__(self, model: Model) -> None:
        self.model = model
        self.iterations = model.config.iterations or self.iterations
        self._filter = model.filter_by(model.stretch)
        bends = model.material.bend > 0.0 and len(model.mesh.hinge_vertex) > 0
        self._bending_filter = model.filter_by(model.viscous_bending) if bends else None
        self._force = np.empty_like(model.mesh.rest_position)
        self._right_side = np.empty_like(self._force)

    def advance(
        self, position: np.ndarray, velocity: np.ndarray, substep: Substep
    ) -> tuple[np.ndarray, np.ndarray, int, float]:
        """Advance (V, 3) ``position`` and ``velocity`` by one substep.

        Returns:
            New position, new velocity, sweeps done, worst excess over the stretch limit in the last sweep.
        """
        model = self.model
        inertial = self.predict(position, velocity, substep)
        bent = self.bend(position, inertial, substep)
        moved = bent.copy()
        for _ in range(self.iterations):
            self.relax(bent, moved, substep.h)
        model.balance.correct(position, inertial, moved, substep.held)
        sweeps, excess = model.limit_stretch_in_contact(position, moved, substep)
        return moved, model.final_velocity(position, velocity, moved, substep), sweeps, excess

    def predict(self, position: np.ndarray, velocity: np.ndarray, substep: Substep) -> np.ndarray:
        """Where inertia, gravity and wind alone would lead, (V, 3) m."""
        model, h = self.model, substep.h
        self._force[:] = 0.0
        shown, most = model.area_vectors(position), model.mesh.vertex_area
        surface.add_relative_drag(velocity, substep.flow, shown, most, model.drag, model.mass, h, self._force)
        inertial = np.empty_like(position)
        springs.drift(position, velocity, self._force, model.mass, substep.gravity, h, inertial)
        return inertial

    def bend(self, position: np.ndarray, inertial: np.ndarray, substep: Substep) -> np.ndarray:
        """Where bending and its viscosity lead from the inertial prediction, (V, 3) m, held vertices at their targets.

        In a solve of its own: beside springs that are thousands of times stiffer, the local/global iteration
        would take as many rounds to notice it.
        """
        bent = inertial.copy()
        bent[substep.held] = substep.target
        if self._bending_filter is not None:
            lasting = substep.h * self.model.material.bend_damping
            right_side = self.model.mass[:, None] * inertial + self.model.bending @ (lasting * position)
            self._bending_filter.solve(right_side, bent)
        return bent

    def relax(self, bent: np.ndarray, moved: np.ndarray, h: float) -> None:
        """One local and one global step: springs choose their directions, W reconciles them with inertia."""
        model = self.model
        np.multiply(bent, model.mass[:, None], out=self._right_side)
        mesh = model.mesh
        springs.add_rest_lengths(
            moved, mesh.spring_vertex, mesh.spring_rest, model.spring_stiffness, h * h, self._right_side
        )
        self._filter.solve(self._right_side, moved)
