"""The cloth as geometry: vertices, triangles, springs, hinges, areas and named groups."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from cloth_core import topology
from cloth_core.errors import MeshError
from cloth_core.material import Material


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
    """(S, 4): spring stiffness = weight @ (stretch_warp, stretch_weft, shear, 1 N/m)."""
    spring_limited: np.ndarray
    """(S,) bool: whether the stretch limit holds for the spring."""
    hinge_vertex: np.ndarray
    """(H, 4) int32: the ends of a shared edge, then the two opposite vertices."""
    hinge_weight: np.ndarray
    """(H, 4) 1/m: bending energy is bend / 2 * sum over hinges of |weight @ positions|^2."""
    vertex_area: np.ndarray
    """(V,) m^2, a third of each adjoining triangle."""
    explicit_mass: np.ndarray | None = None
    """(V,) kg where the mass does not follow from the area (:meth:`from_springs`), else None."""
    uv: np.ndarray | None = None
    """(V, 2) texture coordinates in 0..1, or None."""
    groups: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Named vertex indices, int32."""

    def __post_init__(self) -> None:
        for known in fields(self):
            value = getattr(self, known.name)
            if isinstance(value, np.ndarray):
                value = np.ascontiguousarray(value)
                value.setflags(write=False)
                object.__setattr__(self, known.name, value)
        topology.check_positions(self.rest_position)
        topology.check_indices("triangle", self.triangles, self.vertex_count)
        topology.check_indices("spring", self.spring_vertex, self.vertex_count)

    @property
    def vertex_count(self) -> int:
        """Number of vertices V."""
        return len(self.rest_position)

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
            return self.explicit_mass
        return material.areal_density * self.vertex_area

    def spring_stiffness(self, material: Material) -> np.ndarray:
        """(S,) N/m."""
        return self.spring_weight @ np.array([material.stretch_warp, material.stretch_weft, material.shear, 1.0])

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
            MeshError: fewer than 2 columns or rows, or an extent that is not positive.
        """
        if columns < 2 or rows < 2:
            raise MeshError(f"a grid needs at least 2 columns and 2 rows, not {columns} x {rows}")
        if not (width > 0 and height > 0 and np.isfinite([width, height]).all()):
            raise MeshError(f"a grid needs a positive width and height, not {width} x {height} m")
        return topology.grid(cls, width, height, columns, rows)

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
        """A sheet of any triangulation; its edges are the springs, stiff by the area they carry.

        Args:
            position: (V, 3) m, unstrained.
            triangles: (T, 3).
            uv: (V, 2) texture coordinates.
            groups: named vertex indices.
            warp: direction of the warp in the frame of ``position``.

        Raises:
            MeshError: non-finite positions, indices out of range, triangles without area, or vertices
                that no triangle uses, with their numbers.
        """
        return topology.sheet(cls, position, triangles, uv=uv, groups=groups or {}, warp=warp)

    @classmethod
    def from_trimesh(cls, mesh: object, **options: object) -> ClothMesh:
        """A sheet from a ``trimesh.Trimesh``; keywords are those of :meth:`from_triangles`."""
        return cls.from_triangles(np.asarray(mesh.vertices), np.asarray(mesh.faces), **options)  # type: ignore[attr-defined,arg-type]

    @classmethod
    def load(cls, path: str | Path, *, scale: float = 1.0) -> ClothMesh:
        """A sheet from any file that trimesh reads (OBJ, PLY, STL, GLB, ...); ``scale`` turns its unit into metres.

        Raises:
            MeshError: the file cannot be read or holds no usable triangles; the message names it.
        """
        import trimesh

        try:
            mesh = trimesh.load(str(path), force="mesh", process=False)
            mesh.merge_vertices(merge_tex=True, merge_norm=True)
            if len(mesh.faces) == 0:
                raise MeshError("no triangles")
            mesh.apply_scale(scale)
            return cls.from_trimesh(mesh)
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from None
        except ImportError as error:  # trimesh guessed another format from what the file holds
            kind = Path(path).suffix or "mesh"
            raise MeshError(f"{path}: cannot be read as a mesh: it does not hold what a {kind} file holds") from error
        except Exception as error:
            raise MeshError(f"{path}: cannot be read as a mesh: {error}") from error

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

        Raises:
            MeshError: indices out of range, masses, stiffnesses or lengths that make no sense.
        """
        return topology.net(cls, position, springs, stiffness, mass, rest_length, limited, triangles, groups or {})
