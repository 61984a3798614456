"""What holds the cloth: the forces that the held rows of a system leave over, and the balance of momentum."""

from __future__ import annotations

from cloth_core.kernels import kernel


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
def left_over(mass, gravity, outer, start, end, before, after, damped, free, time, rest):
    """What outer forces do to each vertex beyond its change of momentum, into ``rest`` (V, 3) N (d'Alembert).

    Means over a step of ``time`` s from ``start`` to ``end`` (V, 3) m, in which velocities went from ``before`` to
    ``after`` (V, 3) m/s: weight, the impulses ``outer`` (V, 3) N s, and the damping ``damped`` 1/s of ``free`` (V,)
    vertices, less inertia.
    """
    for v in range(mass.shape[0]):
        share = damped if free[v] else 0.0
        for a in range(3):
            inertia = after[v, a] - before[v, a] + share * (end[v, a] - start[v, a])
            rest[v, a] = mass[v] * (gravity[a] - inertia / time) + outer[v, a] / time


@kernel
def add_wrenches(component, place, about, force, wrench):
    """Add up forces (V, 3) N at ``place`` (V, 3) m by component (V,), with moments ``about`` (C, 3) m: (C, 6)."""
    for v in range(component.shape[0]):
        c = component[v]
        x, y, z = place[v, 0] - about[c, 0], place[v, 1] - about[c, 1], place[v, 2] - about[c, 2]
        fx, fy, fz = force[v, 0], force[v, 1], force[v, 2]
        wrench[c, 0] += fx
        wrench[c, 1] += fy
        wrench[c, 2] += fz
        wrench[c, 3] += y * fz - z * fy
        wrench[c, 4] += z * fx - x * fz
        wrench[c, 5] += x * fy - y * fx
