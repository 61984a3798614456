"""How much of the ground a cloth covers, seen from above."""

from __future__ import annotations

import numpy as np

PIXEL = 5e-4
"""m."""


def shadow_area(position: np.ndarray, triangles: np.ndarray) -> float:
    """m^2 that ``triangles`` (T, 3) cover together, seen along z: pixels whose centre is in one of them."""
    corner = position[triangles][:, :, :2] / PIXEL
    low = np.floor(corner.min(axis=(0, 1))).astype(int)
    corner = corner - low
    extent = np.ceil(corner.max(axis=(0, 1))).astype(int) + 2
    covered = np.zeros(extent, bool)
    first = np.floor(corner.min(axis=1)).astype(int)
    reach = int(np.ceil((corner.max(axis=1) - corner.min(axis=1)).max())) + 2
    for step in np.ndindex(reach, reach):
        pixel = first + np.array(step)
        hit = pixel[_inside(pixel + 0.5, corner)]
        covered[hit[:, 0], hit[:, 1]] = True
    return float(covered.sum()) * PIXEL**2


def _inside(point: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """(T,) whether each point (T, 2) is in the triangle (T, 3, 2) of the same number, whichever way it is wound."""
    sides = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        along, to = corner[:, b] - corner[:, a], point - corner[:, a]
        sides.append(along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0])
    return (np.minimum.reduce(sides) >= 0.0) | (np.maximum.reduce(sides) <= 0.0)
