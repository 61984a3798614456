"""Reach: how far apart two held places of a cloth can be before the cloth between them is at its stretch limit.

A flat sheet whose held points are pairwise no farther apart than the limit times their distance at rest can always
take a shape in which no thread is longer than that (Kirszbraun's theorem: a Lipschitz map of some points extends to
all). What is not flat reaches farther than the straight line: along its surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial.distance import cdist

from cloth_core.mesh import ClothMesh

PINS = ""
"""Stands for the pinned vertices where others have the name of a grasp."""
DETOUR = 1.09
"""A way over edges and across the diagonals of triangle pairs, over the straight one, at the most: 1.035 on
equilateral triangles, 1 / cos(22.5 deg) = 1.082 on squares. Ways over springs that are no surface have no shortcut."""


@dataclass(frozen=True, eq=False)
class Tether:
    """Two sets of held vertices that the cloth joins: ``first`` is a grasp, ``second`` another one or ``PINS``."""

    first: str
    second: str
    first_rim: np.ndarray
    """(N,): the vertices of the first that have neighbours outside."""
    second_rim: np.ndarray
    """(M,): those of the second."""
    longest: np.ndarray
    """(N, M) m, how far apart they may be; infinite where nothing joins them."""


class Reach:
    """Knows the cloth at rest; all it says follows from the held vertices alone, never from the order they came in.

    Args:
        mesh: the cloth.
        stretch_limit: longest a thread gets, as a multiple of its rest length.
    """

    def __init__(self, mesh: ClothMesh, stretch_limit: float) -> None:
        self._mesh, self._stretch_limit = mesh, stretch_limit
        self._is_sheet = len(mesh.hinge_vertex) > 0
        count = mesh.vertex_count
        limited = mesh.spring_vertex[mesh.spring_limited]
        self._part = connected_components(_graph(limited, np.ones(len(limited)), count), directed=False)[1]
        if self._is_sheet:
            opposite, across = _unfolded(mesh.rest_position, mesh.hinge_vertex)
            pairs = np.concatenate([mesh.spring_vertex, opposite])
            self._ways = _graph(pairs, np.concatenate([mesh.spring_rest, across]), count)
            self._straight = 1.0
        else:
            self._ways = _graph(limited, mesh.spring_rest[mesh.spring_limited], count)
            # Springs may be shorter at rest than as placed, and then all that they join is.
            placed = np.linalg.norm(np.diff(mesh.rest_position[limited], axis=1)[:, 0], axis=1)
            rest = mesh.spring_rest[mesh.spring_limited]
            self._straight = float(min(1.0, (rest / np.maximum(placed, 1e-12)).min(initial=1.0)))
        self._key: tuple[tuple[str, bytes], ...] = ()
        self._tethers: list[Tether] = []

    def tethers(self, held: Mapping[str, np.ndarray]) -> list[Tether]:
        """What joins the sets of ``held`` vertices, which are given by name of the grasp or as ``PINS``."""
        held = {name: held[name] for name in sorted(held) if len(held[name])}
        key = tuple((name, vertex.tobytes()) for name, vertex in held.items())
        if key != self._key:
            self._key, self._tethers = key, self._joined(held)
        return self._tethers

    def _joined(self, held: Mapping[str, np.ndarray]) -> list[Tether]:
        names = list(held)
        if len(names) < 2:
            return []
        rims = {name: self._rim(vertex) for name, vertex in held.items()}
        ways = {name: self._ways_from(rims[name]) for name in names if name != PINS}
        tethers = []
        for second, first in ((b, a) for n, b in enumerate(names) for a in names[n + 1 :]):
            longest = self._longest(rims[first], rims[second], ways[first], ways.get(second))
            if np.isfinite(longest).any():
                tethers.append(Tether(first, second, rims[first], rims[second], longest))
        return tethers

    def _rim(self, vertex: np.ndarray) -> np.ndarray:
        """Those that a spring joins to others: what is inside moves with them anyhow."""
        inside = np.zeros(self._mesh.vertex_count, dtype=bool)
        inside[vertex] = True
        pair = self._mesh.spring_vertex
        leaving = pair[inside[pair[:, 0]] != inside[pair[:, 1]]].ravel()
        return np.unique(leaving[inside[leaving]])

    def _ways_from(self, rim: np.ndarray) -> list[tuple[int, np.ndarray]]:
        """Shortest ways over the cloth, (V,) m, from two vertices far apart on the ``rim``."""
        if len(rim) == 0:
            return []
        place = self._mesh.rest_position[rim]
        one = int(np.argmax(np.linalg.norm(place - place.mean(axis=0), axis=1)))
        other = int(np.argmax(np.linalg.norm(place - place[one], axis=1)))
        marks = rim[[one, other]] if one != other else rim[[one]]
        return list(zip(marks.tolist(), dijkstra(self._ways, directed=False, indices=marks), strict=True))

    def _longest(
        self,
        first: np.ndarray,
        second: np.ndarray,
        first_ways: list[tuple[int, np.ndarray]],
        second_ways: list[tuple[int, np.ndarray]] | None,
    ) -> np.ndarray:
        """(N, M) m: the stretch limit times the larger of the straight line and the way that landmarks promise.

        The way from a to b is at least that from a landmark to b, less that from the landmark to a.
        """
        rest = self._mesh.rest_position
        reach = self._straight * cdist(rest[first], rest[second])
        joined = self._part[first][:, None] == self._part[second][None]
        detour = DETOUR if self._is_sheet else 1.0
        for _, way in first_ways:
            reach = np.maximum(reach, np.where(joined, _less(way[second] / detour, way[first]).T, 0.0))
        for _, way in second_ways or []:
            reach = np.maximum(reach, np.where(joined, _less(way[first] / detour, way[second]), 0.0))
        return np.where(joined, self._stretch_limit * reach, np.inf)


def _less(to: np.ndarray, off: np.ndarray) -> np.ndarray:
    """(len(to), len(off)) differences; zero where there is no way."""
    known = np.isfinite(to)[:, None] & np.isfinite(off)[None]
    return np.where(known, np.where(np.isfinite(to), to, 0.0)[:, None] - np.where(np.isfinite(off), off, 0.0), 0.0)


def _graph(pairs: np.ndarray, length: np.ndarray, count: int) -> csr_matrix:
    # Shortest first: of two between the same vertices, that one counts.
    order = np.argsort(length, kind="stable")
    pairs, length = np.sort(pairs[order], axis=1), np.maximum(length[order], 1e-12)
    first = np.unique(pairs, axis=0, return_index=True)[1]
    return csr_matrix((length[first], tuple(pairs[first].T)), shape=(count, count))


def _unfolded(position: np.ndarray, hinge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The two vertices opposite each shared edge, and their distance (H,) m once the hinge is laid flat."""
    a, b, c, d = (position[column] for column in hinge.T)
    axis = b - a
    length = np.linalg.norm(axis, axis=1)
    axis = axis / length[:, None]
    along = ((d - c) * axis).sum(axis=1)
    up, down = (np.linalg.norm(np.cross(axis, corner - a), axis=1) for corner in (c, d))
    return hinge[:, 2:], np.hypot(along, up + down)
