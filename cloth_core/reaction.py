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
from cloth_core.report import moment

EVEN = 0.01
"""Of the mean pull, the least share of a held vertex in what is missing: what was not pulled yet may be pulled now."""
TINY = 1e-300
SIZE, FIRST, SECOND = 6, slice(7, 10), slice(10, 19)
"""Where the sum of all forces, and its moments of first and second order, stand in what obstacles press with."""
FLAT = 1e-8
"""Of the largest moment of inertia of what holds, below which it bears no moment: about a point, or a line."""


class Reactions:
    """Adds up what happens to the cloth in a step, substep by substep.

    Args:
        model: the cloth.
        time: s, of a step.
    """

    def __init__(self, model: Model, time: float) -> None:
        self._model, self._time = model, time
        vertices = len(model.mass)
        self._outer, self._rest, self._free = np.zeros((vertices, 3)), np.zeros((vertices, 3)), np.ones(vertices, bool)
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
        held, contacts = self._held, self._model.contacts
        press = contacts.press / self._time
        pressing = press[:, :, SIZE].any(axis=0)
        if len(held) == 0 and not pressing.any():
            return np.zeros((0, 3)), press[:, :, :SIZE].sum(axis=1)
        component, middle = self._model.mesh.component, 0.5 * (self._position + position)
        about = middle[self._first]
        whole = self._balance(position, velocity, gravity, middle, about)
        force = self._pull / self._substeps + self._rest[held] + contacts.pressed[held] / self._time
        for part in np.union1d(component[held], np.flatnonzero(pressing)):
            its = np.flatnonzero(component[held] == part)
            arm, lever = middle[held[its]] - about[part], contacts.origins - about[part]
            change, pressed = _missing(arm, force[its], lever, press[:, part], whole[part])
            force[its] += change
            press[:, part, :SIZE] += pressed
        return force, press[:, :, :SIZE].sum(axis=1)

    def _balance(
        self, position: np.ndarray, velocity: np.ndarray, gravity: np.ndarray, middle: np.ndarray, about: np.ndarray
    ) -> np.ndarray:
        """(C, 6) N and N m ``about`` a point (C, 3) m for each, what the parts do to all that carries them."""
        model, whole = self._model, np.zeros((len(about), 6))
        self._free[:] = True
        self._free[self._held] = False
        self._outer *= model.h
        kernels.left_over(
            model.mass, gravity, self._outer, self._position, position, self._velocity, velocity,
            self._damped, self._free, self._time, self._rest,
        )  # fmt: skip
        kernels.add_wrenches(model.mesh.component, middle, about, self._rest, whole)
        return whole


def _missing(
    arm: np.ndarray, force: np.ndarray, lever: np.ndarray, press: np.ndarray, whole: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What is to be added to forces (K, 3) N and to the wrenches (O, 6) upon obstacles to make up the ``whole`` (6,).

    Each point takes its share, in proportion to the force there, of a + b x place, with the least b that will do.

    Args:
        arm: (K, 3) m, of the held vertices.
        force: (K, 3) N there.
        lever: (O, 3) m, of the origins of obstacles.
        press: (O, 19) upon them, as :func:`~cloth_core.kernels.contact.add_impulses` adds it up.
        whole: N and N m, about the origin of arms and levers.
    """
    size = np.sqrt((force**2).sum(axis=1))
    share = size + EVEN * size.mean() if size.any() else np.ones(len(force))
    weight, first, second = press[:, SIZE], press[:, FIRST], press[:, SECOND].reshape(-1, 3, 3)
    total, center, inertia = _spread(share, arm, weight, first, second, lever)
    lacking = whole - press[:, :SIZE].sum(axis=0)
    lacking[:3] -= force.sum(axis=0)
    lacking[3:] -= moment(lever, press[:, :3]) + moment(arm, force)
    if len(force) == 0:  # what whips about may lose more than what it touches has done to it
        lacking *= min(1.0, total / max(float(np.linalg.norm(lacking[:3])), TINY))
    turning = lacking[3:] - _skew(center) @ lacking[:3]
    spin = np.linalg.pinv(inertia, rcond=FLAT, hermitian=True) @ turning
    turn = _skew(spin)
    base = lacking[:3] / total - turn @ center
    here = base + np.einsum("ab,ob->oa", turn, lever)
    more = np.empty((len(press), SIZE))
    more[:, :3] = weight[:, None] * here + np.einsum("ab,ob->oa", turn, first)
    more[:, 3:] = np.einsum("oab,ob->oa", _skew(first), here) + _inertia(second) @ spin
    return share[:, None] * (base + np.einsum("ab,kb->ka", turn, arm)), more


def _skew(vector: np.ndarray) -> np.ndarray:
    """The matrices (..., 3, 3) that do what the vector product with a ``vector`` (..., 3) does."""
    skew = np.zeros((*vector.shape, 3))
    skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0] = vector[..., 0], vector[..., 1], vector[..., 2]
    return skew - np.swapaxes(skew, -1, -2)


def _spread(
    share: np.ndarray, arm: np.ndarray, weight: np.ndarray, first: np.ndarray, second: np.ndarray, lever: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """All shares together, their centre (3,) m, and their moment of inertia (3, 3) about it.

    Those of single points at ``arm`` (K, 3) m, and those whose sum is ``weight`` (O,) and whose ``first`` (O, 3) and
    ``second`` (O, 3, 3) moments are about the ends of ``lever`` (O, 3) m.
    """
    total = float(share.sum() + weight.sum())
    center = ((share[:, None] * arm).sum(axis=0) + (first + weight[:, None] * lever).sum(axis=0)) / total
    mixed = first[:, :, None] * lever[:, None, :]
    square = (share[:, None, None] * arm[:, :, None] * arm[:, None, :]).sum(axis=0)
    square += (second + mixed + mixed.transpose(0, 2, 1)).sum(axis=0)
    square += (weight[:, None, None] * lever[:, :, None] * lever[:, None, :]).sum(axis=0)
    return total, center, _inertia(square - total * center[:, None] * center)


def _inertia(square: np.ndarray) -> np.ndarray:
    """The moment of inertia (..., 3, 3) of what has these second moments (..., 3, 3)."""
    return np.trace(square, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - square
