"""A closed mesh as an obstacle: what a scene says of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from cloth_core.errors import SettingError
from cloth_core.fields.build import Progress
from cloth_core.fields.field import Field
from cloth_core.fields.grid import VOXEL_HIGH, VOXEL_LOW
from cloth_core.fields.make import make
from cloth_core.fields.surface import Closed, read_closed
from cloth_core.obstacles import Obstacle
from cloth_core.settings import Settings, setting

FIELD = 5
"""The kind of obstacle, after those of :mod:`cloth_core.obstacles`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VoxelField(Obstacle):
    """A closed mesh, known by its distance field; its frame is the mesh's own.

    The mesh comes from the file ``path``, or as ``surface``, which :func:`cloth_core.fields.closed` makes of arrays.
    """

    kind: ClassVar[int] = FIELD
    path: str | None = setting("str", None, help="mesh file (STL, OBJ, PLY, GLB ...), closed")
    voxel: float = setting("float", help="edge of a voxel", unit="m", low=VOXEL_LOW, high=VOXEL_HIGH)
    scale: float = setting("float", 1.0, low=1e-6, high=1e6, unit="m", help="length of one unit of the file")
    query: str = setting(
        "str", "trilinear", choices=("trilinear", "tangent_plane"), help="how distances come from voxels"
    )
    repair: bool = setting("bool", False, help="fill holes and turn triangles, with a warning, instead of refusing")
    surface: Closed | None = None

    def __post_init__(self) -> None:
        Settings.__post_init__(self)
        if (self.path is None) == (self.surface is None):
            raise SettingError("path", "a voxel field needs either a mesh file or a surface")

    @property
    def field(self) -> Field:
        """The distance field, built at the first call or taken from disk."""
        return self.made()

    def made(self, *, folder: Path | str | None = None, progress: Progress | None = None) -> Field:
        """As :attr:`field`, with another folder of the cache, and told how far it is.

        Raises:
            MeshError: the mesh is refused; the message names file and fault.
            SettingError: the voxel is too small for the mesh.
        """
        surface = self.surface or read_closed(str(self.path), mend=self.repair)
        surface = surface._replace(position=self.scale * surface.position)
        return make(surface, self.voxel, query=self.query, folder=folder, progress=progress)

    @property
    def size(self) -> tuple[float, float, float]:
        """Nothing: the field's number in the scene's pool stands there."""
        return (0.0, 0.0, 0.0)

    @property
    def reach(self) -> float:
        """Of the farthest point of the surface."""
        return self.field.reach
