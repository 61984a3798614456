"""Balancing the momentum that a constant W loses (paper, 3.2)."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel


@kernel
def fill_inertia(xx, yy, zz, xy, xz, yz, inertia):
    """The tensor of ``inertia`` (3, 3) kg m^2 that the second moments of mass make."""
    inertia[0, 0], inertia[1, 1], inertia[2, 2] = yy + zz, xx + zz, xx + yy
    inertia[0, 1] = inertia[1, 0] = -xy
    inertia[0, 2] = inertia[2, 0] = -xz
    inertia[1, 2] = inertia[2, 1] = -yz


@kernel
def moments(position, error, mass, component, chosen, count):
    """Moments of mass and of the displacement ``error`` (V, 3) m of the components that are ``chosen`` (C,).

    Sums run about the first vertex of each component, so that nothing cancels far from the origin.

    Returns:
        Mass (C,) kg, centre of mass (C, 3) m, momentum error (C, 3) kg m, and about the centre of mass the
        inertia (C, 3, 3) kg m^2 and the angular error (C, 3) kg m^2.
    """
    total = np.zeros(count)
    anchor = np.zeros((count, 3))
    first = np.zeros((count, 3))
    drift = np.zeros((count, 3))
    spread = np.zeros((count, 6))
    twist = np.zeros((count, 3))
    for v in range(position.shape[0]):
        c = component[v]
        if not chosen[c]:
            continue
        if total[c] == 0.0:
            anchor[c, 0], anchor[c, 1], anchor[c, 2] = position[v, 0], position[v, 1], position[v, 2]
        m = mass[v]
        x, y, z = position[v, 0] - anchor[c, 0], position[v, 1] - anchor[c, 1], position[v, 2] - anchor[c, 2]
        ex, ey, ez = error[v, 0], error[v, 1], error[v, 2]
        mx, my, mz = m * x, m * y, m * z
        total[c] += m
        first[c, 0] += mx
        first[c, 1] += my
        first[c, 2] += mz
        drift[c, 0] += m * ex
        drift[c, 1] += m * ey
        drift[c, 2] += m * ez
        spread[c, 0] += mx * x
        spread[c, 1] += my * y
        spread[c, 2] += mz * z
        spread[c, 3] += mx * y
        spread[c, 4] += mx * z
        spread[c, 5] += my * z
        twist[c, 0] += my * ez - mz * ey
        twist[c, 1] += mz * ex - mx * ez
        twist[c, 2] += mx * ey - my * ex
    center = np.zeros((count, 3))
    inertia = np.zeros((count, 3, 3))
    for c in range(count):
        if total[c] == 0.0:
            continue
        x, y, z = first[c, 0] / total[c], first[c, 1] / total[c], first[c, 2] / total[c]
        center[c, 0], center[c, 1], center[c, 2] = anchor[c, 0] + x, anchor[c, 1] + y, anchor[c, 2] + z
        # From the anchor to the centre of mass: parallel axes.
        twist[c, 0] -= y * drift[c, 2] - z * drift[c, 1]
        twist[c, 1] -= z * drift[c, 0] - x * drift[c, 2]
        twist[c, 2] -= x * drift[c, 1] - y * drift[c, 0]
        m = total[c]
        xx, yy, zz = spread[c, 0] - m * x * x, spread[c, 1] - m * y * y, spread[c, 2] - m * z * z
        xy, xz, yz = spread[c, 3] - m * x * y, spread[c, 4] - m * x * z, spread[c, 5] - m * y * z
        fill_inertia(xx, yy, zz, xy, xz, yz, inertia[c])
    return total, center, drift, inertia, twist


@kernel
def hinges(place, held, component, count, collinear):
    """What the ``held`` vertices leave free of each component (C): a turn about a point, about a line, or nothing.

    Returns:
        Kind (C,): 0 not held, 1 held at a point, 2 on a line, 3 off any line by more than ``collinear`` of its length;
        a point of it (C, 3) m; the line's unit direction (C, 3).
    """
    kind = np.zeros(count, dtype=np.int64)
    center = np.zeros((count, 3))
    along = np.zeros((count, 3))
    reach = np.zeros(count)
    for v in held:
        c = component[v]
        if kind[c] == 0:
            kind[c] = 1
            center[c] = place[v]
        x, y, z = place[v, 0] - center[c, 0], place[v, 1] - center[c, 1], place[v, 2] - center[c, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > reach[c]:
            kind[c] = 2
            reach[c] = length
            along[c, 0], along[c, 1], along[c, 2] = x / length, y / length, z / length
    for v in held:
        c = component[v]
        if kind[c] == 2:
            x, y, z = place[v, 0] - center[c, 0], place[v, 1] - center[c, 1], place[v, 2] - center[c, 2]
            ox = y * along[c, 2] - z * along[c, 1]
            oy = z * along[c, 0] - x * along[c, 2]
            oz = x * along[c, 1] - y * along[c, 0]
            if math.sqrt(ox * ox + oy * oy + oz * oz) > collinear * reach[c]:
                kind[c] = 3
    return kind, center, along


@kernel
def turn_about_lines(kind, along, inertia, twist, turn):
    """Where a component is held on a line (``kind`` 2), leave of ``turn`` (C, 3) rad what it can turn about that."""
    for c in range(kind.shape[0]):
        if kind[c] == 2:
            resisting = 0.0
            moment = 0.0
            for a in range(3):
                moment += along[c, a] * twist[c, a]
                for b in range(3):
                    resisting += along[c, a] * inertia[c, a, b] * along[c, b]
            angle = moment / resisting if resisting > 0.0 else 0.0
            for a in range(3):
                turn[c, a] = angle * along[c, a]


@kernel
def moments_about(position, error, mass, component, center, chosen):
    """As :func:`moments`, about a given ``center`` (C, 3) m: inertia (C, 3, 3) kg m^2, angular error (C, 3) kg m^2."""
    spread = np.zeros((center.shape[0], 6))
    twist = np.zeros_like(center)
    for v in range(position.shape[0]):
        c = component[v]
        if not chosen[c]:
            continue
        m = mass[v]
        x, y, z = position[v, 0] - center[c, 0], position[v, 1] - center[c, 1], position[v, 2] - center[c, 2]
        ex, ey, ez = error[v, 0], error[v, 1], error[v, 2]
        spread[c, 0] += m * x * x
        spread[c, 1] += m * y * y
        spread[c, 2] += m * z * z
        spread[c, 3] += m * x * y
        spread[c, 4] += m * x * z
        spread[c, 5] += m * y * z
        twist[c, 0] += m * (y * ez - z * ey)
        twist[c, 1] += m * (z * ex - x * ez)
        twist[c, 2] += m * (x * ey - y * ex)
    inertia = np.zeros((center.shape[0], 3, 3))
    for c in range(center.shape[0]):
        xx, yy, zz, xy, xz, yz = spread[c]
        fill_inertia(xx, yy, zz, xy, xz, yz, inertia[c])
    return inertia, twist


@kernel
def rigid_motion(total, drift, inertia, twist):
    """The shift (C, 3) m and turn (C, 3) rad of rigid bodies that carry these moments; none for bodies without mass.

    Collinear masses resist no turn about their line: inverting only what resists leaves that turn out.
    """
    shift = np.zeros_like(drift)
    turn = np.zeros_like(twist)
    for c in range(total.shape[0]):
        if total[c] == 0.0:
            continue
        moment, axes = np.linalg.eigh(inertia[c])
        for k in range(3):
            shift[c, k] = drift[c, k] / total[c]
            if moment[k] > 1e-9 * moment[2]:
                along = (axes[0, k] * twist[c, 0] + axes[1, k] * twist[c, 1] + axes[2, k] * twist[c, 2]) / moment[k]
                for a in range(3):
                    turn[c, a] += along * axes[a, k]
    return shift, turn


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
