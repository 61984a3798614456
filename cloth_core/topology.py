"""Building meshes: from rectangles, triangulations and bare springs to springs, hinges and areas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cloth_core.errors import MeshError

WARP, WEFT, SHEAR, GIVEN = range(4)


def check_positions(position: np.ndarray) -> None:
    """Refuse an empty or non-finite (V, 3) array, naming the vertices."""
    if position.ndim != 2 or position.shape[1] != 3 or len(position) == 0:
        raise MeshError(f"positions must have the shape (V, 3) with V > 0, not {position.shape}")
    bad = np.flatnonzero(~np.isfinite(position).all(axis=1))
    if len(bad):
        raise MeshError(f"positions are not finite at vertices {_some(bad)}")


def check_indices(kind: str, indices: np.ndarray, vertex_count: int) -> None:
    """Refuse elements that name a vertex that does not exist, or the same one twice."""
    bad = np.flatnonzero(((indices < 0) | (indices >= vertex_count)).any(axis=1))
    if len(bad):
        raise MeshError(f"{kind}s {_some(bad)} name vertices outside 0 .. {vertex_count - 1}")
    ordered = np.sort(indices, axis=1)
    bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if len(bad):
        raise MeshError(f"{kind}s {_some(bad)} name the same vertex twice")


def grid(cls: Any, width: float, height: float, columns: int, rows: int) -> Any:
    """See :meth:`ClothMesh.grid`."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    position = np.column_stack([(uv - 0.5) * [width, height], np.zeros(len(uv))])
    number = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    triangles = _alternating_triangles(number)

    along_x = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    along_y = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    rising = np.stack([number[:-1, :-1].ravel(), number[1:, 1:].ravel()], axis=1)
    falling = np.stack([number[:-1, 1:].ravel(), number[1:, :-1].ravel()], axis=1)
    springs = np.concatenate([along_x, along_y, rising, falling])

    dx, dy = width / (columns - 1), height / (rows - 1)
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

    order = np.lexsort((springs.max(axis=1), springs.min(axis=1)))
    hinge_vertex, hinge_weight = hinges(position, triangles)
    names = dict(left=number[:, 0], right=number[:, -1], top=number[-1], bottom=number[0])
    names["corners"] = number[[-1, -1, 0, 0], [0, -1, 0, -1]]
    for corner, name in zip(names["corners"], ("top_left", "top_right", "bottom_left", "bottom_right"), strict=True):
        names[name] = corner.reshape(1)
    return cls(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs[order].astype(np.int32),
        spring_rest=np.linalg.norm(position[springs[order, 0]] - position[springs[order, 1]], axis=1),
        spring_weight=weight[order],
        spring_limited=(np.arange(len(springs)) < y)[order],
        hinge_vertex=hinge_vertex,
        hinge_weight=hinge_weight,
        vertex_area=vertex_areas(position, triangles),
        uv=uv,
        groups={name: np.ascontiguousarray(group) for name, group in names.items()},
    )


def _alternating_triangles(number: np.ndarray) -> np.ndarray:
    """Two triangles a cell; the diagonal alternates so that no direction of the sheet is preferred."""
    a, b, c, d = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    rows, columns = a.shape
    even = (np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0).ravel()[:, None, None]
    rising = np.stack([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)], axis=1)
    falling = np.stack([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)], axis=1)
    return np.where(even, rising, falling).reshape(-1, 3).astype(np.int32)


def sheet(
    cls: Any,
    position: np.ndarray,
    triangles: np.ndarray,
    *,
    uv: np.ndarray | None,
    groups: Mapping[str, Sequence[int]],
    warp: Sequence[float],
) -> Any:
    """See :meth:`ClothMesh.from_triangles`."""
    position = np.array(position, dtype=float)
    triangles = np.array(triangles, dtype=np.int32).reshape(-1, 3)
    check_positions(position)
    check_indices("triangle", triangles, len(position))
    area = triangle_areas(position, triangles)
    flat = np.flatnonzero(area <= 1e-12 * max(area.max(initial=0.0), 1e-300))
    if len(flat):
        raise MeshError(f"triangles {_some(flat)} have no area")
    unused = np.setdiff1d(np.arange(len(position)), triangles)
    if len(unused):
        raise MeshError(f"vertices {_some(unused)} belong to no triangle")

    springs, carried = _edges_with_area(triangles, area)
    along = position[springs[:, 1]] - position[springs[:, 0]]
    length = np.linalg.norm(along, axis=1)
    # k = E * area / length^2 stretches a triangulation like the sheet it stands for (Van Gelder 1998).
    stiff = carried / length**2
    share = ((along / length[:, None]) @ (np.asarray(warp, float) / np.linalg.norm(warp))) ** 2
    weight = np.zeros((len(springs), 4))
    weight[:, WARP], weight[:, WEFT] = stiff * share, stiff * (1 - share)
    hinge_vertex, hinge_weight = hinges(position, triangles)
    return cls(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=length,
        spring_weight=weight,
        spring_limited=np.ones(len(springs), bool),
        hinge_vertex=hinge_vertex,
        hinge_weight=hinge_weight,
        vertex_area=vertex_areas(position, triangles),
        uv=None if uv is None else np.array(uv, float),
        groups=_checked_groups(groups, len(position)),
    )


def net(
    cls: Any,
    position: np.ndarray,
    springs: np.ndarray,
    stiffness: float | np.ndarray,
    mass: float | np.ndarray,
    rest_length: np.ndarray | None,
    limited: bool | np.ndarray,
    triangles: np.ndarray | None,
    groups: Mapping[str, Sequence[int]],
) -> Any:
    """See :meth:`ClothMesh.from_springs`."""
    position = np.array(position, dtype=float)
    check_positions(position)
    springs = np.array(springs, dtype=np.int32).reshape(-1, 2)
    check_indices("spring", springs, len(position))
    triangles = np.zeros((0, 3), np.int32) if triangles is None else np.array(triangles, np.int32).reshape(-1, 3)
    placed = np.linalg.norm(position[springs[:, 0]] - position[springs[:, 1]], axis=1)
    rest = placed if rest_length is None else np.broadcast_to(np.asarray(rest_length, float), placed.shape).copy()
    weight = np.zeros((len(springs), 4))
    weight[:, GIVEN] = stiffness
    masses = np.broadcast_to(np.asarray(mass, float), len(position)).copy()
    for kind, values, least in (
        ("mass (kg)", masses, 1e-12),
        ("stiffness (N/m)", weight[:, GIVEN], 0.0),
        ("rest length (m)", rest, 0.0),
    ):
        bad = np.flatnonzero(~(np.isfinite(values) & (values >= least)))
        if len(bad):
            raise MeshError(f"{kind} must be a number of at least {least:g}; wrong at {_some(bad)}")
    return cls(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=rest,
        spring_weight=weight,
        spring_limited=np.broadcast_to(np.asarray(limited, bool), len(springs)).copy(),
        hinge_vertex=np.zeros((0, 4), np.int32),
        hinge_weight=np.zeros((0, 4)),
        vertex_area=vertex_areas(position, triangles),
        explicit_mass=masses,
        groups=_checked_groups(groups, len(position)),
    )


def triangle_areas(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(T,) m^2."""
    a, b, c = (position[triangles[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def vertex_areas(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(V,) m^2: a third of each adjoining triangle; their sum is the area of the sheet."""
    third = np.repeat(triangle_areas(position, triangles) / 3, 3)
    return np.bincount(triangles.ravel(), weights=third, minlength=len(position))


def _edges_with_area(triangles: np.ndarray, area: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unique edges (S, 2) int32, and the area of the triangles at each."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, which = np.unique(sides, axis=0, return_inverse=True)
    return edges.astype(np.int32), np.bincount(which.ravel(), weights=np.tile(area, 3), minlength=len(edges))


def hinges(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Hinges between neighbouring triangles and their weights, for the quadratic bending energy.

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


def _checked_groups(groups: Mapping[str, Sequence[int]], vertex_count: int) -> dict[str, np.ndarray]:
    named = {}
    for name, members in groups.items():
        indices = np.array(members, dtype=np.int32).ravel()
        if ((indices < 0) | (indices >= vertex_count)).any():
            raise MeshError(f"group {name!r} names vertices outside 0 .. {vertex_count - 1}")
        named[name] = indices
    return named


def _some(numbers: np.ndarray) -> str:
    """The first few of a list of element numbers, for a message."""
    shown = ", ".join(str(n) for n in numbers[:8])
    return f"{shown} and {len(numbers) - 8} more" if len(numbers) > 8 else shown
