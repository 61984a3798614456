"""A cloth left alone loses energy: an observer of what it has, and a brake where the numbers add to it.

Contacts and the stretch limit correct positions after W has spread the forces: springs were pulled as if their ends
had gone where the corrections did not let them go. That works on the motion, and in what comes to rest slowly it may
feed as much as damping takes: a limit cycle, which halving the substep ends. So, as in the control of haptic displays
(Hannaford and Ryu 2002, "Time-domain passivity control of haptic interfaces"), the energy is observed, and what it has
too much of is taken out of the motion.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.integrators.model import Model
from cloth_core.kernels import bending

SLOW = 10.0
"""Substeps of free fall, whose speed the cloth must stay below, root mean square: what moves faster has more energy
than corrections feed, and that of an accurate step oscillates about the true one."""


class Passivity:
    """Watches over one step after the other; it remembers nothing from step to step.

    Args:
        model: the cloth.
        time: s, of a step.
    """

    def __init__(self, model: Model, time: float) -> None:
        self._model, self._mass = model, model.mass
        self._damped = -math.expm1(-2.0 * model.material.damping * time)

    def begin(
        self,
        position: np.ndarray,
        velocity: np.ndarray,
        lag: np.ndarray,
        flow: np.ndarray,
        gravity: np.ndarray,
        *,
        alone: bool = True,
    ) -> None:
        """Take in the beginning of a step: (V, 3) m, m/s, m/s; ``flow`` (V, 3) m/s, gravity (3,) m/s^2.

        The arrays are kept, and must stay what they are until the end. A cloth that is not ``alone`` with these may
        gain energy.
        """
        speed = SLOW * self._model.h * float(np.linalg.norm(gravity))
        self._slow = 0.5 * float(self._mass.sum()) * speed * speed
        self._start, self._velocity, self._lag, self._gravity = position, velocity, lag, gravity
        self._kinetic = self.kinetic(velocity)
        self._watched = alone and self._kinetic < self._slow and self._model.contacts.still and not flow.any()

    def end(self, position: np.ndarray, velocity: np.ndarray, lag: np.ndarray, held: np.ndarray) -> None:
        """Slow down ``velocity`` and ``lag`` (V, 3) m/s in place if less energy is gone than damping takes.

        Free parts keep their momenta. Nothing is done where hands moved what is ``held``, or the cloth was fast.
        """
        kinetic = self.kinetic(velocity)
        if not self._watched or kinetic > self._slow or (position[held] != self._start[held]).any():
            return
        taken = self._damped * min(kinetic, self._kinetic)
        before = self.energy(self._start, self._velocity + self._lag, self._gravity)
        gain = self.energy(position, velocity + lag, self._gravity) - before + taken
        if not gain > 0.0:
            return
        inner = [motion - self._rigid(position, motion, held) for motion in (velocity, lag)]
        available = self.kinetic(inner[0] + inner[1])
        left = math.sqrt(1.0 - gain / available) if gain < available else 0.0
        velocity -= (1.0 - left) * inner[0]
        lag -= (1.0 - left) * inner[1]

    def energy(self, position: np.ndarray, velocity: np.ndarray, gravity: np.ndarray) -> float:
        """J: kinetic, of weight, of stretching and of bending."""
        model, matrix = self._model, self._model.bending
        bent = bending.energy(matrix.indptr, matrix.indices, matrix.data, position) if model.bends else 0.0
        weight = -float(np.einsum("v,va,a->", self._mass, position, gravity))
        return self.kinetic(velocity) + weight + model.sheet.energy(position) + bent

    def kinetic(self, velocity: np.ndarray) -> float:
        """J, of a (V, 3) m/s."""
        # No product of BLAS: how that adds up depends on the number of its threads.
        return 0.5 * float(np.einsum("v,va,va->", self._mass, velocity, velocity))

    def _rigid(self, position: np.ndarray, motion: np.ndarray, held: np.ndarray) -> np.ndarray:
        """The rigid part of a ``motion`` of free components; none of others."""
        rigid = np.zeros_like(motion)
        self._model.balance.correct(position, motion, rigid, held, hanging=False)
        return rigid
