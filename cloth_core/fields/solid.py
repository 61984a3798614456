"""Solids as arrays for the kernels: closed surfaces in trees, analytic shapes, and several of them together."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cloth_core.errors import MeshError, MeshWarning
from cloth_core.fields.normals import pseudonormals
from cloth_core.fields.surface import Closed
from cloth_core.kernels import solids as kernels
from cloth_core.kernels import tree
from cloth_core.meshing import checks
from cloth_core.obstacles import BOX, CAPSULE, ELLIPSOID, Obstacle
from cloth_core.pose import Pose


@dataclass(frozen=True, slots=True)
class Solid:
    """A union of closed surfaces and analytic shapes that stand still to each other.

    ``surfaces`` and ``shapes`` are what :mod:`cloth_core.kernels.solids` takes; ``low`` and ``high`` (3,) m the box
    around all of it.
    """

    surfaces: tuple[np.ndarray, ...]
    shapes: tuple[np.ndarray, ...]
    low: np.ndarray
    high: np.ndarray

    @classmethod
    def of_surface(cls, surface: Closed, pose: Pose | None = None, *, source: str = "the mesh") -> Solid:
        """One closed surface, moved to ``pose``.

        Where the surface passes through itself, what lies inside counts as inside and its triangles there are left
        out; a :class:`MeshWarning` names them.
        """
        position = surface.position if pose is None else pose.apply(surface.position)
        surfaces = _tree(position, surface.triangles, source)
        corner = surfaces[0].reshape(-1, 3)
        return cls(surfaces, _no_shapes(), corner.min(axis=0), corner.max(axis=0))

    @classmethod
    def of_shape(cls, shape: Obstacle) -> Solid:
        """One analytic shape where it stands at the start.

        Raises:
            MeshError: it is a plane, which goes on for ever.
        """
        if not np.isfinite(shape.reach):
            raise MeshError("a plane has no end: it cannot be part of a field; leave it an obstacle of its own")
        pose = shape.pose
        half = _half_extents(shape, pose.rotation)
        arrays = (
            np.array([shape.kind], np.int64),
            np.array([shape.size], float),
            pose.rotation[None].copy(),
            np.array([pose.position], float),
        )
        return cls(_no_surfaces(), arrays, pose.position - half, pose.position + half)

    @classmethod
    def union(cls, members: Sequence[Solid]) -> Solid:
        """All members together: the distance is the least of theirs.

        Raises:
            MeshError: there are none.
        """
        if not members:
            raise MeshError("a compound without members has no surface")
        shapes = tuple(np.concatenate(parts) for parts in zip(*(m.shapes for m in members), strict=True))
        surfaces = _concatenated([m.surfaces for m in members])
        low, high = np.min([m.low for m in members], axis=0), np.max([m.high for m in members], axis=0)
        return cls(surfaces, shapes, low, high)

    def measure(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Exact signed distance (N,) m, closest point (N, 3) m and outward unit normal (N, 3) of points (N, 3) m."""
        points = np.ascontiguousarray(points, float).reshape(-1, 3)
        distance, closest, normal = np.empty(len(points)), np.empty_like(points), np.empty_like(points)
        kernels.solid_distances(self.surfaces, self.shapes, points, distance, closest, normal)
        return distance, closest, normal


def _tree(position: np.ndarray, triangles: np.ndarray, source: str) -> tuple[np.ndarray, ...]:
    """One surface as the kernels know it."""
    normal, flat = pseudonormals(position, triangles)
    corner, count = np.ascontiguousarray(position[triangles]), len(triangles)
    order, first, last, child = (np.zeros(n, np.int64) for n in (count, 2 * count, 2 * count, 2 * count))
    branches = tree.build_tree(corner, order, first, last, child)
    first, last, child = first[:branches].copy(), last[:branches].copy(), child[:branches].copy()
    corner, normal, hidden = corner[order], normal[order], flat[order]
    box, dipole = np.empty((branches, 6)), np.empty((branches, 7))
    tree.measure_tree(corner, first, last, child, box, dipole)
    arrays = corner, normal, hidden, first, last, child, box, dipole
    root, by_winding = np.zeros(1, np.int64), np.zeros(1, bool)
    inside = np.zeros(count, bool)
    kernels.buried((*arrays, root, by_winding), inside)
    if inside.any():
        buried = checks.listed(np.sort(order[inside]))
        text = f"{source} passes through itself: triangles inside it do not count: {buried}"
        warnings.warn(text, MeshWarning, stacklevel=4)
        hidden |= inside
        by_winding[0] = True
    return (*arrays, root, by_winding)


def _half_extents(shape: Obstacle, rotation: np.ndarray) -> np.ndarray:
    """(3,) m: half the box around a shape, along the axes outside."""
    size = np.array(shape.size)
    if shape.kind == BOX:
        return np.abs(rotation) @ size
    if shape.kind == ELLIPSOID:
        return np.linalg.norm(rotation * size, axis=1)
    along = size[1] if shape.kind == CAPSULE else 0.0
    return size[0] + along * np.abs(rotation[:, 2])


def _no_shapes() -> tuple[np.ndarray, ...]:
    return np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3))


def _no_surfaces() -> tuple[np.ndarray, ...]:
    whole, none = np.zeros(0, np.int64), np.zeros(0, bool)
    return (
        np.zeros((0, 3, 3)), np.zeros((0, 7, 3)), none, whole, whole, whole,
        np.zeros((0, 6)), np.zeros((0, 7)), whole, none,
    )  # fmt: skip


def _concatenated(parts: Sequence[tuple[np.ndarray, ...]]) -> tuple[np.ndarray, ...]:
    """The trees one after the other, places of triangles and branches counted through."""
    moved, triangles, branches = [], 0, 0
    for corner, normal, hidden, first, last, child, box, dipole, root, by_winding in parts:
        places = first + triangles, last + triangles, np.where(child > 0, child + branches, 0)
        moved.append((corner, normal, hidden, *places, box, dipole, root + branches, by_winding))
        triangles, branches = triangles + len(corner), branches + len(child)
    return tuple(np.concatenate(arrays) for arrays in zip(*moved, strict=True))
