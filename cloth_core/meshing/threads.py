"""Directions of the threads in triangles and along edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cloth_core.errors import MeshError
from cloth_core.meshing import checks

UPRIGHT = 1e-6
"""Sine of the angle below which a warp counts as normal to a triangle."""
ASIDE = np.array([0.25, 0.5, 0.125])
"""Added to the turned coordinates of such a warp, which else may be normal, too: (1, 1, 1)."""


def direction(warp: Sequence[float]) -> np.ndarray:
    """(3,) unit vector along the ``warp``.

    Raises:
        MeshError: it is no direction.
    """
    (along,) = checks.as_numbers("warp", [warp], 3, "")
    length = np.linalg.norm(along)
    if not 1e-150 < length < 1e150:
        raise MeshError(f"warp {warp} is not a direction: three finite numbers, not all of them 0")
    return along / length


def slopes(position: np.ndarray, triangles: np.ndarray, warp: np.ndarray) -> np.ndarray:
    """(T, 3, 2) 1/m: how fast the share of each corner grows along the warp and along the weft of its triangle.

    ``slopes * positions``, summed over the corners, are the columns of the deformation gradient: what a metre of
    thread has become. The threads of a triangle are the ``warp`` (3,) laid into its plane, and across it; where the
    warp is normal to the plane, its coordinates in turn stand for it.
    """
    corner = [position[triangles[:, k]] for k in range(3)]
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    double = np.linalg.norm(normal, axis=1)[:, None]
    normal = normal / double
    along = _laid(warp, normal)
    upright = np.linalg.norm(along, axis=1) < UPRIGHT
    along[upright] = _laid(np.roll(warp, 1) + ASIDE, normal)[upright]
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(normal, along)
    made = np.empty((len(triangles), 3, 2))
    for k in range(3):
        gradient = np.cross(normal, corner[(k + 2) % 3] - corner[(k + 1) % 3]) / double
        made[:, k, 0], made[:, k, 1] = (gradient * along).sum(axis=1), (gradient * across).sum(axis=1)
    return made


def bias(along: np.ndarray, warp: np.ndarray) -> np.ndarray:
    """(S,) how much longer a trellis of inextensible threads can get in the directions ``along`` (S, 3), as a ratio.

    At an angle a to the warp, shearing by g makes a length sqrt(1 + sin g sin 2a) of what it was.
    """
    cosine = np.clip(np.abs(along @ warp) / np.linalg.norm(along, axis=1), 0.0, 1.0)
    return np.sqrt(1.0 + 2.0 * cosine * np.sqrt(1.0 - cosine * cosine))


def _laid(vector: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(T, 3): the part of a ``vector`` (3,) that lies in the plane of each unit ``normal`` (T, 3)."""
    return vector - (normal @ vector)[:, None] * normal
