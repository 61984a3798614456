"""Surfaces made coarse enough to be drawn again and again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cloth_core.fields.surface import Closed

TRIANGLES_MOST = 2000
"""What viewers draw of a mesh, and what a message of it takes: 100 kB."""


@dataclass(frozen=True, eq=False)
class Outline:
    """Triangles for viewers; an outline equals itself alone, so that what is made of it can be kept.

    Args:
        corners: (3 T, 3) m.
    """

    corners: np.ndarray


def outline(surface: Closed, most: int = TRIANGLES_MOST) -> Outline:
    """A surface with no more than ``most`` triangles: vertices in the same cell of a grid become their mean.

    (Rossignac and Borrel 1993.) What was finer than a cell is lost.
    """
    position, triangles = surface
    cell = np.ptp(position, axis=0).max() / 256.0
    while len(triangles) > most:
        place = np.floor((surface.position - surface.position.min(axis=0)) / cell).astype(np.int64)
        _, member = np.unique(place, axis=0, return_inverse=True)
        member = member.ravel()
        count = np.bincount(member)
        position = np.stack([np.bincount(member, weights=x) / count for x in surface.position.T], axis=1)
        triangles = member[surface.triangles]
        a, b, c = triangles.T
        triangles = triangles[(a != b) & (b != c) & (c != a)]
        cell *= 1.2
    return Outline(np.ascontiguousarray(position[triangles]).reshape(-1, 3))
