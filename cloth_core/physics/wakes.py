"""Wind behind obstacles: who is sheltered, and by how much (paper, 6: behind an obstacle the scarf does not flap).

A model, not a flow computed. Behind a bluff body the air stands still, or moves with the body, in a bubble that is
about one and a half of its widths long (1.6 for a cube on the ground: Martinuzzi and Tropea 1993); from there to six
widths the wind comes back smoothly (the true tail of a wake is longer: it thins as x^(-2/3)). The edge of the shadow
grows as the outer half of the mixing layer beside it, whose thickness is 0.18 of the way (Brown and Roshko 1974).
Nothing is slowed in front of an obstacle or hurried beside it, and a wake does not swing.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Wind
from cloth_core.kernels import wakes as kernels
from cloth_core.obstacles import Obstacle
from cloth_core.physics.contacts import Contacts
from cloth_core.physics.drag import capped


class Wakes:
    """The wakes of the obstacles that a cloth meets.

    Args:
        obstacles: the shapes, in the order of ``contacts``.
        contacts: knows where they are.
        config: step, and the cap of the wind.
    """

    def __init__(self, obstacles: Iterable[Obstacle], contacts: Contacts, config: SolverConfig) -> None:
        self._contacts, self._config = contacts, config
        solid = list(obstacles)
        self._half = np.array([shape.half_extents for shape in solid], dtype=float).reshape(len(solid), 3)
        self._endless = np.flatnonzero(np.isinf(self._half[:, 0]))

    def shelter(self, position: np.ndarray, wind: Wind, flow: np.ndarray) -> None:
        """Slow down the ``flow`` (V, 3) m/s of a ``wind`` behind obstacles, in place.

        To be called when the contacts have begun the step. What counts is the wind relative to an obstacle: one that
        moves drags the air behind it along.
        """
        if not len(self._half) or (self._contacts.still and not any(wind.velocity)):
            return
        mean = np.array(capped(wind.velocity, self._config.max_wind_speed)[0])
        drift = self._contacts.way / self._config.dt
        bodies = self._contacts.bodies
        for number in self._endless:
            normal = bodies.rotation[number, :, 2]
            out = float((mean - drift[number]) @ normal)
            if out > 0.0:  # no wind comes out of the ground: it turns along it
                mean -= out * normal
                flow -= out * normal
        kernels.shelter(position, bodies, self._half, drift, mean, flow)
