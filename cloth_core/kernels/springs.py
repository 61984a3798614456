"""Springs: forces, the local step of local/global, and the stretch limit."""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from cloth_core.kernels import kernel, lane_kernel, shared_kernel
from cloth_core.kernels.shares import add_shares
from cloth_core.kernels.tensors import add_square

BATCH = 256
"""Springs in a batch: what is known of them stays in the first cache."""
BARELY = 1.0 + 1e-9
"""Square of a length over its limit that rounding makes of a spring which a sweep has brought back to it."""


@kernel
def add_spring_forces(position, velocity, spring_vertex, rest, stiffness, viscosity_time, force):
    """Add elastic and viscous spring forces (Fig. 4) to ``force`` (V, 3) N.

    ``viscosity_time`` is the paper's dt in ``k dt (v_j - v_i)``, s.
    """
    for s in range(spring_vertex.shape[0]):
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        length = math.sqrt(dx * dx + dy * dy + dz * dz)
        k = stiffness[s]
        pull = k * (length - rest[s]) / length if length > 0.0 else 0.0
        drag = k * viscosity_time
        fx = pull * dx + drag * (velocity[j, 0] - velocity[i, 0])
        fy = pull * dy + drag * (velocity[j, 1] - velocity[i, 1])
        fz = pull * dz + drag * (velocity[j, 2] - velocity[i, 2])
        force[i, 0] += fx
        force[i, 1] += fy
        force[i, 2] += fz
        force[j, 0] -= fx
        force[j, 1] -= fy
        force[j, 2] -= fz


@kernel
def energy(position, spring_vertex, rest, stiffness):
    """J that springs of ``stiffness`` (S,) N/m store at ``position`` (V, 3) m."""
    total = 0.0
    for s in range(spring_vertex.shape[0]):
        longer = _length(position, spring_vertex[s, 0], spring_vertex[s, 1]) - rest[s]
        total += 0.5 * stiffness[s] * longer * longer
    return total


@shared_kernel
def add_elastic_impulses(position, start, spring_vertex, rest, stiffness, tension, viscosity, scale, right_side, apart):
    """Add ``scale`` s^2 times the force of every spring to ``right_side`` (V, 3) kg m.

    A spring pulls with stiffness * (length - rest), plus the ``tension`` (S,) N of its stretch limit, plus
    stiffness * ``viscosity`` times what it lengthened since ``start`` along its own direction: a rigid
    rotation is not damped. Springs go in P + 1 shares, of which all but the first collect in ``apart`` (P, V, 3).
    """
    shares = apart.shape[0] + 1
    count = spring_vertex.shape[0]
    for n in prange(shares):
        of_share = slice(n * count // shares, (n + 1) * count // shares)
        total = right_side
        if n > 0:
            total = apart[n - 1]
            total[:] = 0.0
        _add_impulses(
            position, start, spring_vertex[of_share], rest[of_share], stiffness[of_share], tension[of_share],
            viscosity, scale, total,
        )  # fmt: skip
    add_shares(apart, right_side)


@lane_kernel
def _add_impulses(position, start, spring_vertex, rest, stiffness, tension, viscosity, scale, right_side):
    """The springs of a share, by the batch: collected, worked on in vector lanes, and given out again.

    Springs are in the order of their first ends, which are therefore read and written once for all that begin there.
    """
    room = np.empty((4, BATCH))
    x, y, z, gain = room[0], room[1], room[2], room[3]
    for first in range(0, spring_vertex.shape[0], BATCH):
        count = min(BATCH, spring_vertex.shape[0] - first)
        i = spring_vertex[first, 0]
        px, py, pz = position[i, 0], position[i, 1], position[i, 2]
        qx, qy, qz = start[i, 0], start[i, 1], start[i, 2]
        for n in range(count):
            if spring_vertex[first + n, 0] != i:
                i = spring_vertex[first + n, 0]
                px, py, pz = position[i, 0], position[i, 1], position[i, 2]
                qx, qy, qz = start[i, 0], start[i, 1], start[i, 2]
            j = spring_vertex[first + n, 1]
            dx, dy, dz = position[j, 0] - px, position[j, 1] - py, position[j, 2] - pz
            gain[n] = dx * (dx - start[j, 0] + qx) + dy * (dy - start[j, 1] + qy) + dz * (dz - start[j, 2] + qz)
            x[n], y[n], z[n] = dx, dy, dz
        of_batch = slice(first, first + count)
        _pull(x, y, z, gain, rest[of_batch], stiffness[of_batch], tension[of_batch], viscosity, scale)
        i = spring_vertex[first, 0]
        ax = ay = az = 0.0
        for n in range(count):
            if spring_vertex[first + n, 0] != i:
                _add(right_side, i, ax, ay, az)
                i = spring_vertex[first + n, 0]
                ax = ay = az = 0.0
            ax, ay, az = ax + x[n], ay + y[n], az + z[n]
            _add(right_side, spring_vertex[first + n, 1], -x[n], -y[n], -z[n])
        _add(right_side, i, ax, ay, az)


@lane_kernel
def _add(right_side, v, x, y, z):
    right_side[v, 0] += x
    right_side[v, 1] += y
    right_side[v, 2] += z


@lane_kernel
def _pull(x, y, z, gain, rest, stiffness, tension, viscosity, scale):
    """Turn the vectors along springs into what :func:`add_elastic_impulses` adds."""
    for n in range(rest.shape[0]):
        square = x[n] * x[n] + y[n] * y[n] + z[n] * z[n]
        inverse = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
        k = stiffness[n]
        c = scale * (k + (tension[n] - k * rest[n]) * inverse + k * viscosity * gain[n] * inverse * inverse)
        x[n] *= c
        y[n] *= c
        z[n] *= c


@kernel
def add_resistance(position, spring_vertex, rest, stiffness, tension, scale, along, across):
    """Add what springs resist a move of each vertex with: ``along`` (V, 6) kg, tensors, and ``across`` (V,) kg.

    ``scale`` s^2 times their stiffness in their own directions, and times what their force makes stiff across them:
    twice that, so that it is enough whatever the other end does. One that is pressed counts as if it pulled, for what
    buckles would go any way at once. ``stiffness`` and ``tension`` as in :func:`add_elastic_impulses`.
    """
    for s in range(spring_vertex.shape[0]):
        i, j = spring_vertex[s, 0], spring_vertex[s, 1]
        x, y, z = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1], position[j, 2] - position[i, 2]
        square = x * x + y * y + z * z
        if square == 0.0:
            continue
        length, k = math.sqrt(square), max(stiffness[s], 0.0)
        taut = 2.0 * scale * abs(k * (length - rest[s]) + tension[s]) / length
        add_square(along, i, scale * k / square, x, y, z)
        add_square(along, j, scale * k / square, x, y, z)
        across[i] += taut
        across[j] += taut


@kernel
def find_taut(position, limited, spring_vertex, shortest, tension, taut):
    """List those of the ``limited`` springs (L,) that are longer than ``shortest`` (S,) m or under ``tension`` (S,) N.

    Returns how many there are; their numbers stand at the beginning of ``taut`` (L,).
    """
    count = 0
    for n in range(limited.shape[0]):
        s = limited[n]
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        least = shortest[s]
        if dx * dx + dy * dy + dz * dz > least * least or tension[s] > 0.0:
            taut[count] = s
            count += 1
    return count


@kernel
def carry_limit(start, position, taut, spring_vertex, longest, stiffness, strongest, kept, yielding, steady, tension):
    """Let the ``taut`` springs carry by ``tension`` (S,) N what keeps them at ``longest`` (S,) m.

    A multiplier of the augmented Lagrangian: the share ``kept`` of what it was, plus stiffness * (length -
    longest), less stiffness * ``yielding`` times what the spring shortened from ``start`` to ``position`` (V, 3) m
    by more than the share ``steady`` of ``longest``; never below zero, never above ``strongest`` (S,) N.
    """
    for n in range(taut.shape[0]):
        s = taut[n]
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        square = dx * dx + dy * dy + dz * dz
        most = longest[s]
        if square > most * most or tension[s] > 0.0:
            length = math.sqrt(square)
            shortened = max(0.0, _length(start, i, j) - length - steady * most)
            carried = kept * tension[s] + stiffness[s] * (length - most - yielding * shortened)
            tension[s] = min(max(carried, 0.0), strongest[s])


@kernel
def _length(position, i, j):
    x, y, z = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1], position[j, 2] - position[i, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def shorten_springs(position, taut, spring_vertex, longest, inverse_mass, backward):
    """One pass over those of the ``taut`` springs that exceed ``longest`` (S,) m (paper, 3.3.2), maybe ``backward``.

    Both ends move along the spring's axis so that their centre of gravity stays; a vertex whose
    ``inverse_mass`` is zero stays and the other end moves all the way. Returns the largest excess
    met, as a share of ``longest``.
    """
    count = taut.shape[0]
    worst = 0.0
    for n in range(count):
        s = taut[count - 1 - n] if backward else taut[n]
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        square = dx * dx + dy * dy + dz * dz
        most = longest[s]
        if square <= most * most:
            continue
        share = inverse_mass[i] + inverse_mass[j]
        if share == 0.0:
            continue
        length = math.sqrt(square)
        excess = length - most
        worst = max(worst, excess / most)
        c = excess / (length * share)
        a = c * inverse_mass[i]
        b = c * inverse_mass[j]
        position[i, 0] += a * dx
        position[i, 1] += a * dy
        position[i, 2] += a * dz
        position[j, 0] -= b * dx
        position[j, 1] -= b * dy
        position[j, 2] -= b * dz
    return worst


@kernel
def calm_overlong(position, velocity, lag, taut, spring_vertex, longest, inverse_mass, rate):
    """Slow down those of the ``taut`` springs that are overlong and shorten by more than ``rate`` 1/s of their length.

    Their ends change the ``velocity`` (V, 3) m/s along the spring, by opposite impulses, and lose their ``lag``.
    """
    for n in range(taut.shape[0]):
        s = taut[n]
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        square = dx * dx + dy * dy + dz * dz
        share = inverse_mass[i] + inverse_mass[j]
        if square <= BARELY * longest[s] * longest[s] or share == 0.0:
            continue
        for a in range(3):
            lag[i, a] = 0.0
            lag[j, a] = 0.0
        closing = (
            dx * (velocity[i, 0] - velocity[j, 0])
            + dy * (velocity[i, 1] - velocity[j, 1])
            + dz * (velocity[i, 2] - velocity[j, 2])
        ) / square
        if closing > rate:
            c = (closing - rate) / share
            a = c * inverse_mass[i]
            b = c * inverse_mass[j]
            velocity[i, 0] -= a * dx
            velocity[i, 1] -= a * dy
            velocity[i, 2] -= a * dz
            velocity[j, 0] += b * dx
            velocity[j, 1] += b * dy
            velocity[j, 2] += b * dz


@kernel
def any_longer(position, limited, spring_vertex, longest):
    """Whether one of the ``limited`` springs is longer than ``longest`` (S,) m."""
    for n in range(limited.shape[0]):
        s = limited[n]
        i = spring_vertex[s, 0]
        j = spring_vertex[s, 1]
        dx = position[j, 0] - position[i, 0]
        dy = position[j, 1] - position[i, 1]
        dz = position[j, 2] - position[i, 2]
        if dx * dx + dy * dy + dz * dz > longest[s] * longest[s]:
            return True
    return False


@kernel
def largest_stretch(position, spring_vertex, rest, chosen):
    """Largest length over rest length of the ``chosen`` (S,) springs; 1 if there are none."""
    worst = -1.0
    for s in range(spring_vertex.shape[0]):
        if chosen[s] and rest[s] > 0.0:
            worst = max(worst, _length(position, spring_vertex[s, 0], spring_vertex[s, 1]) / rest[s])
    return worst if worst >= 0.0 else 1.0


@kernel
def vertex_strain(position, spring_vertex, rest, chosen, strain):
    """Largest strain (length / rest length - 1) of the chosen springs at each vertex, into ``strain`` (V,)."""
    strain[:] = -np.inf
    for s in range(spring_vertex.shape[0]):
        if chosen[s] and rest[s] > 0.0:
            i = spring_vertex[s, 0]
            j = spring_vertex[s, 1]
            e = _length(position, i, j) / rest[s] - 1.0
            strain[i] = max(strain[i], e)
            strain[j] = max(strain[j], e)
    for v in range(strain.shape[0]):
        if strain[v] == -np.inf:
            strain[v] = 0.0
