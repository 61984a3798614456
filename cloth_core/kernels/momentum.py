"""Balancing the momentum that a constant W loses (paper, 3.2)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import kernel


@kernel
def first_moments(position, error, mass, component, chosen, count):
    """Mass (C,), centre of mass (C, 3) and momentum error (C, 3) of the components that are ``chosen`` (C,)."""
    total = np.zeros(count)
    center = np.zeros((count, 3))
    drift = np.zeros((count, 3))
    for v in range(position.shape[0]):
        c = component[v]
        if chosen[c]:
            total[c] += mass[v]
            for a in range(3):
                center[c, a] += mass[v] * position[v, a]
                drift[c, a] += mass[v] * error[v, a]
    for c in range(count):
        if total[c] > 0.0:
            for a in range(3):
                center[c, a] /= total[c]
    return total, center, drift


@kernel
def second_moments(position, error, mass, component, chosen, center):
    """Per component: inertia (C, 3, 3) kg m^2 and angular error (C, 3) kg m^2 about the centre of mass."""
    count = center.shape[0]
    inertia = np.zeros((count, 3, 3))
    twist = np.zeros((count, 3))
    for v in range(position.shape[0]):
        c = component[v]
        if chosen[c]:
            m = mass[v]
            x = position[v, 0] - center[c, 0]
            y = position[v, 1] - center[c, 1]
            z = position[v, 2] - center[c, 2]
            inertia[c, 0, 0] += m * (y * y + z * z)
            inertia[c, 1, 1] += m * (x * x + z * z)
            inertia[c, 2, 2] += m * (x * x + y * y)
            inertia[c, 0, 1] -= m * x * y
            inertia[c, 0, 2] -= m * x * z
            inertia[c, 1, 2] -= m * y * z
            twist[c, 0] += m * (y * error[v, 2] - z * error[v, 1])
            twist[c, 1] += m * (z * error[v, 0] - x * error[v, 2])
            twist[c, 2] += m * (x * error[v, 1] - y * error[v, 0])
    for c in range(count):
        inertia[c, 1, 0] = inertia[c, 0, 1]
        inertia[c, 2, 0] = inertia[c, 0, 2]
        inertia[c, 2, 1] = inertia[c, 1, 2]
    return inertia, twist


@kernel
def add_rigid_displacement(position, center, shift, turn, component, chosen, moved):
    """Add ``shift + turn x (position - center)`` of each chosen component to ``moved`` (V, 3) m."""
    for v in range(position.shape[0]):
        c = component[v]
        if chosen[c]:
            x = position[v, 0] - center[c, 0]
            y = position[v, 1] - center[c, 1]
            z = position[v, 2] - center[c, 2]
            moved[v, 0] += shift[c, 0] + turn[c, 1] * z - turn[c, 2] * y
            moved[v, 1] += shift[c, 1] + turn[c, 2] * x - turn[c, 0] * z
            moved[v, 2] += shift[c, 2] + turn[c, 0] * y - turn[c, 1] * x
