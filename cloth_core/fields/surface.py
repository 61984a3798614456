"""Closed surfaces: read, checked, and mended where the caller wants that."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from cloth_core.errors import MeshError, MeshWarning
from cloth_core.meshing import checks, faults, files
from cloth_core.meshing.repair import SAME_PLACE

TRIANGLES_MOST = 5_000_000
"""Triangles of one surface; more would take minutes and gigabytes to build a field of."""


class Closed(NamedTuple):
    """A surface that encloses a volume, its triangles wound so that their normals point outwards."""

    position: np.ndarray
    """(V, 3) float64 m."""
    triangles: np.ndarray
    """(T, 3) int64."""


def read_closed(path: str | Path, *, mend: bool = False) -> Closed:
    """Read a mesh file (STL, OBJ, PLY, GLB and what else trimesh reads; metres) as a closed surface.

    Raises:
        MeshError: the file cannot be read, or :func:`closed` refuses what it holds; the message names the file.
    """
    try:
        return closed(*files.read(Path(path)), mend=mend, source=str(path))
    except MeshError as error:
        text = str(error)
        raise MeshError(text if text.startswith(str(path)) else f"{path}: {text}") from error


def closed(position: np.ndarray, triangles: np.ndarray, *, mend: bool = False, source: str = "the mesh") -> Closed:
    """Check that a surface is closed and faces outwards; vertices in the same place are joined.

    Closed means that at every edge as many triangles run one way as the other: also for edges of four triangles.
    With ``mend`` triangles that repeat others or run against their neighbours are put right, holes are filled by fans
    around their middle, and a surface that is inside out is turned, each with a :class:`MeshWarning`.

    Raises:
        MeshError: there are holes (the message names their edges by vertices and says where they are), or no volume.
    """
    position = checks.as_numbers("vertices", position, 3, " (m)")
    position, triangles = _joined(position, np.asarray(triangles, np.int64).reshape(-1, 3))
    done: list[str] = []
    if mend:
        triangles = _wound_alike(triangles, done)
    holes = hole_loops(triangles)
    if holes and not mend:
        raise MeshError(
            f"not watertight: {_named(holes, position)}; close them, or have them filled with repair (it warns)"
        )
    if holes:
        position, triangles = _filled(position, triangles, holes)
        done.append(f"{_named(holes, position)} filled")
    volume = _volume(position, triangles)
    size = np.ptp(position[triangles].reshape(-1, 3), axis=0).max()
    if not abs(volume) > 1e-12 * size**3:
        raise MeshError(f"encloses no volume: {volume:.3g} m^3 in an extent of {size:.3g} m")
    if volume < 0.0:
        if not mend:
            raise MeshError(f"inside out: its normals point inwards ({volume:.3g} m^3); reverse its triangles")
        triangles = triangles[:, ::-1].copy()
        done.append("the surface was inside out, and turned")
    if done:
        warnings.warn(f"{source}: {'; '.join(done)}", MeshWarning, stacklevel=3)
    return Closed(position, triangles)


def hole_loops(triangles: np.ndarray) -> list[np.ndarray]:
    """Vertices around each hole, in the direction that triangles which fill it must run.

    A hole is where more triangles run along an edge one way than the other; such edges always form loops.
    """
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    base = int(triangles.max()) + 1
    edge, which = np.unique(np.minimum(start, end) * base + np.maximum(start, end), return_inverse=True)
    excess = np.bincount(which.ravel(), weights=np.where(start < end, 1.0, -1.0)).astype(np.int64)
    ways: dict[int, list[int]] = {}
    for number in np.flatnonzero(excess):
        low, high = divmod(int(edge[number]), base)
        for _ in range(abs(excess[number])):
            a, b = (high, low) if excess[number] > 0 else (low, high)
            ways.setdefault(a, []).append(b)
    loops = []
    while ways:
        begin = min(ways)
        loop, at = [begin], _taken(ways, begin)
        while at != begin:
            if at in loop:  # two holes meet in this vertex: this one is complete
                cut = loop.index(at)
                loops.append(np.array(loop[cut:]))
                loop = loop[:cut]
            loop.append(at)
            at = _taken(ways, at)
        loops.append(np.array(loop))
    return loops


def _taken(ways: dict[int, list[int]], at: int) -> int:
    after = ways[at].pop(0)
    if not ways[at]:
        del ways[at]
    return after


def _joined(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if len(triangles) == 0:
        raise MeshError("no triangles")
    if len(triangles) > TRIANGLES_MOST:
        raise MeshError(f"{len(triangles)} triangles are more than {TRIANGLES_MOST}: make the mesh coarser")
    checks.check_indices("triangles", triangles, len(position))
    used = np.unique(triangles)
    checks.check_positions(position, used)
    triangles = _first_at_place(position, used)[triangles]
    # What shrank to a line in joining has no area and closes nothing.
    return position, triangles[np.setdiff1d(np.arange(len(triangles)), faults.collapsed(triangles))]


def _first_at_place(position: np.ndarray, used: np.ndarray) -> np.ndarray:
    """(V,) the first of the ``used`` vertices at the same place, for each of them."""
    place = position[used]
    pairs = cKDTree(place).query_pairs(SAME_PLACE * np.ptp(place, axis=0).max(), output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(used), len(used)))
    group = connected_components(graph, directed=False)[1]
    first = np.full(group.max() + 1, len(position))
    np.minimum.at(first, group, used)
    joined = np.arange(len(position))
    joined[used] = first[group]
    return joined


def _wound_alike(triangles: np.ndarray, done: list[str]) -> np.ndarray:
    repeated = faults.repeated(triangles)
    if len(repeated):
        done.append(f"triangles that repeat an earlier one dropped: {checks.listed(repeated)}")
        triangles = np.delete(triangles, repeated, axis=0)
    if len(faults.crowded(triangles)[0]) == 0:
        against = checks.check_sides(triangles)
        if len(against):
            done.append(f"triangles wound against their neighbours turned: {checks.listed(against)}")
            triangles = triangles.copy()
            triangles[against] = triangles[against, ::-1]
    return triangles


def _filled(position: np.ndarray, triangles: np.ndarray, holes: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Each hole with a fan of triangles around a new vertex in its middle."""
    middles, fans = [], []
    for number, loop in enumerate(holes):
        middles.append(position[loop].mean(axis=0))
        apex = np.full(len(loop), len(position) + number)
        fans.append(np.stack([loop, np.roll(loop, -1), apex], axis=1))
    return np.concatenate([position, middles]), np.concatenate([triangles, *fans])


def _volume(position: np.ndarray, triangles: np.ndarray) -> float:
    """m^3, negative if normals point inwards; about the mesh's own middle, where rounding is least."""
    corner = position[triangles] - position[triangles].mean(axis=(0, 1))
    return float(np.einsum("tk,tk->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6.0)


def _named(holes: list[np.ndarray], position: np.ndarray) -> str:
    """The first holes by the edges around them, and where their middles are."""
    texts = []
    for loop in itertools.islice(sorted(holes, key=len, reverse=True), 4):
        x, y, z = position[loop].mean(axis=0)
        edges = checks.listed(np.stack([loop, np.roll(loop, -1)], axis=1))
        texts.append(f"{len(loop)} edges ({edges}) around ({x:.4g}, {y:.4g}, {z:.4g}) m")
    more = f" and {len(holes) - 4} more" if len(holes) > 4 else ""
    count = "1 hole" if len(holes) == 1 else f"{len(holes)} holes"
    return f"{count} of {'; '.join(texts)}{more}"
