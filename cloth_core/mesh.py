"""The cloth as geometry: vertices, triangles, springs, hinges, areas and named groups."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from cloth_core.errors import MeshError, MeshWarning, shown
from cloth_core.material import Material
from cloth_core.meshing import checks, files, grid, net, repair, sheet
from cloth_core.meshing import pieces as joining
from cloth_core.meshing.areas import triangle_areas
from cloth_core.pose import Pose

LEAST_OF_THREADS = 0.2
"""Share of a sheet's stiffness along its threads that these must have themselves, where springs shall carry it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ClothMesh:
    """An arbitrarily connected mass-spring system, usually a triangulated sheet (paper, section 2).

    Geometry only: stiffness and mass follow when a :class:`Material` is chosen. Arrays are read-only.
    """

    rest_position: np.ndarray
    """(V, 3) m, where no spring is strained."""
    triangles: np.ndarray
    """(T, 3) int32, counter-clockwise seen from the front; may be empty."""
    spring_vertex: np.ndarray
    """(S, 2) int32."""
    spring_rest: np.ndarray
    """(S,) m."""
    spring_weight: np.ndarray
    """(S, 4): spring stiffness = weight @ (C_warp, C_weft, shear, 1 N/m), see :meth:`Material.sheet_stiffness`."""
    spring_limited: np.ndarray
    """(S,) bool: whether the stretch limit holds for the spring."""
    spring_bias: np.ndarray
    """(S,): how much longer than a thread the spring may get, as a ratio, because the cloth shears."""
    triangle_slope: np.ndarray
    """(T, 3, 2) 1/m: how fast the share of a corner grows along warp and weft; (0, 3, 2) for what is no sheet."""
    hinge_vertex: np.ndarray
    """(H, 4) int32: the ends of a shared edge, then the two opposite vertices."""
    curvature_start: np.ndarray
    """(R + 1,) int32: bending energy is bend / 2 * sum over readings r of |sum of weight * position|^2 over the entries
    start[r] to start[r + 1] of the next two."""
    curvature_vertex: np.ndarray
    """(N,) int32."""
    curvature_weight: np.ndarray
    """(N,) 1/m."""
    vertex_area: np.ndarray
    """(V,) m^2, a third of each adjoining triangle."""
    explicit_mass: np.ndarray | None = None
    """(V,) kg where the mass does not follow from the area (:meth:`from_springs`), else None."""
    uv: np.ndarray | None = None
    """(V, 2) texture coordinates in 0..1, or None."""
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Named vertex indices, int32."""
    pieces: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Vertex indices, int32, of the cloths that were :meth:`joined`; empty where there is but one."""

    def __post_init__(self) -> None:
        for known in fields(self):
            value = getattr(self, known.name)
            if isinstance(value, np.ndarray):
                value = np.ascontiguousarray(value)
                value.setflags(write=False)
                object.__setattr__(self, known.name, value)
        checks.check_positions(self.rest_position)
        checks.check_indices("triangles", self.triangles, self.vertex_count)
        checks.check_indices("springs", self.spring_vertex, self.vertex_count)
        arrays = {known.name: getattr(self, known.name) for known in fields(self)}
        checks.check_arrays({name: value for name, value in arrays.items() if isinstance(value, np.ndarray)})

    @property
    def usual_thread(self) -> float:
        """m, the median rest length of the springs that the stretch limit holds for; if it holds for none, of all."""
        threads = self.spring_rest[self.spring_limited] if self.spring_limited.any() else self.spring_rest
        return float(np.median(threads)) if len(threads) else 0.0

    @property
    def vertex_count(self) -> int:
        """Number of vertices V."""
        return len(self.rest_position)

    @cached_property
    def spring_ends(self) -> np.ndarray:
        """(S, 2) uint32, ``spring_vertex`` for kernels: without a sign, no index may count from the end."""
        return self.spring_vertex.astype(np.uint32)

    @cached_property
    def component(self) -> np.ndarray:
        """(V,) int32: number of the connected part that each vertex belongs to."""
        i, j = self.spring_vertex.T
        links = coo_matrix((np.ones(len(i)), (i, j)), shape=(self.vertex_count,) * 2)
        return connected_components(links, directed=False)[1].astype(np.int32)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all that the solver sees, to tell meshes apart in a session."""
        sha = hashlib.sha256()
        for known in fields(self):
            value = getattr(self, known.name)
            if isinstance(value, np.ndarray):
                sha.update(known.name.encode() + str(value.shape).encode() + value.tobytes())
        return sha.hexdigest()

    def group(self, name: str) -> np.ndarray:
        """Vertex indices of a named group.

        Raises:
            MeshError: there is no group of that name.
        """
        if name not in self.groups:
            raise MeshError(f"no vertex group {name!r}; this mesh has {', '.join(sorted(self.groups)) or 'none'}")
        return self.groups[name]

    def vertex_mass(self, material: Material) -> np.ndarray:
        """(V,) kg: areal density times vertex area, or the masses that the mesh was given."""
        if self.explicit_mass is not None:
            return self.explicit_mass.copy()
        return material.areal_density * self.vertex_area

    @cached_property
    def triangle_area(self) -> np.ndarray:
        """(T,) m^2 at rest."""
        return triangle_areas(self.rest_position, self.triangles)

    @cached_property
    def limit_rest(self) -> np.ndarray:
        """(S,) m: rest lengths as the stretch limit counts them, with what shearing adds."""
        return self.spring_rest * self.spring_bias

    def is_membrane(self, material: Material) -> bool:
        """Whether triangles carry the stretching: springs are cheaper, but only those of a grid make a sheet.

        Even they do not if its cells are so long or the shear so stiff that the diagonals alone would be stiffer
        along the threads than the material is, or nearly so: what holds threads to their limit needs them in W.
        """
        k = self._stiffness_by(self.spring_weight, material)
        whole = self._stiffness_by(np.maximum(self.spring_weight, 0.0), material)
        return len(self.triangle_slope) > 0 and not (k.any() and (k >= LEAST_OF_THREADS * whole).all())

    def spring_stiffness(self, material: Material) -> np.ndarray:
        """(S,) N/m; zero where triangles carry the stretching."""
        k = self._stiffness_by(self.spring_weight, material)
        return np.zeros_like(k) if self.is_membrane(material) else k

    @staticmethod
    def _stiffness_by(weight: np.ndarray, material: Material) -> np.ndarray:
        return weight @ np.array([*material.sheet_stiffness(), 1.0])

    @classmethod
    def grid(cls, *, width: float, height: float, columns: int, rows: int) -> ClothMesh:
        """A rectangle in the plane z = 0, centred on the origin, warp along y.

        Args:
            width: extent along x, m.
            height: extent along y, m.
            columns: vertices along x, at least 2.
            rows: vertices along y, at least 2.

        Groups are ``left``, ``right``, ``top``, ``bottom``, ``corners`` (in the order ``top_left``,
        ``top_right``, ``bottom_left``, ``bottom_right``) and each corner by that name. Vertex numbers run
        along x first, from the bottom row up.

        Raises:
            MeshError: fewer than 2 columns or rows, an extent that is not positive, or cells far longer than wide.
        """
        return cls(**grid.fields(width, height, columns, rows))

    @classmethod
    def from_triangles(
        cls,
        position: np.ndarray,
        triangles: np.ndarray,
        *,
        uv: np.ndarray | None = None,
        groups: Mapping[str, Sequence[int]] | None = None,
        warp: Sequence[float] = (0.0, 1.0, 0.0),
    ) -> ClothMesh:
        """A sheet of any triangulation; triangles carry the stretching, as stiffly as a grid's springs do.

        Args:
            position: (V, 3) m, unstrained.
            triangles: (T, 3).
            uv: (V, 2) texture coordinates.
            groups: named vertex indices.
            warp: direction of the warp in the frame of ``position``; in a triangle, what of it lies in its plane.

        Raises:
            MeshError: vertices that are not finite or belong to no triangle; triangles that are out of range,
                repeated, without area or wound against their neighbours; edges of more than two triangles; a
                surface with one side only; uv, groups or a warp that make no sense. The message names the elements.
        """
        return cls(**sheet.fields(position, triangles, uv, groups or {}, warp))

    @classmethod
    def from_trimesh(cls, mesh: object, **options: object) -> ClothMesh:
        """A sheet from a ``trimesh.Trimesh``; keywords are those of :meth:`from_triangles`.

        Raises:
            MeshError: that has no vertices and faces, or they are no sheet.
        """
        if not (hasattr(mesh, "vertices") and hasattr(mesh, "faces")):
            raise MeshError(f"{shown(mesh)} is not a trimesh.Trimesh; ClothMesh.load(path) reads files")
        return cls.from_triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces), **options)  # type: ignore[attr-defined,arg-type]

    @classmethod
    def load(cls, path: str | Path, *, scale: float = 1.0) -> ClothMesh:
        """A sheet from any file that trimesh reads (OBJ, PLY, STL, GLB, ...); ``scale`` turns its unit into metres.

        Corners at the same place become one vertex. Vertices without a triangle, repeated triangles and tiny parts
        that hang together with nothing are dropped, triangles wound against their neighbours are turned: a
        :class:`MeshWarning` names them, as the file numbers them, from 0 (polygons count as the triangles that
        they are made of).

        Raises:
            MeshError: the file cannot be read, or what it holds cannot be mended (see :meth:`from_triangles`);
                the message names the file and the elements.
        """
        if not isinstance(path, (str, Path)):
            raise MeshError(f"path: {shown(path)} is not the path of a mesh file")
        if not checks.is_positive(scale):
            raise MeshError(f"{path}: scale {shown(scale)} is not a positive number (m per unit of the file)")
        try:
            position, triangles = files.read(Path(path))
            position, triangles, done = repair.mended(scale * position, triangles)
            mesh = cls.from_triangles(position, triangles)
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from None
        for repaired in done:
            warnings.warn(f"{path}: {repaired}", MeshWarning, stacklevel=2)
        return mesh

    @classmethod
    def joined(cls, pieces: Mapping[str, ClothMesh], poses: Mapping[str, Pose] | None = None) -> ClothMesh:
        """Several cloths as one mesh, so that one solver moves them and they collide with each other.

        Nothing joins the pieces. The vertices of each are a group by its name, and what was its group ``left`` is
        ``<piece>_left`` now. Where triangles carry the stretching of one, they do so in all.

        Args:
            pieces: by name, in the order of their vertices.
            poses: where the rest shapes of some of them stand; those not named stay.

        Raises:
            MeshError: there are no pieces, two groups would have the same name, some are sheets and others are not, or
                a pose is of none of them.
        """
        poses = poses or {}
        unknown = ", ".join(sorted(poses.keys() - pieces.keys()))
        if unknown:
            raise MeshError(f"there are poses of {unknown}; the pieces are {', '.join(pieces)}")
        parts = {}
        for name, mesh in pieces.items():
            given = {known.name: getattr(mesh, known.name) for known in fields(mesh)}
            placed = poses[name].apply(mesh.rest_position) if name in poses else mesh.rest_position
            parts[name] = {**given, "rest_position": placed}
        return cls(**joining.fields(parts))

    @classmethod
    def from_springs(
        cls,
        position: np.ndarray,
        springs: np.ndarray,
        *,
        stiffness: float | np.ndarray,
        mass: float | np.ndarray,
        rest_length: np.ndarray | None = None,
        limited: bool | np.ndarray = True,
        triangles: np.ndarray | None = None,
        groups: Mapping[str, Sequence[int]] | None = None,
    ) -> ClothMesh:
        """Any masses joined by any springs (paper, section 2): chains, nets, solids.

        Args:
            position: (V, 3) m.
            springs: (S, 2) vertex indices.
            stiffness: N/m, one for all or (S,).
            mass: kg per vertex, one for all or (V,).
            rest_length: (S,) m; as placed if omitted.
            limited: whether the stretch limit holds, one for all or (S,).
            triangles: (T, 3) surface that wind acts on, if there is one.
            groups: named vertex indices.

        Edges and winding of the triangles are free here: they only catch wind.

        Raises:
            MeshError: indices out of range or repeated; masses, stiffnesses, lengths or triangles that make no sense.
        """
        return cls(**net.fields(position, springs, stiffness, mass, rest_length, limited, triangles, groups or {}))
