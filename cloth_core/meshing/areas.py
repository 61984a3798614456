"""Areas of triangles and of vertices."""

from __future__ import annotations

import numpy as np


def triangle_areas(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T,) m^2."""
    a, b, c = (position[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def vertex_areas(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(V,) m^2: a third of each adjoining triangle; their sum is the area of the sheet."""
    third = np.repeat(triangle_areas(position, triangles) / 3, 3)
    return np.bincount(triangles.ravel(), weights=third, minlength=len(position))
