"""What is measured on the positions that an engine gives back."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree
from workload import SPHERE_CENTER, SPHERE_RADIUS, Scene


def stretch(scene: Scene, position: np.ndarray) -> np.ndarray:
    """(E,) how much longer each edge of the grid is than at rest, as a ratio."""
    along = position[scene.edges[:, 0]] - position[scene.edges[:, 1]]
    return np.linalg.norm(along, axis=1) / scene.spacing - 1.0


def depth_in_sphere(position: np.ndarray) -> float:
    """Of the deepest vertex, m; negative outside."""
    return float((SPHERE_RADIUS - np.linalg.norm(position - SPHERE_CENTER, axis=1)).max())


def canonical_order(scene: Scene, position: np.ndarray) -> np.ndarray:
    """(V,) the engine's number of each vertex of the scene, found by where it stands at the start.

    Raises:
        ValueError: the engine's cloth does not stand where the scene has it.
    """
    if position.shape != scene.start.shape:
        raise ValueError(f"positions have the shape {position.shape}, not {scene.start.shape}")
    distance, number = cKDTree(position).query(scene.start)
    if distance.max() > 0.25 * scene.spacing or len(np.unique(number)) < len(number):
        raise ValueError(f"the cloth does not start in its place: a vertex is {distance.max():.3g} m off")
    return number


def self_crossings(scene: Scene, position: np.ndarray) -> int:
    """How many pairs of an edge and a triangle without common vertex cross each other; 0 is clean."""
    triangle = scene.triangles
    sides = np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]])
    edge = np.unique(np.sort(sides, axis=1), axis=0)
    near = 1.5 * scene.spacing * max(1.0, 1.0 + float(np.percentile(stretch(scene, position), 99)))
    centers = cKDTree(position[edge].mean(axis=1)), cKDTree(position[triangle].mean(axis=1))
    pairs = centers[0].sparse_distance_matrix(centers[1], near, output_type="coo_matrix")
    edge, triangle = edge[pairs.row], triangle[pairs.col]
    apart = ~((edge[:, :1] == triangle) | (edge[:, 1:] == triangle)).any(axis=1)
    return int(_crosses(position, edge[apart], triangle[apart]).sum())


def _crosses(position: np.ndarray, edge: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """(P,) bool: whether each edge runs through its triangle (Moeller and Trumbore 1997)."""
    origin = position[edge[:, 0]]
    along = position[edge[:, 1]] - origin
    corner = position[triangle[:, 0]]
    first, second = position[triangle[:, 1]] - corner, position[triangle[:, 2]] - corner
    p = np.cross(along, second)
    determinant = (first * p).sum(axis=1)
    askew = np.abs(determinant) > 1e-14
    determinant = np.where(askew, determinant, 1.0)
    away = origin - corner
    q = np.cross(away, first)
    u = (away * p).sum(axis=1) / determinant
    v = (along * q).sum(axis=1) / determinant
    w = (second * q).sum(axis=1) / determinant
    return askew & (u > 0) & (v > 0) & (u + v < 1) & (w > 0) & (w < 1)
