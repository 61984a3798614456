"""Mends what files of triangles often have wrong; what cannot be mended is refused."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cloth_core.errors import MeshError
from cloth_core.meshing import checks, faults

SAME_PLACE = 1e-8
"""Corners that are closer than this share of the mesh's extent are one vertex: STL and others repeat them."""


class Mended(NamedTuple):
    """A sheet that :meth:`~cloth_core.mesh.ClothMesh.from_triangles` takes, and what was done to it."""

    position: np.ndarray
    triangles: np.ndarray
    done: list[str]
    """A sentence for each repair, with the elements as the file numbers them."""


def mended(position: np.ndarray, triangles: np.ndarray) -> Mended:
    """Join equal corners; drop unused vertices, repeated triangles and dust; turn what is wound the wrong way.

    Elements keep the numbers that they came with until the end, so that messages name those of the file.

    Raises:
        MeshError: a fault that cannot be mended.
    """
    if len(triangles) == 0:
        raise MeshError("no triangles; is the file whole, and is it a surface?")
    checks.check_indices("triangles", triangles, len(position))
    done: list[str] = []
    _say(done, "vertices that belong to no triangle", faults.unused(len(position), triangles), "dropped")
    used = np.unique(triangles)
    checks.check_positions(position, used)
    triangles = _joined(position, used)[triangles]
    checks.check_shapes(position, triangles)

    kept = np.setdiff1d(np.arange(len(triangles)), repeated := faults.repeated(triangles))
    _say(done, "triangles that repeat an earlier one", repeated, "dropped")
    checks.check_edges(triangles[kept], kept)
    against = kept[checks.check_sides(triangles[kept], kept)]
    triangles[against] = triangles[against, ::-1]
    _say(done, "triangles wound against their neighbours", against, "turned")
    dust = kept[faults.dust(position, triangles[kept])]
    _say(done, "triangles of small parts that hang together with nothing", dust, "dropped")
    return Mended(*_packed(position, triangles[np.setdiff1d(kept, dust)]), done)


def _say(done: list[str], what: str, elements: np.ndarray, remedy: str) -> None:
    if len(elements):
        done.append(f"{what} were {remedy}: {checks.listed(elements)}")


def _joined(position: np.ndarray, used: np.ndarray) -> np.ndarray:
    """(V,) the first of the ``used`` vertices at the same place, for each of them."""
    place = position[used]
    extent = np.ptp(place, axis=0).max()
    cell = np.round(place / (SAME_PLACE * extent)) if extent > 0.0 else np.zeros_like(place)
    _, first, which = np.unique(cell, axis=0, return_index=True, return_inverse=True)
    joined = np.arange(len(position))
    joined[used] = used[first[which.ravel()]]
    return joined


def _packed(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Only the vertices that triangles name, renumbered in order."""
    used, packed = np.unique(triangles, return_inverse=True)
    return position[used], packed.reshape(triangles.shape)
