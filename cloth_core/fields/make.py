"""Makes the field of one solid or of several that stand still to each other, or takes it from the cache."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from cloth_core.errors import MeshError
from cloth_core.fields import cache
from cloth_core.fields.build import Progress, build
from cloth_core.fields.field import Field
from cloth_core.fields.solid import Solid
from cloth_core.fields.surface import Closed
from cloth_core.obstacles import Obstacle
from cloth_core.pose import Pose

Part = Closed | Obstacle | tuple[Closed, Pose]
"""A closed surface where it is or at a pose, or an analytic shape where it stands at the start."""


def make(
    parts: Part | Sequence[Part],
    voxel: float,
    *,
    band: float | None = None,
    query: str = "trilinear",
    folder: Path | str | None = None,
    progress: Progress | None = None,
) -> Field:
    """The distance field of all ``parts`` together: a body, a group that moves as one, or all that stands still.

    The distance is the least of the parts' (paper, 4.2.3: compound objects); parts may overlap.

    Args:
        parts: one or several.
        voxel: edge of a voxel in m.
        band: see :func:`~cloth_core.fields.build.build`.
        query: see :func:`~cloth_core.fields.build.build`.
        folder: where fields are kept on disk; :func:`~cloth_core.fields.cache.default_folder` if omitted.
        progress: is called with the share (0 .. 1) done; not at all if the field is on disk.

    Raises:
        MeshError: there are no parts, or a plane is one.
        SettingError: the voxel is out of range or too small for the extent.
    """
    parts = [parts] if isinstance(parts, (Closed, Obstacle)) else list(parts)
    name = cache.digest(_arrays(parts), voxel, band, query)
    where = cache.default_folder() if folder is None else Path(folder)
    return cache.kept(name, lambda: build(_solid(parts), voxel, band=band, query=query, progress=progress), where)


def _solid(parts: Sequence[Part]) -> Solid:
    return Solid.union([_one(part) for part in parts])


def _one(part: Part) -> Solid:
    if isinstance(part, Closed):
        return Solid.of_surface(part)
    if isinstance(part, Obstacle):
        return Solid.of_shape(part)
    return Solid.of_surface(*part)


def _arrays(parts: Sequence[Part]) -> Iterator[np.ndarray]:
    """All that the parts consist of, as numbers."""
    if not parts:
        raise MeshError("a compound without parts has no surface")
    for part in parts:
        if isinstance(part, Obstacle):
            yield np.array([part.kind, *part.size, *part.pose.position, *part.pose.orientation], float)
        else:
            surface, pose = (part, Pose()) if isinstance(part, Closed) else part
            yield from (surface.position, surface.triangles, np.array([*pose.position, *pose.orientation]))
