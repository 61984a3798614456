"""The implicit midpoint rule, vertex by vertex: the inertial half step and what follows from its middle."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel, lane_kernel


@lane_kernel
def predict(position, velocity, lag, force, mass, bending, gravity, h, middle):
    """Where inertia, ``force`` (V, 3) N, ``bending`` (V, 3) m/s^2 and ``gravity`` lead in half a substep (V, 3) m."""
    half = 0.5 * h
    gx, gy, gz = gravity[0], gravity[1], gravity[2]
    for v in range(position.shape[0]):
        share = 1.0 / mass[v]
        ax = force[v, 0] * share + gx + bending[v, 0]
        ay = force[v, 1] * share + gy + bending[v, 1]
        az = force[v, 2] * share + gz + bending[v, 2]
        middle[v, 0] = position[v, 0] + half * (velocity[v, 0] + lag[v, 0] + half * ax)
        middle[v, 1] = position[v, 1] + half * (velocity[v, 1] + lag[v, 1] + half * ay)
        middle[v, 2] = position[v, 2] + half * (velocity[v, 2] + lag[v, 2] + half * az)


@lane_kernel
def extrapolate(position, middle, end):
    """As far again beyond the ``middle`` (V, 3) m of a substep as that is from ``position``, into ``end`` (V, 3) m."""
    for v in range(position.shape[0]):
        for a in range(3):
            end[v, a] = 2.0 * middle[v, a] - position[v, a]


@lane_kernel
def renew_lag(position, velocity, middle, met, h, lag):
    """Renew the ``lag`` (V, 3) m/s after a substep of ``h`` s that began at ``position`` with ``velocity``.

    It is the half step by which the velocity of the rule runs ahead of the mean velocity of the substep: h / 2 times
    the mean acceleration. What obstacles ``met`` (V, 3) m of the substep's way with is an impact, and not part of it.
    """
    for v in range(position.shape[0]):
        for a in range(3):
            way = 2.0 * (middle[v, a] - position[v, a]) - met[v, a]
            lag[v, a] = way / h - velocity[v, a] - lag[v, a]


@lane_kernel
def end_acceleration(way, h, lag):
    """Take from a ``lag`` (V, 3) m/s what obstacles offset of it, having moved the cloth by ``way`` (V, 3) m; in place.

    What rests is not accelerated. More is not taken: an impact ends a motion, and does not turn it round.
    """
    for v in range(lag.shape[0]):
        x, y, z = way[v, 0], way[v, 1], way[v, 2]
        square = x * x + y * y + z * z
        if square > 0.0:
            share = min(max(-h * (lag[v, 0] * x + lag[v, 1] * y + lag[v, 2] * z) / square, 0.0), 1.0) / h
            lag[v, 0], lag[v, 1], lag[v, 2] = lag[v, 0] + share * x, lag[v, 1] + share * y, lag[v, 2] + share * z


@lane_kernel
def bound_lag(gravity, h, most, lag):
    """Bound what a ``lag`` (V, 3) m/s has beyond that of ``gravity``, h / 2 of it, by ``most`` (V,) m/s, in place."""
    x, y, z = 0.5 * h * gravity[0], 0.5 * h * gravity[1], 0.5 * h * gravity[2]
    for v in range(lag.shape[0]):
        a, b, c = lag[v, 0] - x, lag[v, 1] - y, lag[v, 2] - z
        square = a * a + b * b + c * c
        if square > most[v] * most[v]:
            share = most[v] / math.sqrt(square)
            lag[v, 0], lag[v, 1], lag[v, 2] = x + share * a, y + share * b, z + share * c


@lane_kernel
def displacement_velocity(start, end, scale, velocity):
    """``scale`` 1/s times the way from ``start`` to ``end`` (V, 3) m, into ``velocity`` (V, 3) m/s."""
    for v in range(start.shape[0]):
        for a in range(3):
            velocity[v, a] = (end[v, a] - start[v, a]) * scale


@kernel
def add_inertia(mass, inertial, position, right_side):
    """Add mass * (``inertial`` - ``position``) to ``right_side`` (V, 3) kg m."""
    for v in range(mass.shape[0]):
        for a in range(3):
            right_side[v, a] += mass[v] * (inertial[v, a] - position[v, a])


@lane_kernel
def farthest_apart(one, other):
    """m, the most by which a coordinate of ``one`` (V, 3) m differs from that of the ``other``."""
    most = 0.0
    for v in range(one.shape[0]):
        for a in range(3):
            most = max(most, abs(one[v, a] - other[v, a]))
    return most
