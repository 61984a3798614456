"""Reactions: what the cloth does to all that holds it or that it lies on, as means over a step.

The momentum of a part of the cloth is known, and so is what weight, air and damping do to it. The rest of its change
comes from hands, pins and obstacles (d'Alembert): that gives the whole force upon them, and the whole moment, whatever
carried it there, springs, bending, limit or welds. For one hand in the air nothing is left to ask.

How several share it, is read off what they did: obstacles by what their contacts moved, hands and pins by what the rows
of the linear systems that stand for held vertices leave over, the pull of springs and of bending. Sweeps over the
stretch limit, and threads at their limit that are calmed, work outside of these. What is missing so is shared in
proportion to the force and by leverage: the least change that makes forces and moments balance.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.integrators.model import Model
from cloth_core.kernels import reaction as kernels
from cloth_core.kernels.impulses import SIZE


class Reactions:
    """Adds up what happens to the cloth in a step, substep by substep.

    Args:
        model: the cloth.
        time: s, of a step.
    """

    def __init__(self, model: Model, time: float) -> None:
        self._model, self._time = model, time
        self._outer = np.zeros((len(model.mass), 3))
        self._first = np.unique(model.mesh.component, return_index=True)[1]
        # The share of speed that a substep takes, per displacement in it.
        self._damped = -math.expm1(-model.material.damping * model.h) / model.h

    def begin(self, position: np.ndarray, velocity: np.ndarray, held: np.ndarray) -> None:
        """A step begins at ``position`` (V, 3) m with ``velocity`` (V, 3) m/s, the lag included; ``held`` is sorted."""
        self._position, self._velocity, self._held = position, velocity, held
        self._outer[:] = 0.0
        self._pull, self._substeps = np.zeros((len(held), 3)), 0

    def add(self, air: np.ndarray | None, pull: np.ndarray | None) -> None:
        """Hear of a substep: the force of the ``air`` (V, 3) N, if any, and the cloth's ``pull`` (len(held), 3) N."""
        if air is not None:
            self._outer += air
        if pull is not None:
            self._pull += pull
        self._substeps += 1

    def end(self, position: np.ndarray, velocity: np.ndarray, gravity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the cloth did in the step to what carries it, in the world.

        Upon what holds the held vertices, (len(held), 3) N, and upon the obstacles, (O, 6) N and N m about the origins
        of their frames.

        Args:
            position: (V, 3) m at the end of the step.
            velocity: (V, 3) m/s then, the lag included.
            gravity: (3,) m/s^2.
        """
        model, held, contacts = self._model, self._held, self._model.contacts
        press = contacts.press / self._time
        force = self._pull / self._substeps + contacts.pressed[held] / self._time
        if len(held) or press.any():
            self._outer *= 1.0 / self._substeps
            kernels.balance(
                model.mass, gravity, self._outer, self._position, position, self._velocity, velocity, self._damped,
                self._time, model.mesh.component, self._first, held, force, contacts.origins, press,
            )  # fmt: skip
        return force, press[:, :, :SIZE].sum(axis=1)
