"""Hinges between neighbouring triangles, for the quadratic bending energy."""

from __future__ import annotations

import numpy as np


def hinges(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hinges between neighbouring triangles and their weights.

    The energy of isometric bending is a constant quadratic form, so it lives inside W: each hinge adds
    bend / 2 * |K x|^2 / (A0 + A1) with K made of the cotangents of the rest shape (Bergou et al. 2006,
    "A quadratic bending model for inextensible surfaces", whose K this is; the factor is ours, chosen so
    that a cylinder of radius R stores bend / (2 R^2) per area).

    Returns:
        (H, 4) int32 vertices and (H, 4) weights K / sqrt(A0 + A1) in 1/m.
    """
    side = np.concatenate([triangles[:, [0, 1, 2]], triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
    key = np.sort(side[:, :2], axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    side, key = side[order], key[order]
    first = np.flatnonzero((key[1:] == key[:-1]).all(axis=1))
    v0, v1, v2, v3 = side[first, 0], side[first, 1], side[first, 2], side[first + 1, 2]
    x0, x1, x2, x3 = (position[v] for v in (v0, v1, v2, v3))
    at0_first, at0_second = _cotangent(x1 - x0, x2 - x0), _cotangent(x1 - x0, x3 - x0)
    at1_first, at1_second = _cotangent(x0 - x1, x2 - x1), _cotangent(x0 - x1, x3 - x1)
    k = np.stack(
        [at1_first + at1_second, at0_first + at0_second, -at0_first - at1_first, -at0_second - at1_second], axis=1
    )
    area = 0.5 * (
        np.linalg.norm(np.cross(x1 - x0, x2 - x0), axis=1) + np.linalg.norm(np.cross(x1 - x0, x3 - x0), axis=1)
    )
    vertices = np.stack([v0, v1, v2, v3], axis=1).astype(np.int32).reshape(-1, 4)
    return vertices, k / np.sqrt(area)[:, None]


def _cotangent(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return (u * v).sum(axis=1) / np.linalg.norm(np.cross(u, v), axis=1)
