"""Slow twins of the kernels: plain numpy and loops, written from the paper's formulas, to compare with."""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.optimize import brentq

# ---------------------------------------------------------------- springs


def spring_forces(x, v, spring_vertex, rest, k, dt):
    """Fig. 4, the loop over neighbours j of each mass point i."""
    force = np.zeros_like(x)
    for i in range(len(x)):
        for (a, b), length0, stiffness in zip(spring_vertex, rest, k, strict=True):
            if i not in (a, b):
                continue
            j = b if i == a else a
            distance = np.linalg.norm(x[i] - x[j])
            if distance > 0:
                force[i] += stiffness * (distance - length0) * (x[j] - x[i]) / distance
            force[i] += stiffness * dt * (v[j] - v[i])
    return force


def elastic_forces(x, start, spring_vertex, rest, k, tension, viscosity):
    """Each spring pulls its two ends together along itself: elastic, limit's tension, viscous in what it gained."""
    force = np.zeros_like(x)
    for s, (i, j) in enumerate(spring_vertex):
        length = np.linalg.norm(x[j] - x[i])
        if length == 0.0:
            continue
        axis = (x[j] - x[i]) / length
        gained = axis @ ((x[j] - x[i]) - (start[j] - start[i]))
        pull = k[s] * (length - rest[s]) + tension[s] + viscosity * k[s] * gained
        force[i] += pull * axis
        force[j] -= pull * axis
    return force


def carried(start, x, taut, spring_vertex, longest, k, strongest, kept, yielding, steady, tension):
    """New tensions: taut springs' fade, grow by k times the excess, yield to shortening, within 0 and the strongest."""
    after = tension.copy()
    for s in taut:
        i, j = spring_vertex[s]
        length, before = np.linalg.norm(x[j] - x[i]), np.linalg.norm(start[j] - start[i])
        excess, shortened = length - longest[s], max(0.0, before - length - steady * longest[s])
        if excess > 0.0 or tension[s] > 0.0:
            after[s] = np.clip(kept * tension[s] + k[s] * (excess - yielding * shortened), 0.0, strongest[s])
    return after


def shorten(x, spring_vertex, longest, inverse_mass, backward):
    """Section 3.3.2, each overlong spring in turn; centre of gravity kept, constrained ends stay."""
    x, worst = x.copy(), 0.0
    for s in reversed(range(len(spring_vertex))) if backward else range(len(spring_vertex)):
        i, j = spring_vertex[s]
        length = np.linalg.norm(x[j] - x[i])
        if length <= longest[s] or inverse_mass[i] + inverse_mass[j] == 0:
            continue
        worst = max(worst, (length - longest[s]) / longest[s])
        axis = (x[j] - x[i]) / length
        share = inverse_mass[i] / (inverse_mass[i] + inverse_mass[j])
        x[i] = x[i] + share * (length - longest[s]) * axis
        x[j] = x[j] - (1 - share) * (length - longest[s]) * axis
    return x, worst


def calmed(x, v, lag, taut, spring_vertex, longest, inverse_mass, rate):
    """Velocities and lags when overlong springs, each in turn, shorten by no more than ``rate`` of their length."""
    v, lag = v.copy(), lag.copy()
    for s in taut:
        i, j = spring_vertex[s]
        axis, length = x[j] - x[i], np.linalg.norm(x[j] - x[i])
        if length <= longest[s] or inverse_mass[i] + inverse_mass[j] == 0:
            continue
        lag[i] = lag[j] = 0.0
        too_fast = max(0.0, axis @ (v[i] - v[j]) / length**2 - rate)
        impulse = too_fast / (inverse_mass[i] + inverse_mass[j]) * axis
        v[i] = v[i] - inverse_mass[i] * impulse
        v[j] = v[j] + inverse_mass[j] * impulse
    return v, lag


def stretches(x, spring_vertex, rest):
    """Length over rest length of every spring."""
    return np.array([np.linalg.norm(x[j] - x[i]) / r for (i, j), r in zip(spring_vertex, rest, strict=True)])


def strain_at_vertices(x, spring_vertex, rest, chosen):
    """Largest strain of the chosen springs at each vertex; zero where there is none."""
    strain = []
    for v in range(len(x)):
        at = [s for s in range(len(rest)) if chosen[s] and rest[s] > 0 and v in spring_vertex[s]]
        strain.append(max(stretches(x, spring_vertex[at], rest[at]) - 1) if at else 0.0)
    return np.array(strain)


def bending_matrix(count, start, vertex, weight, bend):
    """Q, so that the bending energy is x^T Q x / 2 in each coordinate."""
    q = np.zeros((count, count))
    for first, end in itertools.pairwise(start):
        row = np.zeros(count)
        np.add.at(row, vertex[first:end], weight[first:end])
        q += bend * np.outer(row, row)
    return q


def bending_of(mesh, material):
    """Q of a mesh."""
    reading = mesh.curvature_start, mesh.curvature_vertex, mesh.curvature_weight
    return bending_matrix(mesh.vertex_count, *reading, material.bend)


# ---------------------------------------------------------------- membrane


def gradients(x, triangles, slope):
    """(T, 3, 2): what a metre of warp and of weft has become in each triangle."""
    return np.einsum("tna,tnk->tak", x[triangles], slope)


def membrane_energy(x, triangles, slope, area, direction, modulus):
    """J: area * modulus / 2 * (|F d| - 1)^2 of every gauge."""
    length = np.linalg.norm(gradients(x, triangles, slope) @ direction.T, axis=1)
    return 0.5 * float(np.sum(area[:, None] * modulus * (length - 1.0) ** 2))


def membrane_forces(x, start, triangles, slope, area, direction, modulus, tension, viscosity):
    """Each gauge pulls at its corners along what it reads: elastic, limit's tension, viscous in what it gained."""
    force = np.zeros_like(x)
    for t, corners in enumerate(triangles):
        for d, (p, q) in enumerate(direction):
            weight = p * slope[t, :, 0] + q * slope[t, :, 1]
            reading, before = weight @ x[corners], weight @ start[corners]
            length = np.linalg.norm(reading)
            axis = reading / length
            stiffness = area[t] * modulus[d]
            pull = stiffness * (length - 1.0) + viscosity * stiffness * axis @ (reading - before)
            if d < 2:
                pull += tension[t, d]
            force[corners] -= pull * np.outer(weight, axis)
    return force


def thread_lengths(x, triangles, slope):
    """(T, 2) ratios: warp and weft of each triangle."""
    return np.linalg.norm(gradients(x, triangles, slope), axis=1)


def shorten_threads(x, taut, triangles, slope, longest, inverse_mass, backward):
    """Section 3.3.2 for threads that three corners share, each overlong one in turn; centre of gravity kept."""
    x, worst = x.copy(), 0.0
    for number in reversed(taut) if backward else taut:
        corners, weight = triangles[number // 2], slope[number // 2, :, number % 2]
        thread = weight @ x[corners]
        length = np.linalg.norm(thread)
        if length > longest:
            worst = max(worst, length / longest - 1.0)
            give = inverse_mass[corners] * weight
            x[corners] -= (length - longest) / (weight @ give) * np.outer(give, thread / length)
    return x, worst


# ---------------------------------------------------------------- surface


def area_vectors(x, triangles):
    """A third of each adjoining triangle's area vector."""
    total = np.zeros_like(x)
    for a, b, c in triangles:
        third = 0.5 * np.cross(x[b] - x[a], x[c] - x[a]) / 3
        for v in (a, b, c):
            total[v] += third
    return total


def drag(flow, area_vector, rest_area, coefficient):
    """Eq. (5) per area: K |w| (n . w) n, times the area that the vertex shows, at most that at rest."""
    force = np.zeros_like(flow)
    for v, (w, vector) in enumerate(zip(flow, area_vector, strict=True)):
        area = np.linalg.norm(vector)
        if area > 0:
            n = vector / area
            force[v] = coefficient * min(area, rest_area[v]) * np.linalg.norm(w) * np.dot(n, w) * n
    return force


def relative_drag(v, flow, area_vector, rest_area, coefficient, mass, h):
    """Eq. (5) with w - v, where c = K area |w - v| is at most m / h."""
    force = np.zeros_like(flow)
    for i in range(len(v)):
        area = np.linalg.norm(area_vector[i])
        if area > 0:
            n = area_vector[i] / area
            w = flow[i] - v[i]
            c = coefficient * min(area, rest_area[i]) * np.linalg.norm(w)
            force[i] = min(c, mass[i] / h) * np.dot(n, w) * n
    return force


def gusts(x, time, mean, wave, frequency, phase, amplitude):
    """Mean wind plus a sum of travelling waves."""
    return np.array(
        [
            mean
            + sum(
                a * math.sin(k @ p - f * time + q) for k, f, q, a in zip(wave, frequency, phase, amplitude, strict=True)
            )
            for p in x
        ]
    )


# ---------------------------------------------------------------- momentum


def rigid_correction(x, inertial, moved, mass, members):
    """Displacement field, zero outside ``members``, that gives ``moved`` the momenta of ``inertial`` about x_G."""
    m, r = mass[members], x[members]
    center = m @ r / m.sum()
    r = r - center
    error = (inertial - moved)[members]
    inertia = sum(mi * (ri @ ri * np.eye(3) - np.outer(ri, ri)) for mi, ri in zip(m, r, strict=True))
    turn = np.linalg.pinv(inertia, rcond=1e-9) @ sum(
        mi * np.cross(ri, ei) for mi, ri, ei in zip(m, r, error, strict=True)
    )
    field = np.zeros_like(x)
    field[members] = m @ error / m.sum() + np.cross(turn, r)
    return field


def hanging_correction(x, inertial, moved, mass, members, held):
    """As :func:`rigid_correction` for a part with ``held`` vertices: a turn about the point or line they leave free."""
    field, arms = np.zeros_like(x), x[held] - x[held[0]]
    line = arms[np.argmax(np.linalg.norm(arms, axis=1))]
    if np.any(np.linalg.norm(np.cross(arms, line), axis=1) > 1e-6 * (line @ line)):
        return field
    m, r, error = mass[members], x[members] - x[held[0]], (inertial - moved)[members]
    twist = sum(mi * np.cross(ri, ei) for mi, ri, ei in zip(m, r, error, strict=True))
    if np.any(line):
        axis = line / np.linalg.norm(line)
        turn = axis * (axis @ twist) / (m @ np.sum(np.cross(axis, r) ** 2, axis=1))
    else:
        inertia = sum(mi * (ri @ ri * np.eye(3) - np.outer(ri, ri)) for mi, ri in zip(m, r, strict=True))
        turn = np.linalg.solve(inertia, twist)
    field[members] = np.cross(turn, r)
    field[held] = 0.0
    return field


# ---------------------------------------------------------------- shapes


def distance_plane(_size, p):
    return p[2]


def distance_sphere(size, p):
    return np.linalg.norm(p) - size[0]


def distance_box(size, p):
    """Nearest point by clamping outside; least face distance inside."""
    nearest = np.clip(p, -size, size)
    if np.any(nearest != p):
        return np.linalg.norm(p - nearest)
    return -np.min(size - np.abs(p))


def distance_capsule(size, p):
    """Distance to the segment between the centres of the round ends."""
    radius, half = size[0], size[1]
    return np.linalg.norm(p - [0, 0, np.clip(p[2], -half, half)]) - radius


def distance_ellipsoid(radii, p):
    """Least distance to the surface: of the Lagrange condition's roots x_i = r_i^2 p_i / (r_i^2 + t), the nearest.

    Valid off the planes of symmetry; every interval between the poles t = -r_i^2 is searched for roots.
    """
    square = radii**2
    excess = lambda t: float(np.sum((radii * p / (square + t)) ** 2) - 1.0)  # noqa: E731
    reach = float(np.linalg.norm(radii * p)) + float(square.max())
    poles = np.unique(np.concatenate([-square, [reach, -square.max() - reach]]))
    distances = []
    for low, high in itertools.pairwise(poles):
        inside = np.linspace(low, high, 201)[1:-1]
        inside = np.concatenate([[low + 1e-12 * (high - low)], inside, [high - 1e-12 * (high - low)]])
        values = np.array([excess(t) for t in inside])
        for a in np.flatnonzero(values[:-1] * values[1:] < 0):
            t = brentq(excess, inside[a], inside[a + 1], xtol=1e-15)
            distances.append(np.linalg.norm(p - square * p / (square + t)))
    return math.copysign(min(distances), np.sum((p / radii) ** 2) - 1.0)


# ---------------------------------------------------------------- contacts


DISTANCE = (distance_plane, distance_sphere, distance_box, distance_capsule, distance_ellipsoid)


def surface_way(point, origin, origin_before, turn):
    """Displacement of an obstacle's material at a world point."""
    return origin - origin_before + np.cross(turn, point - origin)


def friction(start, x, surface, normal, most):
    """Position after taking back at most ``most`` m of the tangential way relative to the surface; and how much."""
    way = x - start - surface
    tangential = way - normal * (way @ normal)
    length = np.linalg.norm(tangential)
    taken = min(length, max(most, 0.0))
    return (x - taken * tangential / length, taken) if length > 0 and taken > 0 else (x, 0.0)


def impact(velocity, before, surface_speed, normal, restitution, rest_speed):
    """Velocity whose normal part is the surface's, plus the share of an approach that bounces."""
    approach = before @ normal - surface_speed
    bounce = -restitution * approach if approach < -rest_speed else 0.0
    return velocity + (surface_speed + bounce - velocity @ normal) * normal


# ---------------------------------------------------------------- reactions


def pressed(place, force):
    """(19,) what forces (P, 3) at (P, 3) press with: force, moment, size, and moments of size of both orders."""
    size = np.linalg.norm(force, axis=1)
    second = np.einsum("p,pa,pb->ab", size, place, place)
    return np.concatenate(
        [force.sum(axis=0), np.cross(place, force).sum(axis=0), [size.sum()], size @ place, second.ravel()]
    )


def made_up(whole, arm, force, lever, press, even=0.01, flat=1e-8):
    """What forces (K, 3) and the wrenches (O, 6) of the press (O, 19) become when they make up the whole (6,)."""
    size = np.linalg.norm(force, axis=1)
    share = size + even * size.mean() if size.any() else np.ones(len(force))
    weight, first, second = press[:, 6], press[:, 7:10], press[:, 10:].reshape(-1, 3, 3)
    total, center, inertia = spread(share, arm, weight, first, second, lever)
    lacking = whole - press[:, :6].sum(axis=0)
    lacking[:3] -= force.sum(axis=0)
    lacking[3:] -= np.cross(lever, press[:, :3]).sum(axis=0) + np.cross(arm, force).sum(axis=0)
    if len(force) == 0:
        lacking *= min(1.0, total / np.linalg.norm(lacking[:3]))
    turning = lacking[3:] - np.cross(center, lacking[:3])
    spin = np.linalg.pinv(inertia, rcond=flat, hermitian=True) @ turning
    base = lacking[:3] / total - np.cross(spin, center)
    here = base + np.cross(spin, lever)
    more = press[:, :6].copy()
    more[:, :3] += weight[:, None] * here + np.cross(spin, first)
    more[:, 3:] += np.cross(first, here) + inertia_of(second) @ spin
    return force + share[:, None] * (base + np.cross(spin, arm)), more


def spread(share, arm, weight, first, second, lever):
    """All shares together, their centre, and their moment of inertia about it."""
    total = share.sum() + weight.sum()
    center = (share @ arm + (first + weight[:, None] * lever).sum(axis=0)) / total
    mixed = np.einsum("oa,ob->oab", first, lever)
    square = np.einsum("k,ka,kb->ab", share, arm, arm) + np.einsum("o,oa,ob->ab", weight, lever, lever)
    square += (second + mixed + mixed.transpose(0, 2, 1)).sum(axis=0)
    return total, center, inertia_of(square - total * np.outer(center, center))


def inertia_of(square):
    """The moments of inertia (..., 3, 3) of what has these second moments."""
    return np.trace(square, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - square


# ---------------------------------------------------------------- the step of Fig. 4


def meyer_step(x, v, mass, spring_vertex, rest, k, bending, lasting, outer_force, dt, held, target, longest, sweeps):
    """One step of Fig. 4 with the rulings: dense, per coordinate; (new x, new v). One connected cloth.

    ``lasting`` s is the bending viscosity over the bending stiffness.
    A = M - dt^2 H with held vertices eliminated; outer forces inside the filter; inertia-corrected push on free
    cloths; stretch limit in the printed order, every other pass backwards.
    """
    count = len(x)
    h_matrix = -bending.copy()
    for (i, j), stiffness in zip(spring_vertex, k, strict=True):
        h_matrix[i, j] += stiffness
        h_matrix[j, i] += stiffness
        h_matrix[i, i] -= stiffness
        h_matrix[j, j] -= stiffness
    springs = spring_forces(x, v, spring_vertex, rest, k, dt) - bending @ (x + (dt + lasting) * v)
    right = dt * (springs + outer_force)
    a = np.diag(mass) - dt * dt * h_matrix + dt * lasting * bending
    free = np.setdiff1d(np.arange(count), held)
    change = np.zeros_like(x)
    change[held] = (target - x[held]) / dt - v[held]
    change[free] = np.linalg.solve(a[np.ix_(free, free)], right[free] - a[np.ix_(free, held)] @ change[held])
    moved = x + dt * (v + change)
    if len(held) == 0:
        inertial = x + dt * v + dt * dt * outer_force / mass[:, None]
        moved = moved + rigid_correction(x, inertial, moved, mass, np.arange(count))
    moved[held] = target
    inverse_mass = np.where(np.isin(np.arange(count), held), 0.0, 1.0 / mass)
    for sweep in range(sweeps):
        moved, worst = shorten(moved, spring_vertex, longest, inverse_mass, sweep % 2 == 1)
        if worst < 1e-5:
            break
    return moved, (moved - x) / dt


# ---------------------------------------------------------------- the midpoint rule


def reduced_solve(a, right, held, values):
    """x of a x = right with the ``held`` rows at ``values``: those rows and columns eliminated, dense."""
    free = np.setdiff1d(np.arange(len(a)), held)
    x = np.zeros_like(right)
    x[held] = values
    x[free] = np.linalg.solve(a[np.ix_(free, free)], right[free] - a[np.ix_(free, held)] @ values)
    return x


def balanced(x, inertial, moved, mass, held):
    """``moved`` with the momenta of ``inertial`` that nothing outside may change. One connected cloth."""
    everyone = np.arange(len(x))
    if len(held) == 0:
        return moved + rigid_correction(x, inertial, moved, mass, everyone)
    return moved + hanging_correction(x, inertial, moved, mass, everyone, held)


def bent(x, v, mass, bending, lasting, time, held, lag, gravity):
    """Velocity after ``time`` s of bending viscosity, and the mean acceleration by bending over that time."""
    m, nothing = np.diag(mass), np.zeros((len(held), 3))
    damped = reduced_solve(m + time * lasting * bending, mass[:, None] * v, held, v[held])
    damped = balanced(x, v, damped, mass, held)
    falling = np.tile(time * np.asarray(gravity, float), (len(x), 1))
    falling[held] = 0.0
    impulse = mass[:, None] * falling - time * bending @ (x + time * (damped + lag))
    change = reduced_solve(m + time**2 * bending, impulse, held, nothing) - falling
    return damped, balanced(x, np.zeros_like(x), change, mass, held) / time


def along_threads(z, spring_vertex, rest, k, scale):
    """(V, 3, 3) kg of threads along themselves, and (V,) kg across: at each vertex, as if the others stayed."""
    along, across = np.zeros((len(z), 3, 3)), np.zeros(len(z))
    for (i, j), length, stiffness in zip(spring_vertex, rest, k, strict=True):
        way = z[j] - z[i]
        now = np.linalg.norm(way)
        for n in (i, j):
            along[n] += scale * stiffness * np.outer(way, way) / now**2
            across[n] += 2 * scale * stiffness * abs(now - length) / now
    return along, across


def tensors(rows):
    """(V, 3, 3) of upper halves, row by row."""
    return rows[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)


def projections(along, mass, soft=0.7):
    """(V, 3, 3) onto what is stiffer than ``soft`` times the mass."""
    value, axis = np.linalg.eigh(along)
    share = value / (value + soft * mass[:, None])
    for _ in range(2):
        share = 3.0 * share**2 - 2.0 * share**3
    return np.einsum("vae,ve,vbe->vab", axis, share, axis)


def spread_along(solve, push, along, across, mass):
    """P W P + (1 - P) (m + s)^-1 (1 - P), times ``push`` (V, 3); ``solve`` is W."""
    p = projections(along, mass)
    q = np.eye(3) - p
    moved = np.einsum("vab,vb->va", p, solve(np.einsum("vab,vb->va", p, push)))
    return moved + np.einsum("vab,vbc,vc->va", q, q, push) / (mass + across)[:, None]


def buckled(z, residual, solve, spring_vertex, rest, k, scale, mass, held, farthest):
    """By how much the middle ``z`` moves when threads give way across themselves; ``residual`` is of a middle."""
    change = spread_along(solve, residual(z), *along_threads(z, spring_vertex, rest, k, scale), mass)
    change *= np.minimum(1.0, farthest / np.maximum(np.linalg.norm(change, axis=1), 1e-300))[:, None]
    change[held] = 0.0
    change = balanced(z, np.zeros_like(z), change, mass, held)
    slope, beyond = np.sum(change * residual(z)), np.sum(change * residual(z + change))
    return change * (slope / (slope - beyond) if beyond < 0 else 1.0)


def midpoint_step(
    x, v, lag, mass, spring_vertex, rest, k, stretch_lasting, bending, bend_lasting, gravity, h, held, iterations,
    thread,
):  # fmt: skip
    """One substep of x' = x + h (V + V') / 2, V' = V + h a(middle) with V = v + lag; (new x, new v, new lag).

    Held vertices stay; no stretch limit. The middle z solves M (z - y) = h^2 / 4 f(z), y the inertial middle. Each
    iteration replaces f by its value plus (1 + viscosity) times the constant Hessian L of springs without rest length.
    If the last one changes the middle by more than a hundredth of a ``thread``, another one lets threads buckle.
    """
    v, bending_acceleration = bent(x, v, mass, bending, bend_lasting, h, held, lag, gravity)
    laplacian = np.zeros((len(x), len(x)))
    for (i, j), stiffness in zip(spring_vertex, k, strict=True):
        e = np.zeros(len(x))
        e[i], e[j] = 1.0, -1.0
        laplacian += stiffness * np.outer(e, e)
    viscosity = stretch_lasting / (h / 2)  # what was gained since the start was gained in h / 2
    quarter, hessian = h * h / 4, (1 + viscosity) * laplacian
    inertial = x + h / 2 * (v + lag) + quarter * (gravity + bending_acceleration)
    inertial[held] = x[held]
    z, sudden = inertial, np.zeros_like(x)

    def residual(z):
        force = elastic_forces(z, x, spring_vertex, rest, k, np.zeros(len(k)), viscosity)
        return mass[:, None] * (inertial - z) + quarter * force

    def solve(push):
        return reduced_solve(np.diag(mass) + quarter * hessian, push, held, np.zeros((len(held), 3)))

    for _ in range(iterations):
        change = solve(residual(z))
        z = z + change
    hundredth = 0.01 * thread
    if np.abs(change).max() > max(hundredth, 15 * quarter * np.linalg.norm(gravity)):
        change = buckled(z, residual, solve, spring_vertex, rest, k, quarter * (1 + viscosity), mass, held, hundredth)
        z, sudden = z + change, 2 * change
    z = balanced(z, inertial, z, mass, held)
    end = 2 * z - x
    velocity = (end - x) / h
    ahead = 2 * (end - x - sudden / 2) / h - (v + lag)  # V', since the mean of V and V' is the displacement over h
    ahead[held] = 0.0
    lag = ahead - velocity - h / 2 * gravity
    for i in np.setdiff1d(np.arange(len(x)), held):  # what moves it by more than a tenth of a thread is left out
        shortest = min(length for pair, length in zip(spring_vertex, rest, strict=True) if i in pair)
        lag[i] *= min(1.0, 0.1 * shortest / (h * np.linalg.norm(lag[i])))
    lag += h / 2 * gravity
    lag[held] = 0.0
    return end, velocity, lag


def least_width(rotation, half, toward):
    """Of a box seen along ``toward``: the least extent across any direction in the picture."""
    e1 = np.cross(toward, np.eye(3)[np.argmin(np.abs(toward))])
    e1 /= np.linalg.norm(e1)
    e2 = np.cross(toward, e1)
    angle = np.linspace(0.0, np.pi, 20001)[:, None]
    across = np.cos(angle) * e1 + np.sin(angle) * e2
    return (2.0 * np.abs(across @ rotation) @ half).min()


def shelter(body, width, toward, point, sheltered=1.5, ended=6.0, spread=0.09):
    """Share of the wind that a ``body`` keeps from a ``point``: its ray against the wind in 4,000 even steps."""
    into, t = body.pose.rotation.T, np.linspace(0.0, 2.0 * np.linalg.norm(point), 4000)
    rays = (point - t[:, None] * toward - body.pose.position) @ into.T
    if body.kind == 4:
        t, rays = t[::10], rays[::10]
    away = np.array([DISTANCE[body.kind](np.array(body.size), ray) for ray in rays])
    hit = np.flatnonzero(away <= 0.0)
    closest = 0.0 if len(hit) else (away / np.maximum(spread * t, 1e-12)).min()
    at = (point - body.pose.position) @ toward - np.array(body.half_extents) @ np.abs(into @ toward)
    soft, closing = (np.clip(s, 0.0, 1.0) for s in (1.0 - closest, (ended - at / width) / (ended - sheltered)))
    return soft**2 * (3 - 2 * soft) * closing**2 * (3 - 2 * closing)


def immersed(x, v, rest_area, mass, thickness, gravity, h, fluids, area_vector):
    """Forces of ``fluids`` on each vertex, and its dry share.

    Each fluid is (shape, velocity, density, drag coefficient face-on, along, share displaced).
    """
    force, dry = np.zeros_like(x), np.ones(len(x))
    for i in np.flatnonzero(rest_area > 0):
        area = np.linalg.norm(area_vector[i])
        n = area_vector[i] / area if area > 0 else np.zeros(3)
        for shape, stream, rho, face_on, along, displaced in fluids:
            into, center = shape.pose.rotation.T, np.array(shape.pose.position)
            away = lambda p, s=shape, i=into, c=center: DISTANCE[s.kind](np.array(s.size), i @ (p - c))  # noqa: E731
            p = x[i] + h * v[i]
            outward = np.array([away(p + e) - away(p - e) for e in 1e-6 * np.eye(3)]) / 2e-6
            lifted = rho * displaced * thickness * rest_area[i]
            cosine = min(abs(n @ outward), 1.0)
            height = thickness * cosine + np.sqrt(rest_area[i] * (1 - cosine**2))
            height = max(height, 4.0 * lifted * np.linalg.norm(gravity) * h * h / mass[i])
            wet = dry[i] * np.clip(0.5 - away(p) / height, 0.0, 1.0)
            dry[i] -= wet
            w = stream - v[i]
            through = (n @ w) * n
            c, d = (
                min(0.5 * rho * k * a * np.linalg.norm(w) * wet, mass[i] / h)
                for k, a in ((face_on, min(area, rest_area[i])), (along, rest_area[i]))
            )
            force[i] += c * through + d * (w - through) - wet * lifted * np.array(gravity)
    return force, dry
