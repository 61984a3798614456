"""Readings of curvature on any triangulation, for the quadratic bending energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from cloth_core.meshing.areas import vertex_areas
from cloth_core.meshing.hinges import hinges

FEWEST = 3
"""Inner neighbours that an inner vertex must have to be read."""
ENOUGH = 1.5
"""Readings for each vertex of a part of the sheet that leave no shape but the flat ones unread; measured."""


@dataclass(frozen=True)
class Readings:
    """Sums over a few vertices each; bending energy is bend / 2 * sum of |reading of the positions|^2.

    Args:
        start: (R + 1,) int32, where a reading begins in the next two.
        vertex: (N,) int32.
        weight: (N,) 1/m.
    """

    start: np.ndarray
    vertex: np.ndarray
    weight: np.ndarray

    @classmethod
    def joined(cls, vertices: list[np.ndarray], weights: list[np.ndarray]) -> Readings:
        """Of blocks of readings, (R_b, n_b) each, in order."""
        length = np.concatenate([np.full(len(block), block.shape[1]) for block in vertices] or [np.zeros(0, int)])
        return cls(
            np.concatenate([[0], np.cumsum(length)]).astype(np.int32),
            np.concatenate([block.ravel() for block in vertices] or [np.zeros(0)]).astype(np.int32),
            np.concatenate([block.ravel() for block in weights] or [np.zeros(0)]).astype(float),
        )


def readings(position: np.ndarray, triangles: np.ndarray) -> Readings:
    """What a triangulated sheet that was flat resists: the Hessian of its positions, bend / 2 * |H|^2 per area.

    The Hessian of the shape at an inner vertex is read weakly, as a mean over the triangles around it of the gradients
    of shape and hat function (Stein, Grinspun, Wardetzky and Jacobson 2018, "Natural boundary conditions for smoothing
    in geometry processing"), here with the ring of triangles laid flat. It is a plate of Poisson ratio 0 whose free
    edges carry no moment. Vertices at the border are not read; inner neighbours answer for their area. Where no
    corner of a triangle is read, as in narrow straps and sheets of a few cells, its hinges are: these leave no shape
    unread, but make a plate that depends on the mesh, by a fifth of its stiffness.
    """
    rings = _Rings(position, triangles)
    area = rings.area_answered_for(vertex_areas(position, triangles))
    vertices, weights = [], []
    for valence in np.unique(rings.valence):
        chosen = rings.valence == valence
        center, around = rings.center[chosen], rings.around[chosen, :valence]
        ring = np.concatenate([center[:, None], around], axis=1)
        # Readings of a vertex stand side by side: xx, yy, and xy counted twice.
        hessian = np.sqrt(area[center])[:, None, None] * _hessian(*rings.flat(chosen, valence))
        vertices.append(np.repeat(ring, 3, axis=0))
        weights.append(hessian.reshape(-1, valence + 1))
    hinge_vertex, hinge_weight = hinges(position, triangles)
    bare = rings.bare_edges(hinge_vertex[:, :2])
    return Readings.joined([*vertices, hinge_vertex[bare]], [*weights, hinge_weight[bare]])


def _hessian(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(N, 3, n + 1) weights in 1/m^2 of xx, yy and sqrt(2) xy for the centre, at the origin, and its ring (N, n)."""
    next_x, next_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    double = x * next_y - y * next_x
    # Of the hat function, and of a unit height of this and of the next vertex of the ring, times twice the area.
    hat = np.stack([y - next_y, next_x - x])
    this, following = np.stack([next_y, -next_x]), np.stack([-y, x])
    area = double.sum(axis=1)[:, None] / 6.0
    made = np.empty((len(x), 3, x.shape[1] + 1))
    for row, parts in enumerate((((0, 0, 1.0),), ((1, 1, 1.0),), ((0, 1, np.sqrt(0.5)), (1, 0, np.sqrt(0.5))))):
        weight = np.zeros_like(x)
        for a, b, share in parts:
            slope = -0.5 * share * hat[a] / double / area
            weight += slope * this[b] + np.roll(slope * following[b], 1, axis=1)
        made[:, row, 1:] = weight
        made[:, row, 0] = -weight.sum(axis=1)
    return made


class _Rings:
    """The triangles around each inner vertex, in order.

    Attributes:
        center: (N,) inner vertices.
        valence: (N,).
        around: (N, largest valence) their neighbours, counter-clockwise.
    """

    def __init__(self, position: np.ndarray, triangles: np.ndarray) -> None:
        self._triangles, count = triangles, len(position)
        corner = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]]).astype(np.int64)
        self._number, key = np.bincount(corner[:, 0], minlength=count), corner[:, 0] * count + corner[:, 1]
        corner = corner[np.argsort(key)]
        key = np.sort(key)
        onward = np.searchsorted(key, corner[:, 0] * count + corner[:, 2])
        closed = key[np.minimum(onward, len(key) - 1)] == corner[:, 0] * count + corner[:, 2]
        inner = self._number > 0
        inner[corner[~closed, 0]] = False
        self.center = np.flatnonzero(inner)
        self.valence = self._number[self.center]
        at = np.searchsorted(key, self.center * count)
        steps = [at]
        for _ in range(int(self.valence.max(initial=1))):
            steps.append(onward[steps[-1]])
        walked = np.stack(steps, axis=1)
        angle, length = (
            _angles(position, corner),
            np.linalg.norm(position[corner[:, 1]] - position[corner[:, 0]], axis=1),
        )
        self.around, self._angle, self._length = (
            corner[walked[:, :-1], 1],
            angle[walked[:, :-1]],
            length[walked[:, :-1]],
        )
        self._keep(self._whole(walked))
        self._mark(count)
        self._keep((self._is_inner[self.around] & self._within()).sum(axis=1) >= FEWEST)
        self._keep(self._enough(count))
        self._mark(count)

    def _whole(self, walked: np.ndarray) -> np.ndarray:
        """(N,) bool: rings that close after all triangles of their vertex, none of which takes half the turn."""
        row = np.arange(len(walked))
        beyond = np.arange(self._angle.shape[1]) >= self.valence[:, None]
        self._angle[beyond] = 0.0
        again = ((walked[:, 1:] == walked[:, :1]) & ~beyond).sum(axis=1) == 1
        closes = walked[row, self.valence] == walked[:, 0]
        return closes & again & (self._angle.max(axis=1, initial=0.0) < 0.499 * self._angle.sum(axis=1))

    def _enough(self, count: int) -> np.ndarray:
        """(N,) bool: centres in parts of the sheet with many readings for their vertices."""
        sides = self._triangles[:, [0, 1, 1, 2]].reshape(-1, 2).T
        part = connected_components(coo_matrix((np.ones(sides.shape[1]), sides), shape=(count, count)), False)[1]
        readings = 3 * np.bincount(part[self.center], minlength=count)
        return (readings >= ENOUGH * np.bincount(part, minlength=count))[part[self.center]]

    def _mark(self, count: int) -> None:
        self._is_inner = np.zeros(count, bool)
        self._is_inner[self.center] = True

    def _keep(self, chosen: np.ndarray) -> None:
        for name in ("center", "valence", "around", "_angle", "_length"):
            setattr(self, name, getattr(self, name)[chosen])

    def flat(self, chosen: np.ndarray, valence: int) -> tuple[np.ndarray, np.ndarray]:
        """x and y (n, ``valence``) m of the rings that are ``chosen``, laid flat about their centres.

        Lengths stay, angles are scaled to make a full turn.
        """
        angle, length = self._angle[chosen, :valence], self._length[chosen, :valence]
        turn = 2.0 * np.pi * (np.cumsum(angle, axis=1) - angle) / angle.sum(axis=1)[:, None]
        return length * np.cos(turn), length * np.sin(turn)

    def area_answered_for(self, area: np.ndarray) -> np.ndarray:
        """(V,) m^2 of ``area`` once each vertex that is not inner has given its own to inner neighbours, if any."""
        given = np.zeros_like(area)
        center, around = np.repeat(self.center, self.valence), self.around[self._within()]
        outer = ~self._is_inner[around]
        takers = np.bincount(around[outer], minlength=len(area))
        np.add.at(given, center[outer], area[around[outer]] / takers[around[outer]])
        return np.where(self._is_inner, area, 0.0) + given

    def bare_edges(self, edges: np.ndarray) -> np.ndarray:
        """Of ``edges`` (H, 2), those at a triangle without inner corners."""
        bare = self._triangles[~self._is_inner[self._triangles].any(axis=1)]
        count = len(self._is_inner)
        sides = np.sort(np.concatenate([bare[:, :2], bare[:, 1:], bare[:, [2, 0]]]), axis=1).astype(np.int64)
        edges = np.sort(edges, axis=1).astype(np.int64)
        return np.flatnonzero(np.isin(edges[:, 0] * count + edges[:, 1], sides[:, 0] * count + sides[:, 1]))

    def _within(self) -> np.ndarray:
        return np.arange(self.around.shape[1]) < self.valence[:, None]


def _angles(position: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """(C,) rad at the first of the three vertices of each ``corner`` (C, 3)."""
    u, v = position[corner[:, 1]] - position[corner[:, 0]], position[corner[:, 2]] - position[corner[:, 0]]
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1))
