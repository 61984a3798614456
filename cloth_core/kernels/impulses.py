"""Impulses of contacts: what obstacles did to the vertices in a substep, and what the cloth pressed upon them with."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, lane_kernel
from cloth_core.kernels.bodies import Bodies
from cloth_core.kernels.contact import Points, add, contact_velocity, where

SIZE, FIRST, SECOND = 6, 7, 10
"""Where the sum of all sizes, and its moments of first and second order, begin in what obstacles are pressed with."""

BLOCK = 256
"""Points of which the press is added up together: they lie in the processor's nearest cache."""


@kernel
def settle(
    velocity, velocity_before, position, h, bodies: Bodies, points: Points, count, inverse_mass, restitution,
    rest_speed, component, pressed, press,
):  # fmt: skip
    """The last of a substep, :func:`~cloth_core.kernels.contact.contact_velocity`, and what has become of it all."""
    contact_velocity(
        velocity, velocity_before, position, h, bodies, points, count, inverse_mass, restitution, rest_speed
    )
    add_impulses(position, h, bodies, points, count, inverse_mass, component, pressed, press)


@kernel
def add_impulses(position, h, bodies: Bodies, points: Points, count, inverse_mass, component, pressed, press):
    """Add the impulses of a substep of ``h`` s: upon vertices to ``pressed`` (V, 3) N s, upon obstacles to ``press``.

    ``press`` (O, C, 19) is by obstacle and by ``component`` (V,) of the cloth: impulse, N s, and its moment, N m s;
    then the sum of all sizes of impulses, and its moments of first and second order, N s m and N s m^2. All moments are
    about the origin of the obstacle's frame. What moved a point moved its free corners alone, but it was pressed upon
    all of them: the share of a held one goes to what holds it.
    """
    corners, corner, weight, yields = points.corners, points.corner, points.weight, points.yields
    body, pushed, shift, origin = points.body, points.pushed, points.shift, bodies.origin
    block, filled, o, c = np.empty((6, BLOCK)), 0, 0, 0
    for p in range(count):
        if pushed[p] <= 0.0:
            continue
        v = corner[p, 0]
        if filled == BLOCK or body[p] != o or component[v] != c:
            _add_press(press[o, c], block, filled)
            filled, o, c = 0, body[p], component[v]
        given = 1.0 / (h * (inverse_mass[v] if corners[p] == 1 else yields[p]))
        fx, fy, fz = given * shift[p, 0], given * shift[p, 1], given * shift[p, 2]
        if corners[p] == 1:
            add(pressed, v, fx, fy, fz)
            x, y, z = position[v, 0], position[v, 1], position[v, 2]
        else:
            for n in range(corners[p]):
                add(pressed, corner[p, n], weight[p, n] * fx, weight[p, n] * fy, weight[p, n] * fz)
            x, y, z = where(position, corners, corner, weight, p)
        block[0, filled], block[1, filled], block[2, filled] = x - origin[o, 0], y - origin[o, 1], z - origin[o, 2]
        block[3, filled], block[4, filled], block[5, filled] = -fx, -fy, -fz
        filled += 1
    if filled > 0:
        _add_press(press[o, c], block, filled)


@lane_kernel
def _add_press(total, block, filled):
    """Add forces, their moments, their sizes, and the moments of these to the ``total`` (19,) of those before."""
    px = py = pz = tx = ty = tz = 0.0
    whole = mx = my = mz = 0.0
    xx = yy = zz = xy = xz = yz = 0.0
    for k in range(filled):
        x, y, z, fx, fy, fz = block[0, k], block[1, k], block[2, k], block[3, k], block[4, k], block[5, k]
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        sx, sy, sz = size * x, size * y, size * z
        px += fx
        py += fy
        pz += fz
        tx += y * fz - z * fy
        ty += z * fx - x * fz
        tz += x * fy - y * fx
        whole += size
        mx += sx
        my += sy
        mz += sz
        xx += sx * x
        yy += sy * y
        zz += sz * z
        xy += sx * y
        xz += sx * z
        yz += sy * z
    second = xx, xy, xz, xy, yy, yz, xz, yz, zz
    for n, number in enumerate((px, py, pz, tx, ty, tz, whole, mx, my, mz, *second)):
        total[n] += number
