"""Rectangles: see :meth:`cloth_core.mesh.ClothMesh.grid`."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from cloth_core.errors import MeshError, shown
from cloth_core.meshing.areas import vertex_areas
from cloth_core.meshing.checks import is_positive
from cloth_core.meshing.directions import SHEAR, WARP, WEFT
from cloth_core.meshing.faults import ATOM, LARGEST_COORDINATE, SLIVER
from cloth_core.meshing.grid_curvature import readings
from cloth_core.meshing.hinges import hinges
from cloth_core.meshing.threads import slopes


def fields(width: float, height: float, columns: int, rows: int) -> dict[str, Any]:
    """The fields of the mesh."""
    _check(width, height, columns, rows)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    position = np.column_stack([(uv - 0.5) * [width, height], np.zeros(len(uv))])
    number = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    triangles = _alternating_triangles(number)
    dx, dy = width / (columns - 1), height / (rows - 1)
    springs, weight, limited = _springs(number, dx, dy)
    curvature = readings(number, dx, dy)
    return dict(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=np.linalg.norm(position[springs[:, 0]] - position[springs[:, 1]], axis=1),
        spring_weight=weight,
        spring_limited=limited,
        spring_bias=np.ones(len(springs)),
        triangle_slope=slopes(position, triangles, np.array([0.0, 1.0, 0.0])),
        hinge_vertex=hinges(position, triangles)[0],
        curvature_start=curvature.start,
        curvature_vertex=curvature.vertex,
        curvature_weight=curvature.weight,
        vertex_area=vertex_areas(position, triangles),
        uv=uv,
        groups=_groups(number),
    )


def _check(width: float, height: float, columns: int, rows: int) -> None:
    for name, count in (("columns", columns), ("rows", rows)):
        if not _is_count(count):
            raise MeshError(f"{name}: {shown(count)} is not a whole number of at least 2 (vertices of the grid)")
    largest = 2 * LARGEST_COORDINATE
    for name, extent in (("width", width), ("height", height)):
        if not is_positive(extent) or extent > largest:
            raise MeshError(f"{name}: {shown(extent)} is not a positive number up to {largest:g} m")
    dx, dy = width / (columns - 1), height / (rows - 1)
    if min(dx, dy) < max(SLIVER * max(dx, dy), ATOM):
        least = f"less than {SLIVER:g} of the other or {ATOM:g} m"
        raise MeshError(f"the cells of the grid are {dx:g} x {dy:g} m, one side {least}: change columns or rows")


def _is_count(count: Any) -> bool:
    try:
        return operator.index(count) >= 2
    except TypeError:
        return False


def _alternating_triangles(number: np.ndarray) -> np.ndarray:
    """Two triangles a cell; the diagonal alternates so that no direction of the sheet is preferred."""
    a, b, c, d = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    rows, columns = a.shape
    even = (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0).ravel()[:, None, None]
    rising = np.stack([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)], axis=1)
    falling = np.stack([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)], axis=1)
    return np.where(even, rising, falling).reshape(-1, 3).astype(np.int32)


def _springs(number: np.ndarray, dx: float, dy: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Threads and both diagonals of every cell of ``dx`` x ``dy`` m: vertices, weights, and whether limited."""
    rows, columns = number.shape
    along_x = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    along_y = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    rising = np.stack([number[:-1, :-1].ravel(), number[1:, 1:].ravel()], axis=1)
    falling = np.stack([number[:-1, 1:].ravel(), number[1:, :-1].ravel()], axis=1)
    springs = np.concatenate([along_x, along_y, rising, falling])
    share_x = np.ones((rows, columns - 1))
    share_x[[0, -1]] = 0.5  # a border thread carries half a strip
    share_y = np.ones((rows - 1, columns))
    share_y[:, [0, -1]] = 0.5
    weight = np.zeros((len(springs), 4))
    x, y = len(along_x), len(along_x) + len(along_y)
    weight[:x, WEFT] = share_x.ravel() * dy / dx
    weight[x:y, WARP] = share_y.ravel() * dx / dy
    # Shearing a cell by g lengthens each diagonal by g dx dy / length; the two together store shear/2 g^2 per area.
    weight[y:, SHEAR] = (dx * dx + dy * dy) / (2 * dx * dy)
    # What the diagonals carry along the threads, these do not.
    weight[:x, SHEAR] = -share_x.ravel() * dx / dy
    weight[x:y, SHEAR] = -share_y.ravel() * dy / dx
    order = np.lexsort((springs.max(axis=1), springs.min(axis=1)))
    return springs[order].astype(np.int32), weight[order], (np.arange(len(springs)) < y)[order]


def _groups(number: np.ndarray) -> dict[str, np.ndarray]:
    names = dict(left=number[:, 0], right=number[:, -1], top=number[-1], bottom=number[0])
    names["corners"] = number[[-1, -1, 0, 0], [0, -1, 0, -1]]
    for corner, name in zip(names["corners"], ("top_left", "top_right", "bottom_left", "bottom_right"), strict=True):
        names[name] = corner.reshape(1)
    return {name: np.ascontiguousarray(group) for name, group in names.items()}
