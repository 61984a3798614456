"""Building, memory, errors and queries of fields."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from cloth_core import Pose
from cloth_core.fields import Closed, Field, Pool, Solid, pooled
from cloth_core.fields.build import build
from cloth_core.kernels import kernel
from cloth_core.kernels.bricks import REACH, beyond_box
from cloth_core.kernels.contact import into_frame
from cloth_core.kernels.fields import field_distance


class Built(NamedTuple):
    """A field, what it was built of, and the seconds that took."""

    solid: Solid
    field: Field
    seconds: list[float]


def built(surface: Closed, voxel: float, query: str, repeats: int) -> Built:
    """Build it from the checked mesh, tree and all, on one thread."""
    build(Solid.of_surface(surface), 4.0 * voxel, query=query)  # compiles
    seconds = []
    for _ in range(repeats):
        began = time.perf_counter()
        solid = Solid.of_surface(surface)
        field = build(solid, voxel, query=query)
        seconds.append(time.perf_counter() - began)
    return Built(solid, field, seconds)


def shell_points(solid: Solid, surface: Closed, band: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points spread evenly over the shell of half thickness ``band`` m, and their exact distances."""
    random = np.random.default_rng(0)
    corner = surface.position[surface.triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    chosen = random.choice(len(corner), 2 * count, p=area / area.sum())
    foot = np.einsum("pn,pnk->pk", random.dirichlet(np.ones(3), 2 * count), corner[chosen])
    # Cubes of the shell that the surface is near, each as often as the others.
    cell = np.unique(np.floor((foot + random.uniform(-band, band, foot.shape)) / band).astype(int), axis=0)
    points = band * (cell[random.integers(0, len(cell), 4 * count)] + random.uniform(0, 1, (4 * count, 3)))
    distance = solid.measure(points)[0]
    within = np.flatnonzero(np.abs(distance) <= band)[:count]
    return points[within], distance[within]


@kernel
def near_pairs(real, whole, coarse, occupied, brick, node, fine, split, plane, points, rotation, origin, near, pairs):
    """Pairs of a point and a field that are nearer than ``near`` m: by a ball, by a box, by the field.

    ``pairs`` (3,) counts what passes each. Returns the sum of the distances, so that nothing is left out.
    """
    total = 0.0
    for f in range(real.shape[0]):  # the arrays of one field stay in the processor's cache
        turned, there = rotation[f], origin[f]
        for p in range(points.shape[0]):
            dx, dy, dz = points[p, 0] - there[0], points[p, 1] - there[1], points[p, 2] - there[2]
            if dx * dx + dy * dy + dz * dz > (real[f, REACH] + near) ** 2:
                continue
            pairs[0] += 1
            x, y, z = into_frame(turned, there, points[p, 0], points[p, 1], points[p, 2])
            if beyond_box(real, f, x, y, z, near):
                continue
            pairs[1] += 1
            distance, nx, ny, nz = field_distance(
                real, whole, coarse, occupied, brick, node, fine, split, plane, f, x, y, z
            )
            if distance < near:
                pairs[2] += 1
                total += distance + nx + ny + nz
    return total


def query_times(pool: Pool, side: int, steps: int, apart: float) -> tuple[np.ndarray, np.ndarray]:
    """ms of each step of ``side`` x ``side`` vertices, a cloth of 1 m, against all fields, which move; mean pairs.

    The fields stand anywhere within ``apart`` m of the middle of the cloth in each direction, and turn.
    """
    random = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-0.5, 0.5, side)]), axis=-1).reshape(-1, 2)
    points = np.column_stack([grid, 0.1 * np.sin(5.0 * grid[:, 0])])
    count, taken, pairs = len(pool.real), [], np.zeros((steps, 3), np.int64)
    turn = Rotation.random(count, rng=random)
    start = random.uniform(-apart, apart, (count, 3))
    for step in range(steps):
        poses = [
            Pose(tuple(start[f] + 0.01 * step * np.array([np.cos(f), np.sin(f), 0.0])), tuple(turn[f].as_quat()))
            for f in range(count)
        ]
        turn = Rotation.from_rotvec([0.0, 0.0, 0.05]) * turn
        rotation, origin = np.array([p.rotation for p in poses]), np.array([p.position for p in poses])
        began = time.perf_counter()
        near_pairs(*pool, points, rotation, origin, 0.01, pairs[step])
        taken.append(1e3 * (time.perf_counter() - began))
    return np.array(taken[1:]), pairs.mean(axis=0)


def crowd(field: Field, count: int) -> Pool:
    """As many fields, each with arrays of its own."""
    return pooled([field] * count)
