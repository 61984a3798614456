"""Obstacles that are known by their distance fields, and the one of a single mesh."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from cloth_core.errors import MeshError, SettingError
from cloth_core.fields.build import Progress
from cloth_core.fields.field import Field
from cloth_core.fields.grid import VOXEL_HIGH, VOXEL_LOW
from cloth_core.fields.make import Part, make
from cloth_core.fields.outline import Outline, outline
from cloth_core.fields.surface import Closed, read_closed
from cloth_core.obstacles import FIELD, Obstacle
from cloth_core.settings import Settings, setting

FINENESS = 100
"""Voxels along the longest extent, unless a scene says otherwise."""
FROM_ARRAYS = "(arrays)"
"""Stands for the file of a surface that was read from none."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldObstacle(Obstacle):
    """What obstacles with a distance field have in common."""

    kind: ClassVar[int] = FIELD
    voxel: float | None = setting(
        "float",
        None,
        help="edge of a voxel; a hundredth of the longest extent if omitted",
        unit="m",
        low=VOXEL_LOW,
        high=VOXEL_HIGH,
    )
    query: str = setting(
        "str", "trilinear", choices=("trilinear", "tangent_plane"), help="how distances come from voxels"
    )
    _kept: dict[Any, Any] = dataclasses.field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def pieces(self) -> Sequence[Part]:
        """What it consists of, in its frame."""
        raise NotImplementedError

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The low and the high corner of a box around it, (3,) m each, in its frame."""
        raise NotImplementedError

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the edges of that box, m."""
        low, high = self.box
        return tuple((0.5 * (high - low)).tolist())  # type: ignore[return-value]

    @property
    def middle(self) -> tuple[float, float, float]:
        """Of that box, in the frame, m."""
        low, high = self.box
        return tuple((0.5 * (high + low)).tolist())  # type: ignore[return-value]

    @property
    def meshes(self) -> Mapping[str, Closed]:
        """The surfaces among its pieces, by name, in m."""
        raise NotImplementedError

    def with_meshes(self, meshes: Mapping[str, Closed]) -> FieldObstacle:
        """The same of surfaces that :attr:`meshes` gave, without their files."""
        raise NotImplementedError

    @property
    def field(self) -> Field:
        """The distance field, built at the first call or taken from disk."""
        return self.made()

    def made(self, *, band: float = 0.0, folder: Path | str | None = None, progress: Progress | None = None) -> Field:
        """As :attr:`field`, exact as far as ``band`` m from the surface, and a voxel at least.

        Args:
            band: m.
            folder: another one of the cache.
            progress: is told how far it is.

        Raises:
            MeshError: a mesh is refused; the message names file and fault.
            SettingError: the voxel is too small for the mesh.
        """
        voxel = self.voxel or min(max(2.0 * max(self.half_extents) / FINENESS, VOXEL_LOW), VOXEL_HIGH)
        wide = band if band > voxel else None
        if wide not in self._kept:
            self._kept[wide] = make(self.pieces, voxel, band=wide, query=self.query, folder=folder, progress=progress)
        return self._kept[wide]

    @property
    def size(self) -> tuple[float, float, float]:
        """Nothing: fields are known by their number."""
        return (0.0, 0.0, 0.0)

    @property
    def roundness(self) -> float:
        """A mesh has edges."""
        return 0.0

    @property
    def inradius(self) -> float:
        """Any part may be thin."""
        return 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class VoxelField(FieldObstacle):
    """A closed mesh, known by its distance field; its frame is the mesh's own.

    The mesh comes from the file ``path``, or as ``surface``, which :func:`cloth_core.fields.closed` makes of arrays.
    """

    path: str | None = setting("str", None, help="mesh file (STL, OBJ, PLY, GLB ...), closed")
    scale: float = setting("float", 1.0, low=1e-6, high=1e6, unit="m", help="length of one unit of the file")
    repair: bool = setting("bool", False, help="fill holes and turn triangles, with a warning, instead of refusing")
    surface: Closed | None = None

    def __post_init__(self) -> None:
        Settings.__post_init__(self)
        if (self.path is None) == (self.surface is None):
            raise SettingError("path", "a voxel field needs either a mesh file or a surface")

    def within(self, folder: Path) -> VoxelField:
        """The same, with its file looked up from ``folder``."""
        return self if self.path is None else replace(self, path=str(folder / self.path))

    def check(self) -> None:
        """Read the mesh, and refuse what is none."""
        Obstacle.check(self)
        try:
            _ = self.mesh
        except MeshError as error:
            raise SettingError("path", str(error)) from None

    @property
    def mesh(self) -> Closed:
        """The surface in m, read at the first call.

        Raises:
            MeshError: it cannot be read, or has holes; the message names file and fault.
        """
        if "mesh" not in self._kept:
            surface = self.surface or read_closed(str(self.path), mend=self.repair)
            self._kept["mesh"] = surface._replace(position=self.scale * surface.position)
        return self._kept["mesh"]

    @property
    def outline(self) -> Outline:
        """The mesh for viewers, coarser if it is a fine one."""
        if "outline" not in self._kept:
            self._kept["outline"] = outline(self.mesh)
        return self._kept["outline"]

    @property
    def pieces(self) -> Sequence[Part]:
        """The mesh."""
        return (self.mesh,)

    @property
    def meshes(self) -> Mapping[str, Closed]:
        """The mesh."""
        return {"": self.mesh}

    def with_meshes(self, meshes: Mapping[str, Closed]) -> VoxelField:
        """The same of the surface that :attr:`meshes` gave."""
        return replace(self, path=None, scale=1.0, repair=False, surface=meshes[""])

    def as_mapping(self) -> dict[str, Any]:
        """The settings; a surface that came from no file is not among them."""
        return {"path": FROM_ARRAYS, **Settings.as_mapping(self)}

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """That of the mesh."""
        return self.mesh.position.min(axis=0), self.mesh.position.max(axis=0)

    @property
    def reach(self) -> float:
        """Of the farthest point of the surface."""
        return float(np.linalg.norm(self.mesh.position, axis=1).max())
