"""What contacts of the cloth with itself do: push apart, rub, end impacts; equal and opposite on both sides."""

from __future__ import annotations

import math

from cloth_core.kernels import kernel, part_kernel
from cloth_core.kernels.closest import between

IDLE = 0.02
"""Share of the target that a pair which was pushed already may lack: another push would not be seen."""


@part_kernel
def shift(x, vertex, weight, inverse_mass, c, dx, dy, dz):
    """Move the four vertices of contact ``c`` by an impulse along ``d``, m kg, in ``x`` (V, 3)."""
    for i in range(4):
        v = vertex[c, i]
        w = weight[c, i] * inverse_mass[v]
        x[v, 0] += w * dx
        x[v, 1] += w * dy
        x[v, 2] += w * dz


@kernel
def ease(vertex, weight, inverse_mass, count, mobility):
    """How far a unit impulse moves each of ``count`` pairs apart, into ``mobility`` (C,) 1/kg."""
    for c in range(count):
        mobility[c] = 0.0
        for i in range(4):
            mobility[c] += weight[c, i] * weight[c, i] * inverse_mass[vertex[c, i]]


@kernel
def renew(start, vertex, weight, normal, target, keep, recover, count, pushed, spent):
    """Take ``count`` contacts up again as they stand at the ``start`` (V, 3) m of another substep, in place.

    What is still closer than it shall ``keep`` (C,) m may come apart by ``recover`` m.
    """
    for c in range(count):
        p, q, r, s = vertex[c, 0], vertex[c, 1], vertex[c, 2], vertex[c, 3]
        dx, dy, dz = between(start, p, q, r, s, weight[c, 0], weight[c, 1], weight[c, 2], weight[c, 3])
        up = dx * normal[c, 0] + dy * normal[c, 1] + dz * normal[c, 2]
        target[c] = min(keep[c], max(target[c], up + recover))
        pushed[c], spent[c] = 0.0, 0.0


@kernel
def push_apart(
    start, position, vertex, weight, normal, target, inverse_mass, mobility, friction, pushed, spent, first, count, back
):
    """Bring pairs that are closer than their ``target`` (C,) m apart, with friction; one pass, maybe ``back``wards.

    Coulomb on displacements: from the tangential way since the ``start`` (V, 3) m, ``friction`` times what was
    ``pushed`` (C,) m in the whole substep is taken back at most, less what was ``spent`` (C,) m of it before.
    Contacts ``first`` to ``count`` are looked at. Returns the farthest push in m.
    """
    most = 0.0
    for n in range(first, count):
        c = count - 1 - (n - first) if back else n
        if mobility[c] <= 0.0:
            continue
        p, q, r, s = vertex[c, 0], vertex[c, 1], vertex[c, 2], vertex[c, 3]
        wp, wq, wr, ws = weight[c, 0], weight[c, 1], weight[c, 2], weight[c, 3]
        nx, ny, nz = normal[c, 0], normal[c, 1], normal[c, 2]
        dx, dy, dz = between(position, p, q, r, s, wp, wq, wr, ws)
        lacking = target[c] - (dx * nx + dy * ny + dz * nz)
        if lacking <= (IDLE * target[c] if pushed[c] > 0.0 else 0.0):
            continue
        pushed[c] += lacking
        most = max(most, lacking)
        fx, fy, fz = lacking * nx, lacking * ny, lacking * nz
        if friction > 0.0:
            bx, by, bz = between(start, p, q, r, s, wp, wq, wr, ws)
            gx, gy, gz = dx - bx, dy - by, dz - bz
            up = gx * nx + gy * ny + gz * nz
            gx, gy, gz = gx - up * nx, gy - up * ny, gz - up * nz
            way = math.sqrt(gx * gx + gy * gy + gz * gz)
            taken = min(way, friction * pushed[c] - spent[c])
            if taken > 0.0:
                spent[c] += taken
                share = taken / way
                fx, fy, fz = fx - share * gx, fy - share * gy, fz - share * gz
        share = 1.0 / mobility[c]
        shift(position, vertex, weight, inverse_mass, c, share * fx, share * fy, share * fz)
    return most


@kernel
def end_impacts(velocity, start, vertex, weight, normal, target, inverse_mass, mobility, pushed, count, h):
    """End what was pushed as an inelastic impact, in ``velocity`` (V, 3) m/s, after a substep of ``h`` s.

    Pairs approach no more; nor do they part with the speed by which they were brought from where they stood at the
    ``start`` (V, 3) m to their ``target``: that corrects a place and is no impulse. Any other speed at which they part
    is theirs. Once forth and once back, for pairs have vertices in common.
    """
    for n in range(2 * count):
        c = n if n < count else 2 * count - 1 - n
        if pushed[c] <= 0.0 or mobility[c] <= 0.0:
            continue
        p, q, r, s = vertex[c, 0], vertex[c, 1], vertex[c, 2], vertex[c, 3]
        wp, wq, wr, ws = weight[c, 0], weight[c, 1], weight[c, 2], weight[c, 3]
        nx, ny, nz = normal[c, 0], normal[c, 1], normal[c, 2]
        dx, dy, dz = between(velocity, p, q, r, s, wp, wq, wr, ws)
        bx, by, bz = between(start, p, q, r, s, wp, wq, wr, ws)
        parting = dx * nx + dy * ny + dz * nz
        corrected = max(0.0, target[c] - (bx * nx + by * ny + bz * nz)) / h
        along = -min(parting, corrected if n < count else 0.0) / mobility[c]
        shift(velocity, vertex, weight, inverse_mass, c, along * nx, along * ny, along * nz)
