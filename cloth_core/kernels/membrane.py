"""The sheet as triangles of constant strain: gauges in four directions, and the stretch limit of warp and weft.

A triangle's deformation gradient has two columns, what a metre of warp and a metre of weft have become: sums over
its corners of ``slope`` (T, 3, 2) 1/m times position. A gauge of direction d reads the length of F d.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from cloth_core.kernels import kernel, shared_kernel
from cloth_core.kernels.shares import add_shares
from cloth_core.kernels.springs import BARELY
from cloth_core.kernels.tensors import add_square

WARP, WEFT = np.int64(0), np.int64(1)
"""Columns of a gradient. Plain 0 and 1 are types of their own to numba, and :func:`thread` was compiled for each."""


@kernel
def thread(values, triangles, slope, t, k):
    """Column ``k`` of the gradient of ``values`` (V, 3) over triangle ``t``: x, y and z."""
    h, i, j = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    # The share of one corner follows from the others: they add up to one everywhere.
    p, q = slope[t, 1, k], slope[t, 2, k]
    x = p * (values[i, 0] - values[h, 0]) + q * (values[j, 0] - values[h, 0])
    y = p * (values[i, 1] - values[h, 1]) + q * (values[j, 1] - values[h, 1])
    z = p * (values[i, 2] - values[h, 2]) + q * (values[j, 2] - values[h, 2])
    return x, y, z


@kernel
def add_membrane_forces(
    position, velocity, triangles, slope, area, direction, modulus, viscosity_time, force
):  # fmt: skip
    """Add the forces of all gauges to ``force`` (V, 3) N, with the paper's viscosity: modulus * dt * rate of F d.

    ``area`` (T,) m^2, ``direction`` (D, 2), ``modulus`` (D,) N/m, ``viscosity_time`` s.
    """
    stretched = np.empty((2, 3))
    rate = np.empty((2, 3))
    pull = np.empty((2, 3))
    for t in range(triangles.shape[0]):
        for k in range(2):
            stretched[k, 0], stretched[k, 1], stretched[k, 2] = thread(position, triangles, slope, t, k)
            rate[k, 0], rate[k, 1], rate[k, 2] = thread(velocity, triangles, slope, t, k)
        pull[:] = 0.0
        for d in range(direction.shape[0]):
            p, q = direction[d, 0], direction[d, 1]
            square = 0.0
            for a in range(3):
                square += (p * stretched[0, a] + q * stretched[1, a]) ** 2
            share = 1.0 - 1.0 / math.sqrt(square) if square > 0.0 else 0.0
            stiffness = area[t] * modulus[d]
            for a in range(3):
                along = p * stretched[0, a] + q * stretched[1, a]
                drag = viscosity_time * (p * rate[0, a] + q * rate[1, a])
                pull[0, a] += stiffness * p * (share * along + drag)
                pull[1, a] += stiffness * q * (share * along + drag)
        for n in range(3):
            v = triangles[t, n]
            for a in range(3):
                force[v, a] -= slope[t, n, 0] * pull[0, a] + slope[t, n, 1] * pull[1, a]


@kernel
def energy(position, triangles, slope, area, direction, modulus):
    """J that the gauges store at ``position`` (V, 3) m."""
    total = 0.0
    for t in range(triangles.shape[0]):
        ux, uy, uz = thread(position, triangles, slope, t, WARP)
        vx, vy, vz = thread(position, triangles, slope, t, WEFT)
        for d in range(direction.shape[0]):
            p, q = direction[d, 0], direction[d, 1]
            length = math.sqrt((p * ux + q * vx) ** 2 + (p * uy + q * vy) ** 2 + (p * uz + q * vz) ** 2)
            total += 0.5 * area[t] * modulus[d] * (length - 1.0) ** 2
    return total


@shared_kernel
def add_membrane_impulses(
    position, start, triangles, slope, area, direction, modulus, tension, viscosity, scale, right_side, apart
):
    """Add ``scale`` s^2 times the force of every gauge to ``right_side`` (V, 3) kg m.

    A gauge of stiffness area * modulus pulls with stiffness * (length - 1), plus the ``tension`` (T, 2) J of its
    stretch limit if it is the first (warp) or second (weft), plus stiffness * ``viscosity`` times what it lengthened
    since ``start`` along its own direction: a rigid rotation is not damped. Triangles go in P + 1 shares, of which all
    but the first collect in ``apart`` (P, V, 3).
    """
    shares = apart.shape[0] + 1
    count = triangles.shape[0]
    for n in prange(shares):
        total = right_side
        if n > 0:
            total = apart[n - 1]
            total[:] = 0.0
        _add_impulses(
            n * count // shares, (n + 1) * count // shares,
            position, start, triangles, slope, area, direction, modulus, tension, viscosity, scale, total,
        )  # fmt: skip
    add_shares(apart, right_side)


@kernel
def _add_impulses(
    begin, end, position, start, triangles, slope, area, direction, modulus, tension, viscosity, scale, right_side
):
    """The triangles of a share."""
    for t in range(begin, end):
        ux, uy, uz = thread(position, triangles, slope, t, WARP)
        vx, vy, vz = thread(position, triangles, slope, t, WEFT)
        ax, ay, az = thread(start, triangles, slope, t, WARP)
        bx, by, bz = thread(start, triangles, slope, t, WEFT)
        ax, ay, az = ux - ax, uy - ay, uz - az
        bx, by, bz = vx - bx, vy - by, vz - bz
        warp_x = warp_y = warp_z = 0.0
        weft_x = weft_y = weft_z = 0.0
        for d in range(direction.shape[0]):
            p, q = direction[d, 0], direction[d, 1]
            ex, ey, ez = p * ux + q * vx, p * uy + q * vy, p * uz + q * vz
            square = ex * ex + ey * ey + ez * ez
            if square == 0.0:
                continue
            length = math.sqrt(square)
            gain = ex * (p * ax + q * bx) + ey * (p * ay + q * by) + ez * (p * az + q * bz)
            stiffness = area[t] * modulus[d]
            limit = tension[t, d] if d < 2 else 0.0
            c = scale * ((stiffness * (length - 1.0) + limit) / length + stiffness * viscosity * gain / square)
            warp_x += c * p * ex
            warp_y += c * p * ey
            warp_z += c * p * ez
            weft_x += c * q * ex
            weft_y += c * q * ey
            weft_z += c * q * ez
        for n in range(3):
            v = triangles[t, n]
            p, q = slope[t, n, 0], slope[t, n, 1]
            right_side[v, 0] -= p * warp_x + q * weft_x
            right_side[v, 1] -= p * warp_y + q * weft_y
            right_side[v, 2] -= p * warp_z + q * weft_z


@kernel
def add_resistance(position, triangles, slope, area, direction, modulus, tension, scale, along, across):
    """Add what gauges resist a move of each vertex with: ``along`` (V, 6) kg, tensors, and ``across`` (V,) kg.

    ``scale`` s^2 times their stiffness in their own directions, and times what their force makes stiff across them:
    three times that, so that it is enough whatever the other two corners do. One that is pressed counts as if it
    pulled, for what buckles would go any way at once. ``modulus`` and ``tension`` as in :func:`add_membrane_impulses`.
    """
    for t in range(triangles.shape[0]):
        ux, uy, uz = thread(position, triangles, slope, t, WARP)
        vx, vy, vz = thread(position, triangles, slope, t, WEFT)
        for d in range(direction.shape[0]):
            p, q = direction[d, 0], direction[d, 1]
            x, y, z = p * ux + q * vx, p * uy + q * vy, p * uz + q * vz
            square = x * x + y * y + z * z
            if square == 0.0:
                continue
            length, stiffness = math.sqrt(square), area[t] * max(modulus[d], 0.0)
            limit = tension[t, d] if d < 2 else 0.0
            taut = 3.0 * scale * abs(stiffness * (length - 1.0) + limit) / length
            for n in range(3):
                v, reading = triangles[t, n], p * slope[t, n, 0] + q * slope[t, n, 1]
                add_square(along, v, scale * stiffness * reading * reading / square, x, y, z)
                across[v] += taut * reading * reading


@kernel
def find_taut_threads(position, triangles, slope, shortest, tension, taut):
    """List the threads, 2 t for the warp and 2 t + 1 for the weft of triangle t, that are near their limit.

    Those are longer than ``shortest``, a ratio, or under ``tension`` (T, 2) J. Returns how many there are; they stand
    at the beginning of ``taut`` (2 T,).
    """
    count = 0
    for t in range(triangles.shape[0]):
        for k in range(2):
            x, y, z = thread(position, triangles, slope, t, k)
            if x * x + y * y + z * z > shortest * shortest or tension[t, k] > 0.0:
                taut[count] = 2 * t + k
                count += 1
    return count


@kernel
def carry_thread_limit(start, position, taut, triangles, slope, longest, stiffness, kept, yielding, steady, tension):
    """Let the ``taut`` threads carry by ``tension`` (T, 2) J what keeps them at ``longest``, a ratio.

    As ``springs.carry_limit``, with ``stiffness`` (T, 2) J; never more than that, the pull at twice the length.
    """
    for n in range(taut.shape[0]):
        t, k = taut[n] // 2, taut[n] % 2
        x, y, z = thread(position, triangles, slope, t, k)
        square = x * x + y * y + z * z
        if square > longest * longest or tension[t, k] > 0.0:
            length = math.sqrt(square)
            p, q, r = thread(start, triangles, slope, t, k)
            shortened = max(0.0, math.sqrt(p * p + q * q + r * r) - length - steady * longest)
            carried = kept * tension[t, k] + stiffness[t, k] * (length - longest - yielding * shortened)
            tension[t, k] = min(max(carried, 0.0), stiffness[t, k])


@kernel
def shorten_threads(position, taut, triangles, slope, longest, inverse_mass, backward):
    """One pass over those of the ``taut`` threads that are longer than ``longest``, a ratio, maybe ``backward``.

    As ``springs.shorten_springs``: corners move along the thread so that their centre of gravity stays; one whose
    ``inverse_mass`` is zero stays. Returns the largest excess met, as a share of ``longest``.
    """
    count = taut.shape[0]
    worst = 0.0
    for n in range(count):
        number = taut[count - 1 - n] if backward else taut[n]
        t, k = number // 2, number % 2
        x, y, z = thread(position, triangles, slope, t, k)
        square = x * x + y * y + z * z
        if square <= longest * longest:
            continue
        share = 0.0
        for m in range(3):
            share += slope[t, m, k] ** 2 * inverse_mass[triangles[t, m]]
        if share == 0.0:
            continue
        length = math.sqrt(square)
        excess = length - longest
        worst = max(worst, excess / longest)
        c = excess / (length * share)
        for m in range(3):
            v = triangles[t, m]
            move = c * slope[t, m, k] * inverse_mass[v]
            position[v, 0] -= move * x
            position[v, 1] -= move * y
            position[v, 2] -= move * z
    return worst


@kernel
def vertex_thread_strain(position, triangles, slope, strain):
    """Largest strain (length - 1) of warp and weft in the triangles at each vertex, into ``strain`` (V,)."""
    strain[:] = -np.inf
    for t in range(triangles.shape[0]):
        for k in range(2):
            x, y, z = thread(position, triangles, slope, t, k)
            e = math.sqrt(x * x + y * y + z * z) - 1.0
            for n in range(3):
                v = triangles[t, n]
                strain[v] = max(strain[v], e)


@kernel
def calm_overlong_threads(position, velocity, lag, taut, triangles, slope, longest, inverse_mass, rate):
    """Slow down those of the ``taut`` threads that are overlong and shorten by more than ``rate`` 1/s of their length.

    As ``springs.calm_overlong``, by impulses of the corners along the thread.
    """
    for n in range(taut.shape[0]):
        t, k = taut[n] // 2, taut[n] % 2
        x, y, z = thread(position, triangles, slope, t, k)
        square = x * x + y * y + z * z
        share = 0.0
        for m in range(3):
            share += slope[t, m, k] ** 2 * inverse_mass[triangles[t, m]]
        if square <= BARELY * longest * longest or share == 0.0:
            continue
        for m in range(3):
            for a in range(3):
                lag[triangles[t, m], a] = 0.0
        u, v, w = thread(velocity, triangles, slope, t, k)
        closing = -(x * u + y * v + z * w) / square
        if closing > rate:
            c = (closing - rate) / share
            for m in range(3):
                corner = triangles[t, m]
                change = c * slope[t, m, k] * inverse_mass[corner]
                velocity[corner, 0] += change * x
                velocity[corner, 1] += change * y
                velocity[corner, 2] += change * z
