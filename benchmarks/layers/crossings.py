"""How often a surface crosses itself, counted without any of the solver's code."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

FLAT = 1e-9
"""Sine of an angle below which an edge lies in the plane of a triangle."""


def crossing_triangles(position: np.ndarray, triangles: np.ndarray) -> int:
    """Pairs of triangles without common vertex that cross, at ``position`` (V, 3) m; 0 is clean.

    Two triangles cross if an edge of one runs through the other (Moeller and Trumbore 1997).
    """
    corners = position[triangles]
    middle = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    found = cKDTree(middle).query_pairs(2.0 * float(np.percentile(reach, 99.9)), output_type="ndarray")
    first, second = found.T
    near = (corners.min(axis=1)[first] <= corners.max(axis=1)[second]).all(axis=1)
    near &= (corners.min(axis=1)[second] <= corners.max(axis=1)[first]).all(axis=1)
    first, second = first[near], second[near]
    # Most lie on one side of each other.
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for _ in range(2):
        side = np.einsum("pij,pj->pi", corners[first] - corners[second][:, :1], normal[second])
        both = (side.min(axis=1) <= 0.0) & (side.max(axis=1) >= 0.0)
        first, second = second[both], first[both]
    apart = ~(triangles[first][:, :, None] == triangles[second][:, None, :]).any(axis=(1, 2))
    first, second = first[apart], second[apart]
    crosses = np.zeros(len(first), bool)
    for one, other in ((first, second), (second, first)):
        for k in range(3):
            crosses |= _runs_through(corners[one][:, k], corners[one][:, (k + 1) % 3], corners[other])
    return int(crosses.sum())


def _runs_through(start: np.ndarray, end: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    along, corner = end - start, triangle[:, 0]
    u_side, v_side = triangle[:, 1] - corner, triangle[:, 2] - corner
    p = np.cross(along, v_side)
    determinant = (u_side * p).sum(axis=1)
    size = np.linalg.norm(along, axis=1) * np.linalg.norm(u_side, axis=1) * np.linalg.norm(v_side, axis=1)
    askew = np.abs(determinant) > FLAT * size  # what lies in one plane but for rounding does not cross
    share = 1.0 / np.where(askew, determinant, 1.0)
    away = start - corner
    q = np.cross(away, u_side)
    u, v = (away * p).sum(axis=1) * share, (along * q).sum(axis=1) * share
    w = (v_side * q).sum(axis=1) * share
    return askew & (u > 0) & (v > 0) & (u + v < 1) & (w > 0) & (w < 1)
