"""What holds the cloth: the forces that the held rows of a system leave over, and the balance of momentum."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import inlined_kernel, kernel
from cloth_core.kernels.leverage import add_wrench, make_up


@kernel
def add_rows(indptr, indices, data, rows, x, factor, total):
    """Add ``factor`` times the ``rows`` (K,) of a sparse matrix times ``x`` (V, 3) to ``total`` (K, 3)."""
    for k in range(rows.shape[0]):
        for p in range(indptr[rows[k]], indptr[rows[k] + 1]):
            j = indices[p]
            share = factor * data[p]
            total[k, 0] += share * x[j, 0]
            total[k, 1] += share * x[j, 1]
            total[k, 2] += share * x[j, 2]


@kernel
def balance(
    mass, gravity, outer, start, end, before, after, damped, time, component, first, held, force, origin, press
):
    """Complete ``force`` (K, 3) N and ``press`` (O, C, 19) to all that carries each component of the cloth in a step.

    What the rest of its row says is added to the force of each vertex of ``held`` (K,); then what the law of momentum
    finds missing. Of component (V,) and moments see :func:`left_over`, of the press on obstacles, whose frames are at
    ``origin`` (O, 3) m, :func:`~cloth_core.kernels.leverage.make_up`. ``first`` (C,) is a vertex of each component.
    """
    components, count = first.shape[0], held.shape[0]
    about, whole = np.empty((components, 3)), np.zeros((components, 6))
    part, arm, lever = np.empty(count, np.int64), np.empty((count, 3)), np.empty_like(origin)
    for c in range(components):
        about[c, 0], about[c, 1], about[c, 2] = middle(start, end, first[c])
    left_over(mass, gravity, outer, start, end, before, after, damped, time, component, about, held, force, whole)
    for k in range(count):
        c = part[k] = component[held[k]]
        x, y, z = middle(start, end, held[k])
        arm[k, 0], arm[k, 1], arm[k, 2] = x - about[c, 0], y - about[c, 1], z - about[c, 2]
    for c in range(components):
        for o in range(origin.shape[0]):
            for a in range(3):
                lever[o, a] = origin[o, a] - about[c, a]
        make_up(c, whole, part, arm, lever, force, press)


@inlined_kernel
def middle(start, end, v):
    """Of the way of vertex ``v``."""
    return 0.5 * (start[v, 0] + end[v, 0]), 0.5 * (start[v, 1] + end[v, 1]), 0.5 * (start[v, 2] + end[v, 2])


@kernel
def left_over(mass, gravity, outer, start, end, before, after, damped, time, component, about, held, force, whole):
    """What outer forces do to each vertex beyond its change of momentum (d'Alembert).

    Added up by ``component`` (V,) to the forces and moments ``about`` (C, 3) m of the ``whole`` (C, 6), those of the
    vertices in ``held`` (K,), sorted, to ``force`` (K, 3) N, too. Means over a step of ``time`` s from ``start`` to
    ``end`` (V, 3) m, in which velocities went from ``before`` to ``after`` (V, 3) m/s: weight, the ``outer`` forces
    (V, 3) N, and the damping ``damped`` 1/s of what is not held, less inertia.
    """
    often, k = 1.0 / time, 0
    gx, gy, gz = gravity[0], gravity[1], gravity[2]
    for v in range(mass.shape[0]):
        fixed = k < held.shape[0] and held[k] == v
        share = 0.0 if fixed else damped
        ax = after[v, 0] - before[v, 0] + share * (end[v, 0] - start[v, 0])
        ay = after[v, 1] - before[v, 1] + share * (end[v, 1] - start[v, 1])
        az = after[v, 2] - before[v, 2] + share * (end[v, 2] - start[v, 2])
        fx = mass[v] * (gx - often * ax) + outer[v, 0]
        fy = mass[v] * (gy - often * ay) + outer[v, 1]
        fz = mass[v] * (gz - often * az) + outer[v, 2]
        if fixed:
            force[k, 0] += fx
            force[k, 1] += fy
            force[k, 2] += fz
            k += 1
        c = component[v]
        x, y, z = middle(start, end, v)
        add_wrench(whole, c, 1.0, x - about[c, 0], y - about[c, 1], z - about[c, 2], fx, fy, fz)
