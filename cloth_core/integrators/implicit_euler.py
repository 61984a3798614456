"""The default step: local/global from the inertial prediction, implicit Euler, small substeps, on the paper's W.

Minimises  |x - y|^2_M / (2 h^2) + E(x)  with y the inertial prediction, alternating between the direction
that each spring would like (local) and one product with the constant W (global), after Liu, Bargteil,
O'Brien and Kavan 2013, "Fast simulation of mass-spring systems". Unlike the paper's predictor it does not
damp what moves without deforming.
"""

from __future__ import annotations

import numpy as np

from cloth_core.integrators.model import Model, Substep
from cloth_core.kernels import springs, surface

# One iteration leaves a cloth in contact trembling; two let it come to rest. A whip or a gust that turns springs
# within a substep needs more, or it gains energy. An update below this share of the mean spring length is the last.
LEAST_ITERATIONS = 2
SETTLED = 0.01


class ImplicitEuler:
    """Default integrator: ``substeps`` 10, ``iterations`` 2 or 3 as the motion asks, ``stretch_sweeps`` 4."""

    substeps, iterations, stretch_sweeps = 10, 3, 4

    def __init__(self, model: Model) -> None:
        self.model = model
        self.iterations = model.config.iterations or self.iterations
        # Iterations that the user asked for are all done: a slow swing moves little and is still far from solved.
        early = not model.config.iterations and len(model.mesh.spring_rest) > 0
        self._settled = SETTLED * float(model.mesh.spring_rest.mean()) if early else 0.0
        self._force = np.empty_like(model.mesh.rest_position)
        self._before = np.empty_like(self._force)
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
        viscous = self.bending_viscosity(position, substep.h)
        moved = inertial.copy()
        moved[substep.held] = substep.target
        for iteration in range(1, self.iterations + 1):
            update = self.relax(inertial, viscous, moved, substep.h)
            if iteration >= LEAST_ITERATIONS and update <= self._settled:
                break
        model.balance.correct(position, inertial, moved, substep.held)
        sweeps, excess = model.limit_stretch_in_contact(position, moved, substep)
        return moved, model.final_velocity(position, velocity, moved, substep), sweeps, excess

    def predict(self, position: np.ndarray, velocity: np.ndarray, substep: Substep) -> np.ndarray:
        """Where inertia, gravity and wind alone would lead, (V, 3) m."""
        model, h = self.model, substep.h
        self._force[:] = 0.0
        shown, most = model.area_vectors(position), model.mesh.vertex_area
        surface.add_relative_drag(velocity, substep.flow, shown, most, model.drag, model.mass, h, self._force)
        return position + h * velocity + h * h * (self._force / model.mass[:, None] + substep.gravity)

    def bending_viscosity(self, position: np.ndarray, h: float) -> np.ndarray | float:
        """What the bending viscosity takes from the shape at the start of the substep, (V, 3) kg m."""
        material = self.model.material
        if material.bend_damping == 0.0 or material.bend == 0.0:
            return 0.0
        return self.model.bending @ (h * material.bend_damping * position)

    def relax(self, inertial: np.ndarray, viscous: np.ndarray | float, moved: np.ndarray, h: float) -> float:
        """One local and one global step: springs choose their directions, W reconciles them with inertia.

        Returns:
            The farthest that a vertex moved, m.
        """
        model = self.model
        np.multiply(inertial, model.mass[:, None], out=self._right_side)
        self._right_side += viscous
        mesh = model.mesh
        springs.add_rest_lengths(
            moved, mesh.spring_vertex, mesh.spring_rest, model.spring_stiffness, h * h, self._right_side
        )
        self._before[:] = moved
        model.filter.solve(self._right_side, moved)
        return springs.farthest_move(self._before, moved)
