"""Forces and moments that are known as a whole, and how those who bear them share what is missing of it.

Of the press upon obstacles (O, C, 19) :func:`~cloth_core.kernels.impulses.add_impulses` says what is where.
"""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import inlined_kernel, kernel
from cloth_core.kernels.impulses import FIRST, SECOND, SIZE

EVEN = 0.01
"""Of the mean pull, the least share of a held vertex in what is missing: what was not pulled yet may be pulled now."""
FLAT = 1e-8
"""Of the largest moment of inertia of what holds, below which it bears no moment: about a point, or a line."""
ROUNDING = 1e-13
"""Of the second moments that moments of inertia are differences of: what is less may be no more than rounding."""
TINY = 1e-300


@kernel
def make_up(c, whole, part, arm, lever, force, press):
    """Add what component ``c`` lacks of its ``whole`` (C, 6) N and N m to forces (K, 3) N and to the ``press``.

    Each point takes its share, in proportion to the force there, of a + b x place, with the least b that will do.

    Args:
        c: the component.
        whole: forces and their moments, about the origin of arms and levers.
        part: (K,) the components of the held vertices; others than ``c`` are left alone.
        arm: (K, 3) m, of the held vertices.
        lever: (O, 3) m, of the origins of obstacles.
        force: (K, 3) N at the held vertices.
        press: (O, C, 19) upon the obstacles, moments about their origins; of it forces and moments are made up.
    """
    share = shares(c, part, force)
    moment = spread(c, share, arm, lever, press)
    total = moment[0]
    if total == 0.0:
        return
    lx, ly, lz, tx, ty, tz = lacking(c, whole, share, arm, lever, force, press)
    if not share.any():  # what whips about may lose more than what it touches has done to it
        part_of = min(1.0, total / max(math.sqrt(lx * lx + ly * ly + lz * lz), TINY))
        lx, ly, lz, tx, ty, tz = part_of * lx, part_of * ly, part_of * lz, part_of * tx, part_of * ty, part_of * tz
    cx, cy, cz = moment[1] / total, moment[2] / total, moment[3] / total
    x, y, z = cross(cx, cy, cz, lx, ly, lz)
    bx, by, bz = turn(moment, tx - x, ty - y, tz - z)
    x, y, z = cross(bx, by, bz, cx, cy, cz)
    apply(c, share, arm, lever, lx / total - x, ly / total - y, lz / total - z, bx, by, bz, force, press)


@inlined_kernel
def cross(ax, ay, az, bx, by, bz):
    """The vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@inlined_kernel
def add_wrench(wrench, c, factor, x, y, z, fx, fy, fz):
    """Add ``factor`` times a force at x, y, z and its moment to row ``c`` of ``wrench`` (C, 6)."""
    mx, my, mz = cross(x, y, z, fx, fy, fz)
    wrench[c, 0] += factor * fx
    wrench[c, 1] += factor * fy
    wrench[c, 2] += factor * fz
    wrench[c, 3] += factor * mx
    wrench[c, 4] += factor * my
    wrench[c, 5] += factor * mz


@kernel
def shares(c, part, force):
    """(K,) N: the sizes of forces (K, 3) N, none of them nothing; 0 for other parts than ``c``."""
    share, total, count = np.zeros(force.shape[0]), 0.0, 0
    for k in range(force.shape[0]):
        if part[k] == c:
            share[k] = math.sqrt(force[k, 0] ** 2 + force[k, 1] ** 2 + force[k, 2] ** 2)
            total += share[k]
            count += 1
    least = EVEN * total / count if total > 0.0 else 1.0
    for k in range(force.shape[0]):
        if part[k] == c:
            share[k] += least
    return share


@kernel
def spread(c, share, arm, lever, press):
    """(10,) all shares together, and their moments of first and second order (xx, yy, zz, xy, xz, yz)."""
    moment = np.zeros(10)
    for k in range(share.shape[0]):
        _add_point(moment, share[k], arm[k, 0], arm[k, 1], arm[k, 2])
    for o in range(press.shape[0]):
        x, y, z = lever[o, 0], lever[o, 1], lever[o, 2]
        _add_point(moment, press[o, c, SIZE], x, y, z)
        fx, fy, fz = press[o, c, FIRST], press[o, c, FIRST + 1], press[o, c, FIRST + 2]
        moment[1] += fx
        moment[2] += fy
        moment[3] += fz
        moment[4] += press[o, c, SECOND] + 2.0 * fx * x  # parallel axes
        moment[5] += press[o, c, SECOND + 4] + 2.0 * fy * y
        moment[6] += press[o, c, SECOND + 8] + 2.0 * fz * z
        moment[7] += press[o, c, SECOND + 1] + fx * y + fy * x
        moment[8] += press[o, c, SECOND + 2] + fx * z + fz * x
        moment[9] += press[o, c, SECOND + 5] + fy * z + fz * y
    return moment


@inlined_kernel
def _add_point(moment, weight, x, y, z):
    for n, value in enumerate((1.0, x, y, z, x * x, y * y, z * z, x * y, x * z, y * z)):
        moment[n] += weight * value


@kernel
def lacking(c, whole, share, arm, lever, force, press):
    """What forces at the arms that have a ``share``, and the ``press``, lack of the ``whole``: force and moment."""
    rest = np.empty((1, 6))
    for a in range(6):
        rest[0, a] = whole[c, a]
    for k in range(share.shape[0]):
        if share[k] != 0.0:
            add_wrench(rest, 0, -1.0, arm[k, 0], arm[k, 1], arm[k, 2], force[k, 0], force[k, 1], force[k, 2])
    for o in range(press.shape[0]):
        fx, fy, fz = press[o, c, 0], press[o, c, 1], press[o, c, 2]
        add_wrench(rest, 0, -1.0, lever[o, 0], lever[o, 1], lever[o, 2], fx, fy, fz)
        for a in range(3, 6):
            rest[0, a] -= press[o, c, a]
    return rest[0, 0], rest[0, 1], rest[0, 2], rest[0, 3], rest[0, 4], rest[0, 5]


@kernel
def turn(moment, tx, ty, tz):
    """The least vector b for which shares of b x place have the moment tx, ty, tz about the centre of all shares.

    About a line or a point on which all of them are it is not turned. Not finite if the ``moment`` (10,) is not.
    """
    total, raw = moment[0], moment[4] + moment[5] + moment[6]
    if not math.isfinite(raw):
        return raw, raw, raw
    x, y, z = moment[1] / total, moment[2] / total, moment[3] / total
    xx, yy, zz = moment[4] - total * x * x, moment[5] - total * y * y, moment[6] - total * z * z
    inertia = np.empty((3, 3))
    inertia[0, 0], inertia[1, 1], inertia[2, 2] = yy + zz, xx + zz, xx + yy
    inertia[0, 1] = inertia[1, 0] = total * x * y - moment[7]
    inertia[0, 2] = inertia[2, 0] = total * x * z - moment[8]
    inertia[1, 2] = inertia[2, 1] = total * y * z - moment[9]
    resists, axes = np.linalg.eigh(inertia)
    bx = by = bz = 0.0
    for k in range(3):
        if resists[k] > max(FLAT * resists[2], ROUNDING * raw):
            angle = (axes[0, k] * tx + axes[1, k] * ty + axes[2, k] * tz) / resists[k]
            bx, by, bz = bx + angle * axes[0, k], by + angle * axes[1, k], bz + angle * axes[2, k]
    return bx, by, bz


@kernel
def apply(c, share, arm, lever, ax, ay, az, bx, by, bz, force, press):
    """Add its share of a + b x place to the force at each arm, and those of all that pressed on them to obstacles'."""
    for k in range(share.shape[0]):
        x, y, z = cross(bx, by, bz, arm[k, 0], arm[k, 1], arm[k, 2])
        force[k, 0] += share[k] * (ax + x)
        force[k, 1] += share[k] * (ay + y)
        force[k, 2] += share[k] * (az + z)
    for o in range(press.shape[0]):
        x, y, z = cross(bx, by, bz, lever[o, 0], lever[o, 1], lever[o, 2])
        hx, hy, hz = ax + x, ay + y, az + z
        weight, fx, fy, fz = press[o, c, SIZE], press[o, c, FIRST], press[o, c, FIRST + 1], press[o, c, FIRST + 2]
        x, y, z = cross(bx, by, bz, fx, fy, fz)
        press[o, c, 0] += weight * hx + x
        press[o, c, 1] += weight * hy + y
        press[o, c, 2] += weight * hz + z
        around = press[o, c, SECOND] + press[o, c, SECOND + 4] + press[o, c, SECOND + 8]
        x, y, z = cross(fx, fy, fz, hx, hy, hz)
        for a, (m, b) in enumerate(((x, bx), (y, by), (z, bz))):
            row = SECOND + 3 * a
            along = press[o, c, row] * bx + press[o, c, row + 1] * by + press[o, c, row + 2] * bz
            press[o, c, 3 + a] += m + around * b - along
