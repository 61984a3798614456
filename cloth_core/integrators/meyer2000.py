"""The step of Meyer, Debunne, Desbrun and Barr 2000, Fig. 4, with its errors mended.

What differs from the print, and why: pins are eliminated from W (else a hanging cloth sags by half as much
again); gravity and drag are forces and go through the filter with the others (else they balance the springs
at a wrong shape); masses are lumped per vertex, A = M - dt^2 H staying symmetric; the angular correction carries
the inverse inertia (without it the step explodes); drag acts per area; friction limits displacements, since the
velocity it would attenuate is overwritten.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.integrators.model import Model, Substep
from cloth_core.kernels import curvature, surface


class Meyer2000:
    """The paper's integrator: ``substeps`` 1, one product with W, ``stretch_sweeps`` 20."""

    iterations, stretch_sweeps = 1, 20
    restrained = False

    def __init__(self, model: Model, substeps: int) -> None:
        self.model = model
        # Bending viscosity has a constant matrix too: inside W it is stable whatever its size.
        viscous_bending = (1.0 + model.material.bend_damping / model.h) * model.bending
        self._stiffness = (model.stretch + viscous_bending).tocsr()
        self.filter = model.filter_by(self._stiffness, model.h * model.h)
        shape = model.mesh.rest_position.shape
        self._force, self.air_force, self._change = np.empty(shape), np.zeros(shape), np.empty(shape)

    @staticmethod
    def substeps(config: SolverConfig) -> int:
        """Substeps in a step if the configuration leaves the choice."""
        return 1

    def begin(self, history: Mapping[str, np.ndarray]) -> None:
        """The paper's step remembers nothing, but the default one may have left velocities that run ahead."""
        self._ahead = history.get("lag")

    def end(self) -> dict[str, np.ndarray]:
        """Nothing."""
        return {}

    def pull(self, position: np.ndarray, held: np.ndarray) -> np.ndarray:
        """(len(held), 3) N, what the cloth pulled the ``held`` vertices with.

        It is what the rows of the system that stand for them leave over.
        """
        force = self._force[held]
        self.model.add_rows(self._stiffness, held, self._change, -self.model.h, force)
        return force

    def restart(self, vertex: np.ndarray) -> None:
        """Nothing is remembered."""

    def advance(
        self, position: np.ndarray, velocity: np.ndarray, substep: Substep
    ) -> tuple[np.ndarray, np.ndarray, int, float]:
        """Advance (V, 3) ``position`` and ``velocity`` by one step of Fig. 4.

        Returns:
            New position, new velocity, sweeps done, worst excess over the stretch limit in the last sweep.
        """
        model, dt = self.model, substep.h
        if self._ahead is not None:
            velocity, self._ahead = velocity + self._ahead, None
        outer = self.secondary_forces(position, velocity, substep) + model.mass[:, None] * substep.gravity
        force = self.internal_forces(position, velocity, dt) + outer
        moved = position + dt * self.filtered_velocity(force, position, velocity, substep)
        inertial = position + dt * velocity + dt * dt * outer / model.mass[:, None]
        model.balance.correct(position, inertial, moved, substep.held, hanging=False)
        moved[substep.held] = substep.target
        model.contacts.find(position, moved, substep.h)
        sweeps, excess = model.limit_stretch_in_contact(position, moved, substep)
        return moved, model.settle(position, velocity, moved, substep), sweeps, excess

    def internal_forces(self, position: np.ndarray, velocity: np.ndarray, dt: float) -> np.ndarray:
        """Springs, bending, and the artificial viscosity dt H v that implicit integration amounts to, (V, 3) N."""
        mesh, material = self.model.mesh, self.model.material
        self._force[:] = 0.0
        self.model.sheet.add_forces(position, velocity, dt, self._force)
        if self.model.bends:
            lasting = dt + material.bend_damping
            curvature.add_bending_forces(
                position, velocity, mesh.curvature_start, mesh.curvature_vertex, mesh.curvature_weight,
                material.bend, lasting, self._force,
            )  # fmt: skip
        return self._force

    def filtered_velocity(
        self, force: np.ndarray, position: np.ndarray, velocity: np.ndarray, substep: Substep
    ) -> np.ndarray:
        """v + W F dt, with held vertices at the velocity that takes them to their targets, (V, 3) m/s."""
        change = self._change
        change[:] = 0.0
        change[substep.held] = (substep.target - position[substep.held]) / substep.h - velocity[substep.held]
        self.filter.solve(force * substep.h, change)
        return velocity + change

    def secondary_forces(self, position: np.ndarray, velocity: np.ndarray, substep: Substep) -> np.ndarray:
        """Wind, from the flow alone as in section 4.1, and fluids, (V, 3) N."""
        model = self.model
        self.air_force[:] = 0.0
        exposed = model.exposed(position, velocity, substep, self.air_force)
        surface.add_drag_of_flow(substep.flow, *exposed, model.drag, self.air_force)
        return self.air_force
