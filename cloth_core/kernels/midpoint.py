"""The implicit midpoint rule, vertex by vertex: the inertial half step and what follows from its middle."""

from __future__ import annotations

from cloth_core.kernels import kernel


@kernel
def predict(position, velocity, lag, acceleration, h, middle):
    """Where inertia and ``acceleration`` (V, 3) m/s^2 lead in half a substep, into ``middle`` (V, 3) m."""
    half = 0.5 * h
    for v in range(position.shape[0]):
        for a in range(3):
            way = velocity[v, a] + lag[v, a] + half * acceleration[v, a]
            middle[v, a] = position[v, a] + half * way


@kernel
def extrapolate(position, velocity, h, lag, middle):
    """Turn the ``middle`` (V, 3) m of a substep into its end, in place, and renew the ``lag`` (V, 3) m/s.

    The lag is the half step by which the velocity of the rule runs ahead of the mean velocity of the substep:
    h / 2 times the mean acceleration.
    """
    for v in range(position.shape[0]):
        for a in range(3):
            way = middle[v, a] - position[v, a]
            lag[v, a] = 2.0 * way / h - velocity[v, a] - lag[v, a]
            middle[v, a] += way


@kernel
def displacement_velocity(start, end, scale, velocity):
    """``scale`` 1/s times the way from ``start`` to ``end`` (V, 3) m, into ``velocity`` (V, 3) m/s."""
    for v in range(start.shape[0]):
        for a in range(3):
            velocity[v, a] = (end[v, a] - start[v, a]) * scale


@kernel
def accelerations(force, mass, gravity, bending, acceleration):
    """force / mass + ``gravity`` (3,) + ``bending`` (V, 3), into ``acceleration`` (V, 3) m/s^2."""
    for v in range(force.shape[0]):
        share = 1.0 / mass[v]
        for a in range(3):
            acceleration[v, a] = force[v, a] * share + gravity[a] + bending[v, a]


@kernel
def add_inertia(mass, inertial, position, right_side):
    """Add mass * (``inertial`` - ``position``) to ``right_side`` (V, 3) kg m."""
    for v in range(mass.shape[0]):
        for a in range(3):
            right_side[v, a] += mass[v] * (inertial[v, a] - position[v, a])
