"""Parts of a mesh on which the shortest way between any two vertices is the straight line."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

FLAT = 1e-9
"""Of the extent of a part: what sticks out by less lies in the plane; likewise for areas."""


def flat_and_convex(place: np.ndarray, triangles: np.ndarray, component: np.ndarray) -> np.ndarray:
    """Whether each vertex belongs to a sheet that lies flat, without folds, holes or notches; (V,) bool.

    Args:
        place: (V, 3) m.
        triangles: (T, 3).
        component: (V,) number of the connected part of each vertex.
    """
    found = np.zeros(len(place), dtype=bool)
    of_triangle = component[triangles[:, 0]]
    for number in np.unique(of_triangle):
        vertices = np.flatnonzero(component == number)
        found[vertices] = _is_flat_and_convex(place, vertices, triangles[of_triangle == number])
    return found


def _is_flat_and_convex(place: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> bool:
    points = place - place[vertices].mean(axis=0)
    spread, axes = np.linalg.eigh(points[vertices].T @ points[vertices])
    extent = np.abs(points[vertices] @ axes[:, 2]).max()
    if np.abs(points[vertices] @ axes[:, 0]).max() > FLAT * extent or spread[1] <= 0.0:
        return False
    plane = points @ axes[:, 1:]
    a, b, c = (plane[column] for column in triangles.T)
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    if not ((area > 0.0).all() or (area < 0.0).all()):
        return False
    outline = ConvexHull(plane[vertices]).volume  # in the plane, the area
    return bool(abs(np.abs(area).sum() - outline) <= FLAT * outline)
