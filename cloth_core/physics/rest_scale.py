"""Rest scale: groups of the cloth at other rest lengths than the mesh has, as a waistband that tightens.

Springs with both ends in a group, and triangles with all three corners in it, get shorter or longer at rest. The
matrices do not change: the stiffness of a spring does not depend on its rest length, and that of a triangle, which has
stretched sheet of the same modulus on a smaller area, does not change with its size (area times slope squared).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cloth_core.errors import InputError
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh

FASTEST = 1.0
"""1/s, share of their length by which rest lengths change at most: less than overlong threads are hauled in with."""


@dataclass(frozen=True, eq=False)
class RestShape:
    """The rest lengths that are in force, as a :class:`~cloth_core.mesh.ClothMesh` has them; arrays are read-only."""

    spring_rest: np.ndarray
    limit_rest: np.ndarray
    triangle_slope: np.ndarray
    triangle_area: np.ndarray

    def __post_init__(self) -> None:
        for array in vars(self).values():
            array.setflags(write=False)  # as those of a mesh are: to numba anything else is another type

    @classmethod
    def of(cls, mesh: ClothMesh) -> RestShape:
        """That of the mesh itself."""
        return cls(mesh.spring_rest, mesh.limit_rest, mesh.triangle_slope, mesh.triangle_area)


class Resized(Protocol):
    """Whoever computes with rest lengths."""

    def resize(self, rest: RestShape) -> None:
        """Compute with these from now on."""


class RestScale:
    """Follows the scales that are wished for, and tells whoever computes with rest lengths.

    Args:
        mesh: the cloth.
        material: decides whether springs or triangles carry the stretching.
        told: who computes with them; they begin with those of the mesh.
    """

    def __init__(self, mesh: ClothMesh, material: Material, told: Sequence[Resized] = ()) -> None:
        self._mesh, self._told, self._woven = mesh, told, mesh.is_membrane(material)
        self._parts: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._now: Mapping[str, float] = {}
        self._from: Mapping[str, float] = {}
        self._to: Mapping[str, float] = {}
        self.rest = RestShape.of(mesh)
        """What is in force."""

    def check(self, groups: Sequence[str]) -> None:
        """Refuse groups within which there is nothing to scale.

        Raises:
            InputError: naming the group, and what it lacks.
        """
        for group in groups:
            springs, triangles = self._part(group)
            if not len(triangles if self._woven else springs):
                kind = "triangle has all its corners" if self._woven else "spring has both its ends"
                raise InputError(f"rest_scale: no {kind} in the group {group}: nothing would change; take a wider one")

    def begin_step(self, before: Mapping[str, float], wanted: Mapping[str, float], time: float) -> dict[str, float]:
        """A step of ``time`` s begins at the scales ``before``; returns those at its end.

        They are as near to those ``wanted`` as :data:`FASTEST` allows. A group that is not named has the scale 1.
        """
        self.check(tuple(before.keys() | wanted.keys()))
        most, after = math.exp(FASTEST * time), {}
        for name in sorted(before.keys() | wanted.keys()):
            now, goal = before.get(name, 1.0), wanted.get(name, 1.0)
            scale = min(max(goal, now / most), now * most)
            if scale != 1.0:
                after[name] = scale
        self._from, self._to = before, after
        return after

    def begin_substep(self, share: float) -> None:
        """Go on to a ``share`` of the step, 0 to 1."""
        if self._from == self._to:
            return self._use(self._to)
        names = sorted(self._from.keys() | self._to.keys())
        both = [(name, self._from.get(name, 1.0), self._to.get(name, 1.0)) for name in names]
        return self._use({name: end if share >= 1.0 else start + share * (end - start) for name, start, end in both})

    def _use(self, scales: Mapping[str, float]) -> None:
        if scales == self._now:
            return
        self._now, self.rest = scales, self._scaled(scales)
        for one in self._told:
            one.resize(self.rest)

    def _scaled(self, scales: Mapping[str, float]) -> RestShape:
        """A function of the scales alone: where groups overlap, their product in the order of the alphabet."""
        mesh = self._mesh
        of_spring, of_triangle = np.ones(len(mesh.spring_rest)), np.ones(len(mesh.triangles))
        for name in sorted(scales):
            springs, triangles = self._part(name)
            of_spring[springs] *= scales[name]
            of_triangle[triangles] *= scales[name]
        slopes = of_triangle[: len(mesh.triangle_slope), None, None]
        return RestShape(
            mesh.spring_rest * of_spring,
            mesh.limit_rest * of_spring,
            mesh.triangle_slope / slopes,
            mesh.triangle_area * of_triangle**2,
        )

    def _part(self, group: str) -> tuple[np.ndarray, np.ndarray]:
        """The springs and the triangles within a group; of triangles that carry, a spring must not leave them."""
        if group not in self._parts:
            mesh, member = self._mesh, np.zeros(self._mesh.vertex_count, dtype=bool)
            member[mesh.group(group)] = True
            whole, springs = member[mesh.triangles].all(axis=1), member[mesh.spring_vertex].all(axis=1)
            if self._woven:
                outside = mesh.triangles[~whole]
                sides = np.concatenate([outside[:, [0, 1]], outside[:, [1, 2]], outside[:, [2, 0]]])
                springs &= ~np.isin(self._pair(mesh.spring_vertex), self._pair(sides))
            self._parts[group] = np.flatnonzero(springs), np.flatnonzero(whole)
        return self._parts[group]

    def _pair(self, ends: np.ndarray) -> np.ndarray:
        """(N,) one number for each pair of vertices (N, 2), whatever its order."""
        return ends.min(axis=1).astype(np.int64) * self._mesh.vertex_count + ends.max(axis=1)
