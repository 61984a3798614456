"""Reach: how far apart two held places of a cloth can be before the cloth between them is at its stretch limit.

A flat sheet whose held points are pairwise no farther apart than the limit times their distance at rest can always
take a shape in which no thread is longer than that (Kirszbraun's theorem: a Lipschitz map of some points extends to
all). What is not flat reaches farther than the straight line: along its surface. That is looked up only when the
straight line is too short: a hand that closes does not wait for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.spatial.distance import cdist

from cloth_core.mesh import ClothMesh
from cloth_core.physics.ways import Ways

PINS = ""
"""Stands for the pinned vertices where others have the name of a grasp."""


@dataclass(frozen=True, eq=False)
class Tether:
    """Two sets of held vertices that the cloth joins: ``first`` is a grasp, ``second`` another one or ``PINS``."""

    first: str
    second: str
    first_rim: np.ndarray
    """(N,): the vertices of the first that have neighbours outside."""
    second_rim: np.ndarray
    """(M,): those of the second."""
    straight: np.ndarray
    """(N, M) m, how far apart they may be at the least: along straight lines; infinite where nothing joins them."""
    along_surface: Callable[[np.ndarray], np.ndarray]

    @cached_property
    def longest(self) -> np.ndarray:
        """(N, M) m, how far apart they may be."""
        return self.along_surface(self.straight)


class Tethers:
    """All tethers between sets of held vertices.

    Args:
        rims: the vertices on the rim of each set, by name of the grasp or ``PINS``, which come first.
        straight: (R, R') m, how far apart the vertices of all grasps' rims and those of all rims may be at the least.
        pairs: the tethers one by one.
    """

    def __init__(self, rims: dict[str, np.ndarray], straight: np.ndarray, pairs: list[Tether]) -> None:
        self.rims, self._straight, self._pairs = rims, straight, pairs

    def __len__(self) -> int:
        return len(self._pairs)

    def __iter__(self) -> Iterator[Tether]:
        return iter(self._pairs)

    def slack(self, places: np.ndarray, margin: float) -> bool:
        """Whether the rims, at ``places`` (R', 3) m one after the other, are surely within reach and ``margin`` m."""
        apart = cdist(places[len(places) - len(self._straight) :], places)
        apart -= self._straight
        return bool((apart <= margin).all())


class Reach:
    """Knows the cloth at rest; all it says follows from the held vertices alone, never from the order they came in.

    Args:
        mesh: the cloth.
        stretch_limit: longest a thread gets, as a multiple of its rest length.
        ways: of that mesh, if they are at hand.
    """

    def __init__(self, mesh: ClothMesh, stretch_limit: float, ways: Ways | None = None) -> None:
        self._rest, self._stretch_limit, self._looser = mesh.rest_position, stretch_limit, 1.0
        self.ways = ways or Ways(mesh)
        self._key: tuple[tuple[str, bytes], ...] | None = None
        self._tethers: Tethers

    def loosen(self, factor: float) -> None:
        """From now on all of the cloth counts as ``factor`` times as large, since some of it may be."""
        if factor != self._looser:
            self._looser, self._key = factor, None

    def tethers(self, held: Mapping[str, np.ndarray]) -> Tethers:
        """What joins the sets of ``held`` vertices, which are given by name of the grasp or as ``PINS``."""
        held = {name: held[name] for name in sorted(held) if len(held[name])}
        key = tuple((name, vertex.tobytes()) for name, vertex in held.items())
        if key != self._key:
            self._key, self._tethers = key, self._joined(held)
        return self._tethers

    def _joined(self, held: Mapping[str, np.ndarray]) -> Tethers:
        rims = {name: self.ways.rim(vertex) for name, vertex in held.items()}
        everyone = np.concatenate([*rims.values(), np.zeros(0, np.int64)])
        begins = dict(zip(rims, np.cumsum([0, *(len(rim) for rim in rims.values())]).tolist(), strict=False))
        pins = len(rims.get(PINS, ()))
        straight = self._straight(everyone[pins:], everyone)
        pairs = []
        marks = {name: _Landmarks(self.ways, self._rest, () if name == PINS else rims[name], everyone) for name in rims}
        for second, first in combinations(rims, 2):
            one, other = rims[first], rims[second]
            rows, columns = begins[first] - pins, begins[second]
            reach = straight[rows : rows + len(one), columns : columns + len(other)]
            if np.isfinite(reach).any():
                longer = _longer(self.ways, self._looser * self._stretch_limit, one, other, marks[first], marks[second])
                pairs.append(Tether(first, second, one, other, reach.copy(), longer))
        for name in rims.keys() - {PINS}:
            own = slice(begins[name], begins[name] + len(rims[name]))
            straight[begins[name] - pins : own.stop - pins, own] = np.inf
        return Tethers(rims, straight, pairs)

    def _straight(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        reach = self._looser * self._stretch_limit * (self.ways.straight * cdist(self._rest[first], self._rest[second]))
        return np.where(self.ways.part[first][:, None] == self.ways.part[second][None], reach, np.inf)


class _Landmarks:
    """Two vertices far apart on a rim, and the shortest ways from them; pins have none."""

    def __init__(self, ways: Ways, place: np.ndarray, rim: np.ndarray, wanted: np.ndarray) -> None:
        self._ways, self._place, self._rim, self._wanted = ways, place, rim, wanted

    @cached_property
    def ways(self) -> list[np.ndarray]:
        """(V,) m from each."""
        if len(self._rim) == 0:
            return []
        place = self._place[self._rim]
        one = int(np.argmax(np.linalg.norm(place - place.mean(axis=0), axis=1)))
        other = int(np.argmax(np.linalg.norm(place - place[one], axis=1)))
        return [self._ways.of(int(mark), self._wanted) for mark in np.unique(self._rim[[one, other]])]


def _longer(
    ways: Ways, limit: float, first: np.ndarray, second: np.ndarray, near_first: _Landmarks, near_second: _Landmarks
) -> Callable[[np.ndarray], np.ndarray]:
    """What makes the reach along ``straight`` lines, (N, M) m, the longer one that landmarks promise.

    The way from a to b is at least that from a landmark to b, less that from the landmark to a.
    """

    def reach(straight: np.ndarray) -> np.ndarray:
        if not ways.bend(first, second):
            return straight
        longest = straight
        for way in near_first.ways:
            longest = np.maximum(longest, limit * _less(way[second] / ways.detour, way[first]).T)
        for way in near_second.ways:
            longest = np.maximum(longest, limit * _less(way[first] / ways.detour, way[second]))
        return longest

    return reach


def _less(to: np.ndarray, off: np.ndarray) -> np.ndarray:
    """(len(to), len(off)) differences; zero where there is no way."""
    known = np.isfinite(to)[:, None] & np.isfinite(off)[None]
    return np.where(known, np.where(np.isfinite(to), to, 0.0)[:, None] - np.where(np.isfinite(off), off, 0.0), 0.0)
