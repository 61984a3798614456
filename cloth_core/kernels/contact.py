"""Contacts: signed distances of the analytic shapes, push-out, friction and restitution."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.kernels import kernel

PLANE, SPHERE, BOX, CAPSULE, ELLIPSOID = range(5)


@kernel
def ellipsoid_distance(x, y, z, rx, ry, rz):
    """Signed distance to an ellipsoid of semi-axes ``rx, ry, rz``, and the outward normal.

    The closest point solves one equation in one unknown, here by Newton on its convex branch (after
    Eberly, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid").
    """
    small = min(rx, min(ry, rz))
    square = small * small
    # On a plane of symmetry inside there is no unique answer; a nudge chooses one.
    tiny = 1e-9 * small
    ax, ay, az = max(abs(x), tiny), max(abs(y), tiny), max(abs(z), tiny)
    qx, qy, qz = rx * rx / square - 1.0, ry * ry / square - 1.0, rz * rz / square - 1.0
    gx, gy, gz = rx * ax / square, ry * ay / square, rz * az / square
    s = 0.0
    if qx == 0.0:
        s = gx
    if qy == 0.0:
        s = max(s, gy)
    if qz == 0.0:
        s = max(s, gz)
    # Convex and falling from here on: Newton climbs to the root from below and cannot overshoot.
    for _ in range(64):
        ux, uy, uz = gx / (s + qx), gy / (s + qy), gz / (s + qz)
        excess = ux * ux + uy * uy + uz * uz - 1.0
        if excess < 1e-14:
            break
        s += 0.5 * excess / (ux * ux / (s + qx) + uy * uy / (s + qy) + uz * uz / (s + qz))
    cx, cy, cz = (qx + 1.0) * ax / (s + qx), (qy + 1.0) * ay / (s + qy), (qz + 1.0) * az / (s + qz)
    gap = math.sqrt((ax - cx) ** 2 + (ay - cy) ** 2 + (az - cz) ** 2)
    nx, ny, nz = cx / (rx * rx), cy / (ry * ry), cz / (rz * rz)
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    outside = (x / rx) ** 2 + (y / ry) ** 2 + (z / rz) ** 2 > 1.0
    return (
        gap if outside else -gap,
        math.copysign(nx / length, x),
        math.copysign(ny / length, y),
        math.copysign(nz / length, z),
    )


@kernel
def box_distance(x, y, z, hx, hy, hz):
    """Signed distance to a box of half edges ``hx, hy, hz``, and the direction out of it."""
    ox, oy, oz = abs(x) - hx, abs(y) - hy, abs(z) - hz
    if ox <= 0.0 and oy <= 0.0 and oz <= 0.0:
        if ox >= oy and ox >= oz:
            return ox, math.copysign(1.0, x), 0.0, 0.0
        if oy >= oz:
            return oy, 0.0, math.copysign(1.0, y), 0.0
        return oz, 0.0, 0.0, math.copysign(1.0, z)
    ox, oy, oz = max(ox, 0.0), max(oy, 0.0), max(oz, 0.0)
    distance = math.sqrt(ox * ox + oy * oy + oz * oz)
    return (
        distance,
        math.copysign(ox / distance, x),
        math.copysign(oy / distance, y),
        math.copysign(oz / distance, z),
    )


@kernel
def signed_distance(kind, size, x, y, z):
    """Signed distance in m of a point in the obstacle's frame, negative inside, and the outward unit normal."""
    if kind == PLANE:
        return z, 0.0, 0.0, 1.0
    if kind == BOX:
        return box_distance(x, y, z, size[0], size[1], size[2])
    if kind == ELLIPSOID:
        return ellipsoid_distance(x, y, z, size[0], size[1], size[2])
    if kind == CAPSULE:
        z -= min(max(z, -size[1]), size[1])
    length = math.sqrt(x * x + y * y + z * z)
    if length > 0.0:
        return length - size[0], x / length, y / length, z / length
    return -size[0], 1.0, 0.0, 0.0


@kernel
def into_frame(rotation, origin, x, y, z):
    """A world point in the frame that stands at ``origin`` with ``rotation`` (frame to world)."""
    x -= origin[0]
    y -= origin[1]
    z -= origin[2]
    return (
        rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z,
        rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z,
        rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z,
    )


@kernel
def distance_in_world(kind, size, rotation, origin, x, y, z):
    """Signed distance in m of a world point, and the outward unit normal in the world.

    Spheres and planes look alike from everywhere, or need one axis alone: no turning into their frames and back.
    """
    if kind == SPHERE:
        x, y, z = x - origin[0], y - origin[1], z - origin[2]
        length = math.sqrt(x * x + y * y + z * z)
        if length > 0.0:
            return length - size[0], x / length, y / length, z / length
    elif kind == PLANE:
        nx, ny, nz = rotation[0, 2], rotation[1, 2], rotation[2, 2]
        return nx * (x - origin[0]) + ny * (y - origin[1]) + nz * (z - origin[2]), nx, ny, nz
    x, y, z = into_frame(rotation, origin, x, y, z)
    distance, nx, ny, nz = signed_distance(kind, size, x, y, z)
    return (
        distance,
        rotation[0, 0] * nx + rotation[0, 1] * ny + rotation[0, 2] * nz,
        rotation[1, 0] * nx + rotation[1, 1] * ny + rotation[1, 2] * nz,
        rotation[2, 0] * nx + rotation[2, 1] * ny + rotation[2, 2] * nz,
    )


@kernel
def find_contacts(
    start,
    predicted,
    kind,
    size,
    reach,
    rotation_before,
    origin_before,
    travel,
    shell,
    recover,
    free,
    pair_vertex,
    pair_obstacle,
    pair_depth,
    left,
):
    """List the (vertex, obstacle) pairs that may touch within a substep.

    A pair counts if the vertex comes within the shell on its predicted way, with the obstacle's own
    ``travel`` (O,) m added. ``pair_depth`` gets the depth in m below the shell that the vertex may still
    have afterwards: what was already inside comes out by ``recover`` m a substep and no faster, so that
    nothing is shot away. Poses are those at the start of the substep. ``left`` (P, 3), where a pair was left by the
    last sweep, becomes nowhere.

    Returns the number of pairs; ``pair_*`` and ``left`` must have room for (V * O).
    """
    count = 0
    for v in range(start.shape[0]):
        if not free[v]:
            continue
        mx = predicted[v, 0] - start[v, 0]
        my = predicted[v, 1] - start[v, 1]
        mz = predicted[v, 2] - start[v, 2]
        way = math.sqrt(mx * mx + my * my + mz * mz)
        for o in range(kind.shape[0]):
            near = 2.0 * shell + way + travel[o]
            bound = reach[o] + near
            x, y, z = start[v, 0], start[v, 1], start[v, 2]
            dx, dy, dz = x - origin_before[o, 0], y - origin_before[o, 1], z - origin_before[o, 2]
            square = dx * dx + dy * dy + dz * dz
            if square > bound * bound:
                continue
            rotation = rotation_before[o]
            if kind[o] == SPHERE:
                distance = math.sqrt(square) - size[o, 0]
            elif kind[o] == PLANE:
                distance = rotation[0, 2] * dx + rotation[1, 2] * dy + rotation[2, 2] * dz
            else:
                distance = distance_in_world(kind[o], size[o], rotation, origin_before[o], x, y, z)[0]
            if distance < near:
                pair_vertex[count] = v
                pair_obstacle[count] = o
                pair_depth[count] = max(0.0, shell - distance - recover)
                left[count, 0] = np.nan
                count += 1
    return count


@kernel
def is_at(position, v, left, p):
    """Whether vertex ``v`` is still where pair ``p`` was left: a sweep moves few of those that touch."""
    return position[v, 0] == left[p, 0] and position[v, 1] == left[p, 1] and position[v, 2] == left[p, 2]


@kernel
def push_out(
    position, kind, size, rotation, origin, shell, pair_vertex, pair_obstacle, pair_depth, left, pushed, normal
):
    """Bring vertices that are too deep back to the shell (eq. 6, with the exact normal).

    Adds the distance to ``pushed`` (P,) m and stores the world ``normal`` (P, 3) of every pair that was
    pushed. Passes over those that are where they were ``left`` (P, 3) m. Returns the largest distance pushed.
    """
    most = 0.0
    for p in range(pair_vertex.shape[0]):
        v = pair_vertex[p]
        if is_at(position, v, left, p):
            continue
        o = pair_obstacle[p]
        distance, nx, ny, nz = distance_in_world(
            kind[o], size[o], rotation[o], origin[o], position[v, 0], position[v, 1], position[v, 2]
        )
        way = shell - pair_depth[p] - distance
        if way > 0.0:
            normal[p, 0], normal[p, 1], normal[p, 2] = nx, ny, nz
            position[v, 0] += way * nx
            position[v, 1] += way * ny
            position[v, 2] += way * nz
            pushed[p] += way
            most = max(most, way)
    return most


@kernel
def surface_displacement(x, y, z, origin, origin_before, turn):
    """Displacement in m during the substep of the obstacle's material at a world point.

    ``turn`` (3,) rad is the obstacle's rotation in the substep.
    """
    x -= origin[0]
    y -= origin[1]
    z -= origin[2]
    return (
        origin[0] - origin_before[0] + turn[1] * z - turn[2] * y,
        origin[1] - origin_before[1] + turn[2] * x - turn[0] * z,
        origin[2] - origin_before[2] + turn[0] * y - turn[1] * x,
    )


@kernel
def apply_friction(
    start, position, origin, origin_before, turn, friction, pair_vertex, pair_obstacle, pushed, normal, spent, left
):
    """Coulomb: take back the tangential way relative to the surface, friction * ``pushed`` in all at most.

    In displacements, not velocities: there it would creep. ``friction`` (O,) is that of each obstacle,
    ``spent`` (P,) m what earlier sweeps of the substep took back already. Where it leaves the vertices it notes in
    ``left`` (P, 3) m.
    """
    for p in range(pair_vertex.shape[0]):
        v = pair_vertex[p]
        if is_at(position, v, left, p):
            continue
        x, y, z = position[v, 0], position[v, 1], position[v, 2]
        left[p, 0], left[p, 1], left[p, 2] = x, y, z
        if pushed[p] <= 0.0:
            continue
        o = pair_obstacle[p]
        sx, sy, sz = surface_displacement(x, y, z, origin[o], origin_before[o], turn[o])
        wx, wy, wz = x - start[v, 0] - sx, y - start[v, 1] - sy, z - start[v, 2] - sz
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        along = wx * nx + wy * ny + wz * nz
        wx, wy, wz = wx - along * nx, wy - along * ny, wz - along * nz
        way = math.sqrt(wx * wx + wy * wy + wz * wz)
        most = max(0.0, friction[o] * pushed[p] - spent[p])
        if way > 0.0 and most > 0.0:
            taken = min(way, most)
            share = taken / way
            spent[p] += taken
            x, y, z = x - share * wx, y - share * wy, z - share * wz
            position[v, 0], position[v, 1], position[v, 2] = x, y, z
            left[p, 0], left[p, 1], left[p, 2] = x, y, z


@kernel
def contact_velocity(
    velocity,
    velocity_before,
    position,
    h,
    origin,
    origin_before,
    turn,
    restitution,
    rest_speed,
    pair_vertex,
    pair_obstacle,
    pushed,
    normal,
):
    """Set the normal velocity of touched vertices: the surface's own, plus what an impact gives back.

    A push-out is a correction of position, not an impulse: left in the velocity it would shoot the cloth
    away. Impacts slower than ``rest_speed`` m/s do not bounce.
    """
    for p in range(pair_vertex.shape[0]):
        if pushed[p] <= 0.0:
            continue
        v = pair_vertex[p]
        o = pair_obstacle[p]
        sx, sy, sz = surface_displacement(
            position[v, 0], position[v, 1], position[v, 2], origin[o], origin_before[o], turn[o]
        )
        nx, ny, nz = normal[p, 0], normal[p, 1], normal[p, 2]
        surface = (sx * nx + sy * ny + sz * nz) / h
        now = velocity[v, 0] * nx + velocity[v, 1] * ny + velocity[v, 2] * nz - surface
        before = velocity_before[v, 0] * nx + velocity_before[v, 1] * ny + velocity_before[v, 2] * nz - surface
        wanted = -restitution * before if before < -rest_speed else 0.0
        change = wanted - now
        velocity[v, 0] += change * nx
        velocity[v, 1] += change * ny
        velocity[v, 2] += change * nz
