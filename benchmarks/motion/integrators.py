"""Implicit schemes for x' = v, v' = a(x). Each yields x and v after one step of h after another.

``stage(y, tau)`` solves z = y + tau^2 a(z); a scheme uses one tau, so that one W serves it for good.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import sqrt

import numpy as np

from motion.cloth import Cloth

Motion = Iterator[tuple[np.ndarray, np.ndarray]]
Solve = Callable[[np.ndarray, float], np.ndarray]
Integrator = Callable[[Cloth, float, Solve], Motion]


def implicit_euler(cloth: Cloth, h: float, stage: Solve) -> Motion:
    """First order: x' = x + h v', v' = v + h a(x')."""
    x, v = at_rest(cloth)
    while True:
        z = stage(x + h * v, h)
        x, v = z, (z - x) / h
        yield x, v


def bdf2(cloth: Cloth, h: float, stage: Solve) -> Motion:
    """Second order: the parabola through two old values and the new one has the new slope.

    The value before the start comes from a parabola too: x - h v alone would leave the velocity h a / 2 short for good.
    """
    x, v = at_rest(cloth)
    a = cloth.acceleration(x)
    a[cloth.pins] = 0.0
    x_old, v_old = x - h * v + h * h / 2 * a, v - h * a
    tau = 2 * h / 3
    while True:
        z = stage((4 * x - x_old) / 3 + tau * (4 * v - v_old) / 3, tau)
        x, v, x_old, v_old = z, (3 * z - 4 * x + x_old) / (2 * h), x, v
        yield x, v


def midpoint(cloth: Cloth, h: float, stage: Solve) -> Motion:
    """Second order, symplectic: the middle has the mean velocity, and the forces act there."""
    x, v = at_rest(cloth)
    tau = h / 2
    while True:
        z = stage(x + tau * v, tau)
        x, v = 2 * z - x, 2 * (z - x) / tau - v
        yield x, v


def trapezoidal(cloth: Cloth, h: float, stage: Solve) -> Motion:
    """Second order: the mean of both ends' velocities and of both ends' forces (Newmark 1/4, 1/2)."""
    x, v = at_rest(cloth)
    a = cloth.acceleration(x)
    a[cloth.pins] = 0.0
    tau = h / 2
    while True:
        y = x + h * v + tau * tau * a
        z = stage(y, tau)
        x, v, a = z, (z - x) / tau - v, (z - y) / (tau * tau)
        yield x, v


def sdirk2(cloth: Cloth, h: float, stage: Solve) -> Motion:
    """Second order, L-stable, two stages of the same tau (Alexander 1977): twice the solves of the others."""
    x, v = at_rest(cloth)
    gamma = 1 - 1 / sqrt(2)
    tau, rest = gamma * h, (1 - gamma) * h
    while True:
        first = stage(x + tau * v, tau)
        v_first = (first - x) / tau
        a_first = (v_first - v) / tau
        x_base, v_base = x + rest * v_first, v + rest * a_first
        x = stage(x_base + tau * v_base, tau)
        v = (x - x_base) / tau
        yield x, v


def at_rest(cloth: Cloth) -> tuple[np.ndarray, np.ndarray]:
    """Where the cloth is let go."""
    return cloth.start, np.zeros_like(cloth.start)
