"""Balancing the momentum that a constant W loses (paper, 3.2)."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel, lane_kernel

FREE, ON_POINT, ON_LINE, FAST = range(4)
"""What the held vertices leave free of a component: everything, a turn about a point, about a line, nothing."""

MASS, FIRST, DRIFT, SPREAD, TWIST, MOMENTS = 0, 1, 4, 7, 13, 16
"""Where the moments of a component begin in its row: mass, first moment, momentum error, second moments (xx, yy, zz,
xy, xz, yz), angular error; and how many numbers there are."""


@kernel
def balance(place, inertial, moved, mass, runs, component, held, hanging, collinear):
    """Add the rigid displacement to ``moved`` (V, 3) m that gives each component the momenta of ``inertial`` (V, 3) m.

    Those momenta alone that the ``held`` vertices leave it; these stay. ``runs`` (R, 3) are ranges of vertices and the
    component they belong to. Only free components are corrected unless ``hanging``.
    """
    components = 0
    for r in range(runs.shape[0]):
        components = max(components, runs[r, 2] + 1)
    kind, anchor, along = hinges(place, held, component, components, collinear)
    chosen = np.zeros(components, np.bool_)
    nothing = True
    for c in range(components):
        chosen[c] = kind[c] == FREE or (hanging and (kind[c] == ON_POINT or kind[c] == ON_LINE))
        nothing = nothing and not chosen[c]
    if nothing:
        return
    for r in range(runs.shape[0] - 1, -1, -1):
        if kind[runs[r, 2]] == FREE:
            for a in range(3):
                anchor[runs[r, 2], a] = place[runs[r, 0], a]
    moment = moments(place, inertial, moved, mass, runs, anchor, chosen)
    shift, turn = rigid_motion(kind, along, anchor, moment)
    kept = np.empty((held.shape[0], 3))
    for n in range(held.shape[0]):
        for a in range(3):
            kept[n, a] = moved[held[n], a]
    add_rigid_displacement(place, anchor, shift, turn, runs, chosen, moved)
    for n in range(held.shape[0]):
        for a in range(3):
            moved[held[n], a] = kept[n, a]


@kernel
def moments(place, inertial, moved, mass, runs, anchor, chosen):
    """Moments (C, 16) of mass and of the displacement ``inertial`` - ``moved`` of the components that are ``chosen``.

    They are taken about the ``anchor`` (C, 3) m of each, so that nothing cancels far from the origin.
    """
    moment = np.zeros((anchor.shape[0], MOMENTS))
    for r in range(runs.shape[0]):
        c = runs[r, 2]
        if chosen[c]:
            _add_moments(place, inertial, moved, mass, runs[r, 0], runs[r, 1], anchor[c], moment[c])
    return moment


@lane_kernel
def _add_moments(place, inertial, moved, mass, begin, end, anchor, moment):
    ax, ay, az = anchor[0], anchor[1], anchor[2]
    total = fx = fy = fz = dx = dy = dz = 0.0
    xx = yy = zz = xy = xz = yz = 0.0
    tx = ty = tz = 0.0
    for v in range(begin, end):
        m = mass[v]
        x, y, z = place[v, 0] - ax, place[v, 1] - ay, place[v, 2] - az
        ex, ey, ez = inertial[v, 0] - moved[v, 0], inertial[v, 1] - moved[v, 1], inertial[v, 2] - moved[v, 2]
        mx, my, mz = m * x, m * y, m * z
        total += m
        fx += mx
        fy += my
        fz += mz
        dx += m * ex
        dy += m * ey
        dz += m * ez
        xx += mx * x
        yy += my * y
        zz += mz * z
        xy += mx * y
        xz += mx * z
        yz += my * z
        tx += my * ez - mz * ey
        ty += mz * ex - mx * ez
        tz += mx * ey - my * ex
    for n, sum_of in enumerate((total, fx, fy, fz, dx, dy, dz, xx, yy, zz, xy, xz, yz, tx, ty, tz)):
        moment[n] += sum_of


@kernel
def hinges(place, held, component, count, collinear):
    """What the ``held`` vertices leave free of each component (C): a turn about a point, about a line, or nothing.

    Returns:
        Kind (C,), FAST if they are off any line by more than ``collinear`` of its length;
        a point of it (C, 3) m; the line's unit direction (C, 3).
    """
    kind = np.zeros(count, dtype=np.int64)
    center = np.zeros((count, 3))
    along = np.zeros((count, 3))
    reach = np.zeros(count)
    for v in held:
        c = component[v]
        if kind[c] == FREE:
            kind[c] = ON_POINT
            for a in range(3):
                center[c, a] = place[v, a]
        x, y, z = place[v, 0] - center[c, 0], place[v, 1] - center[c, 1], place[v, 2] - center[c, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > reach[c]:
            kind[c] = ON_LINE
            reach[c] = length
            along[c, 0], along[c, 1], along[c, 2] = x / length, y / length, z / length
    for v in held:
        c = component[v]
        if kind[c] == ON_LINE:
            x, y, z = place[v, 0] - center[c, 0], place[v, 1] - center[c, 1], place[v, 2] - center[c, 2]
            ox = y * along[c, 2] - z * along[c, 1]
            oy = z * along[c, 0] - x * along[c, 2]
            oz = x * along[c, 1] - y * along[c, 0]
            if math.sqrt(ox * ox + oy * oy + oz * oz) > collinear * reach[c]:
                kind[c] = FAST
    return kind, center, along


@kernel
def rigid_motion(kind, along, anchor, moment):
    """The shift (C, 3) m and turn (C, 3) rad of rigid bodies that carry the errors in ``moment`` (C, 16).

    A free body turns about its centre of mass, to which ``anchor`` (C, 3) m is moved; others about the anchor that they
    hang on, or about the line ``along`` (C, 3) through it. Collinear masses resist no turn about their line, so that
    turn is left out.
    """
    shift, turn = np.zeros_like(anchor), np.zeros_like(anchor)
    inertia, twist = np.zeros((3, 3)), np.zeros(3)
    for c in range(kind.shape[0]):
        total = moment[c, MASS]
        if total == 0.0:
            continue
        xx, yy, zz, xy, xz, yz = moment[c, SPREAD:TWIST]
        for a in range(3):
            twist[a] = moment[c, TWIST + a]
        if kind[c] == FREE:  # from the anchor to the centre of mass: parallel axes
            x, y, z = moment[c, FIRST] / total, moment[c, FIRST + 1] / total, moment[c, FIRST + 2] / total
            dx, dy, dz = moment[c, DRIFT], moment[c, DRIFT + 1], moment[c, DRIFT + 2]
            shift[c, 0], shift[c, 1], shift[c, 2] = dx / total, dy / total, dz / total
            anchor[c, 0] += x
            anchor[c, 1] += y
            anchor[c, 2] += z
            twist[0] -= y * dz - z * dy
            twist[1] -= z * dx - x * dz
            twist[2] -= x * dy - y * dx
            xx, yy, zz = xx - total * x * x, yy - total * y * y, zz - total * z * z
            xy, xz, yz = xy - total * x * y, xz - total * x * z, yz - total * y * z
        inertia[0, 0], inertia[1, 1], inertia[2, 2] = yy + zz, xx + zz, xx + yy
        inertia[0, 1] = inertia[1, 0] = -xy
        inertia[0, 2] = inertia[2, 0] = -xz
        inertia[1, 2] = inertia[2, 1] = -yz
        if kind[c] == ON_LINE:
            _turn_about_line(along[c], inertia, twist, turn[c])
        else:
            _turn(inertia, twist, turn[c])
    return shift, turn


@kernel
def _turn(inertia, twist, turn):
    resists, axes = np.linalg.eigh(inertia)
    for k in range(3):
        if resists[k] > 1e-9 * resists[2]:
            angle = (axes[0, k] * twist[0] + axes[1, k] * twist[1] + axes[2, k] * twist[2]) / resists[k]
            for a in range(3):
                turn[a] += angle * axes[a, k]


@kernel
def _turn_about_line(along, inertia, twist, turn):
    resists = twisted = 0.0
    for a in range(3):
        twisted += along[a] * twist[a]
        for b in range(3):
            resists += along[a] * inertia[a, b] * along[b]
    angle = twisted / resists if resists > 0.0 else 0.0
    for a in range(3):
        turn[a] = angle * along[a]


@lane_kernel
def add_rigid_displacement(place, center, shift, turn, runs, chosen, moved):
    """Add ``shift + turn x (place - center)`` of each chosen component to ``moved`` (V, 3) m."""
    for r in range(runs.shape[0]):
        c = runs[r, 2]
        if not chosen[c]:
            continue
        cx, cy, cz = center[c, 0], center[c, 1], center[c, 2]
        sx, sy, sz = shift[c, 0], shift[c, 1], shift[c, 2]
        tx, ty, tz = turn[c, 0], turn[c, 1], turn[c, 2]
        for v in range(runs[r, 0], runs[r, 1]):
            x, y, z = place[v, 0] - cx, place[v, 1] - cy, place[v, 2] - cz
            moved[v, 0] += sx + ty * z - tz * y
            moved[v, 1] += sy + tz * x - tx * z
            moved[v, 2] += sz + tx * y - ty * x
