"""What both integrators share: the precomputed cloth, the inputs of a substep, and how a substep ends."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.config import SolverConfig
from cloth_core.kernels import midpoint, reaction, surface
from cloth_core.kernels.immersion import Regions
from cloth_core.linear import Assembly, ImplicitFilter, Plans
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.bearing import Bearing
from cloth_core.physics.contacts import Contacts
from cloth_core.physics.immersion import Immersion
from cloth_core.physics.membrane import Membrane
from cloth_core.physics.momentum import MomentumBalance
from cloth_core.physics.self_contacts import SelfContacts
from cloth_core.physics.springs import Springs
from cloth_core.physics.stretch_limit import StretchLimit
from cloth_core.physics.thread_limit import ThreadLimit
from cloth_core.physics.wakes import Wakes

NEGLIGIBLE_EXCESS, NEGLIGIBLE_PUSH = 1e-5, 1e-5
"""A sweep that corrects less has nothing left to do: a ratio over the stretch limit, and m below a surface."""


@dataclass(frozen=True)
class Substep:
    """What one substep is given.

    Args:
        h: s.
        held: vertices that are pinned or grasped, sorted.
        target: (len(held), 3) m, where they shall be at the end.
        number: of the substep within its step, from 0.
        flow: (V, 3) m/s, velocity of the air.
        gravity: (3,) m/s^2.
        sweeps: most passes over stretch limit and contacts.
        fluids: what the cloth may be immersed in.
    """

    h: float
    number: int
    held: np.ndarray
    target: np.ndarray
    flow: np.ndarray
    gravity: np.ndarray
    sweeps: int
    fluids: Regions | None = None


class Model:
    """A mesh of a material, with everything that is precomputed for one substep length."""

    def __init__(
        self,
        mesh: ClothMesh,
        material: Material,
        config: SolverConfig,
        obstacles: Mapping[str, Obstacle],
        *,
        h: float,
        pinned: np.ndarray,
        assembly: Assembly | None = None,
        plans: Plans | None = None,
    ) -> None:
        self.mesh, self.material, self.config = mesh, material, config
        self.mass = mesh.vertex_mass(material)
        assembly = assembly or Assembly(mesh)
        self.stretch, self.bending = assembly.stretch(material), assembly.bending(material)
        self.bends = material.bend > 0.0 and len(mesh.curvature_vertex) > 0
        self.h = h
        self._pinned, self._filters = pinned, []
        self._plans = plans or Plans()
        self.balance = MomentumBalance(mesh, self.mass)
        woven = mesh.is_membrane(material)
        self.sheet = (Membrane if woven else Springs)(mesh, material)
        self.limit = (ThreadLimit if woven else StretchLimit)(mesh, material, self.mass)
        self.contacts = Contacts(obstacles, mesh, material, self.mass, config)
        self.self_contacts = SelfContacts(mesh, material, config, self.mass) if config.self_collision else None
        self.wakes = Wakes(obstacles, self.contacts, config)
        self.immersion = Immersion(mesh, material, self.mass)
        self.drag = 0.5 * config.air_density * material.drag
        self._bearing: Bearing | None = None
        self._area_vector = np.empty((mesh.vertex_count, 3))

    def filter_by(self, stiffness: csr_matrix, scale: float) -> ImplicitFilter:
        """(M + scale K)^-1 for a constant ``stiffness`` (V, V) N/m; it follows what is held from now on."""
        made = ImplicitFilter(
            self.mass, stiffness, scale,
            place=self.mesh.rest_position, pinned=self._pinned, dense_limit=self.config.dense_limit,
            plans=self._plans,
        )  # fmt: skip
        self._filters.append(made)
        return made

    def bear_by(self, spread: ImplicitFilter) -> Bearing:
        """What obstacles bear, spread over the cloth by one of the filters; it follows what is held from now on."""
        stiffness = 0.25 * self.h**2 * self.stretch.diagonal()
        self._bearing = Bearing(self.contacts, self.mesh, self.mass, stiffness, spread.solve)
        return self._bearing

    @property
    def representation(self) -> str:
        """How W is stored."""
        return self._filters[0].representation

    @property
    def precisions(self) -> frozenset[np.dtype]:
        """Of the factors that W is made of; none where all vertices are pinned."""
        return frozenset(made.precision for made in self._filters if made.precision is not None)

    def hold(self, grasped: np.ndarray, held: np.ndarray) -> None:
        """From now on ``grasped`` vertices are held beside the pinned ones; ``held`` is both."""
        self.grasped = grasped
        for held_filter in self._filters:
            held_filter.hold(grasped)
        self.limit.hold(held)
        self.contacts.hold(held)
        if self._bearing is not None:
            self._bearing.hold(held)
        if self.self_contacts is not None:
            self.self_contacts.hold(held)

    @staticmethod
    def add_rows(matrix: csr_matrix, rows: np.ndarray, x: np.ndarray, factor: float, total: np.ndarray) -> None:
        """Add ``factor`` times the ``rows`` (K,) of a ``matrix`` (V, V) times ``x`` (V, 3) to ``total`` (K, 3)."""
        reaction.add_rows(matrix.indptr, matrix.indices, matrix.data, rows, x, factor, total)

    def exposed(
        self, position: np.ndarray, velocity: np.ndarray, substep: Substep, force: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the cloth shows to the air: area vectors (V, 3) m^2 and rest areas (V,) m^2, valid until the next call.

        The force of fluids on what is wet instead is added to ``force`` (V, 3) N.
        """
        surface.area_vectors(position, self.mesh.triangles, self._area_vector)
        if substep.fluids is None:
            return self._area_vector, self.mesh.vertex_area
        dry = self.immersion.add_forces(
            position, velocity, substep.gravity, substep.h, substep.fluids, self._area_vector, force
        )
        return self._area_vector, dry

    def limit_stretch_in_contact(
        self, start: np.ndarray, position: np.ndarray, substep: Substep, usual: int = 0, tolerated: float = 0.0
    ) -> tuple[int, float]:
        """The loop at the end of Fig. 4: shorten springs, bring back onto surfaces with friction, repeat.

        Contacts stand inside the loop so that neither undoes the other.

        Args:
            start: (V, 3) m, where the substep began.
            position: (V, 3) m, corrected in place.
            substep: allows so many sweeps.
            usual: sweeps after which an excess that is ``tolerated`` (a ratio) is left for the next substep.
            tolerated: see ``usual``.

        Returns:
            Sweeps done, and the worst excess over the stretch limit met in the last one (a ratio).
        """
        layers = self.self_contacts
        if layers is not None:
            layers.find(start, position, substep.h, substep.number)
        sweep, excess = 0, 0.0
        while sweep < substep.sweeps:
            excess = self.limit.sweep(position, sweep)
            pushed = self.contacts.push_out(position)
            self.contacts.apply_friction(start, position)
            if layers is not None:
                pushed = max(pushed, layers.sweep(start, position, sweep))
            sweep += 1
            enough = max(tolerated, NEGLIGIBLE_EXCESS) if sweep >= usual else NEGLIGIBLE_EXCESS
            if excess <= enough and pushed < NEGLIGIBLE_PUSH:
                break
        if layers is not None:
            layers.keep_apart(start, position)
        return sweep, excess

    def settle(self, start: np.ndarray, velocity: np.ndarray, position: np.ndarray, substep: Substep) -> np.ndarray:
        """(V, 3) m/s, the velocity that a substep ends with: its displacement over h, damped, with impacts."""
        settled = np.empty_like(velocity)
        scale = math.exp(-self.material.damping * substep.h) / substep.h
        midpoint.displacement_velocity(start, position, scale, settled)
        settled[substep.held] = (position[substep.held] - start[substep.held]) / substep.h
        rest_speed = 3.0 * substep.h * float(np.linalg.norm(substep.gravity))
        self.contacts.settle_velocity(settled, velocity, position, substep.h, rest_speed)
        if self.self_contacts is not None:
            self.self_contacts.settle_velocity(settled, start)
        return settled
