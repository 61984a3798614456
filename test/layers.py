"""Several sheets as one mesh, and slow twins of what keeps them apart: written from definitions, to compare with."""

from __future__ import annotations

import itertools

import numpy as np

from cloth_core import ClothMesh


def sheets(*offsets: tuple[float, float, float], side: float = 0.3, count: int = 10) -> ClothMesh:
    """Square sheets of ``count`` vertices a side that lie level, each at its offset; pieces of one mesh."""
    grid = ClothMesh.grid(width=side, height=side, columns=count, rows=count)
    place = np.concatenate([grid.rest_position + offset for offset in offsets])
    triangles = np.concatenate([grid.triangles + n * grid.vertex_count for n in range(len(offsets))])
    return ClothMesh.from_triangles(place, triangles)


def closest_on_segment(p, a, b):
    """The point of a segment closest to ``p``."""
    along = b - a
    return a + np.clip((p - a) @ along / (along @ along), 0.0, 1.0) * along


def vertex_triangle(p, a, b, c):
    """Distance of a point from a triangle: to its plane if it is above the inside, else to the nearest side."""
    plane = np.stack([b - a, c - a], axis=1)
    share, *_ = np.linalg.lstsq(plane, p - a, rcond=None)
    if (share >= 0).all() and share.sum() <= 1:
        return np.linalg.norm(p - a - plane @ share)
    return min(np.linalg.norm(p - closest_on_segment(p, *side)) for side in ((a, b), (b, c), (c, a)))


def edge_edge(a, b, c, d):
    """Distance of two segments: of their lines where these come closest inside both, else from an end."""
    lines = np.stack([b - a, c - d], axis=1)
    share, _, rank, _ = np.linalg.lstsq(lines, c - a, rcond=None)
    found = [np.linalg.norm(p - closest_on_segment(p, c, d)) for p in (a, b)]
    found += [np.linalg.norm(p - closest_on_segment(p, a, b)) for p in (c, d)]
    if rank == 2 and ((share >= 0) & (share <= 1)).all():
        found.append(np.linalg.norm(lines @ share - (c - a)))
    return min(found)


def distance(x, row, edges):
    """Of the two features of a pair, m."""
    return (edge_edge if edges else vertex_triangle)(*x[list(row)])


def meeting(start, end, row, edges):
    """The first share of straight ways at which two features meet, or -1: the roots of the cubic by its companion."""
    first, last = start[list(row)], end[list(row)]
    way = last - first
    coefficients = np.zeros(4)
    for power in itertools.product((0, 1), repeat=3):
        columns = [(way if k else first)[n + 1] - (way if k else first)[0] for n, k in enumerate(power)]
        coefficients[3 - sum(power)] += np.linalg.det(np.stack(columns))
    roots = np.roots(coefficients)
    times = np.sort(roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real >= 0) & (roots.real <= 1)])
    for t in times:
        if (edge_edge if edges else vertex_triangle)(*(first + t * way)) < 1e-7:
            return t
    return -1.0


def push_apart(start, x, contacts, inverse_mass, mu, pushed, spent, idle):
    """Each contact in turn: opposite impulses bring it to its target, friction takes back of its tangential way."""
    x, pushed, spent = x.copy(), pushed.copy(), spent.copy()
    for c, (row, weight, normal, target) in enumerate(zip(*contacts, strict=True)):
        relative = weight @ x[row]
        lacking = target - normal @ relative
        if lacking <= (idle * target if pushed[c] > 0 else 0.0):
            continue
        pushed[c] += lacking
        way = relative - weight @ start[row]
        way -= (normal @ way) * normal
        length = np.linalg.norm(way)
        taken = max(0.0, min(length, mu * pushed[c] - spent[c]))
        spent[c] += taken
        wanted = lacking * normal - (taken * way / length if length else 0.0)
        x[row] += np.outer(weight * inverse_mass[row], wanted) / (weight**2 @ inverse_mass[row])
    return x, pushed, spent


def runs_through(p, q, a, b, c):
    """Whether an edge runs through a triangle: solved for the shares of its corners and of the edge."""
    try:
        u, v, t = np.linalg.solve(np.stack([b - a, c - a, p - q], axis=1), p - a)
    except np.linalg.LinAlgError:
        return False
    return bool(u > 0 and v > 0 and u + v < 1 and 0 < t < 1)
