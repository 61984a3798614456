"""Several cloths as one mesh: see :meth:`cloth_core.mesh.ClothMesh.joined`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cloth_core.errors import MeshError

OF_VERTICES = ("triangles", "spring_vertex", "hinge_vertex", "curvature_vertex")
"""What holds numbers of vertices, which shift."""
AS_THEY_ARE = (
    *("rest_position", "spring_rest", "spring_weight", "spring_limited", "spring_bias"),
    *("triangle_slope", "curvature_weight", "vertex_area"),
)


def fields(parts: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The fields of the mesh that has those of all ``parts``, by name."""
    if not parts:
        raise MeshError("there are no pieces to join: at least one is needed")
    _check_kinds(parts)
    counts = [len(part["rest_position"]) for part in parts.values()]
    begins = dict(zip(parts, np.cumsum([0, *counts[:-1]]).tolist(), strict=True))
    joined = {name: np.concatenate([part[name] for part in parts.values()]) for name in AS_THEY_ARE}
    for name in OF_VERTICES:
        shifted = [part[name] + begins[piece] for piece, part in parts.items()]
        joined[name] = np.concatenate(shifted).astype(np.int32)
    if len({bool(part["spring_weight"].any()) for part in parts.values()}) > 1:
        joined["spring_weight"] = np.zeros_like(joined["spring_weight"])  # triangles carry all if they carry some
    pieces = {
        piece: np.arange(begins[piece], begins[piece] + count, dtype=np.int32)
        for piece, count in zip(parts, counts, strict=True)
    }
    return {
        **joined,
        "curvature_start": _starts(parts),
        "explicit_mass": _of_all("explicit_mass", parts),
        "uv": _of_all("uv", parts),
        "groups": _groups(parts, pieces),
        "pieces": pieces,
    }


def _check_kinds(parts: Mapping[str, Mapping[str, Any]]) -> None:
    nets = [piece for piece, part in parts.items() if not len(part["triangle_slope"])]
    if nets and len(nets) < len(parts):
        sheets = ", ".join(piece for piece in parts if piece not in nets)
        raise MeshError(f"{', '.join(nets)} are springs only and {sheets} sheets: one kind is needed throughout")


def _starts(parts: Mapping[str, Mapping[str, Any]]) -> np.ndarray:
    lengths = [np.diff(part["curvature_start"]) for part in parts.values()]
    return np.concatenate([[0], np.cumsum(np.concatenate(lengths))]).astype(np.int32)


def _of_all(name: str, parts: Mapping[str, Mapping[str, Any]]) -> np.ndarray | None:
    """What vertices have if those of all pieces have it."""
    given = [part[name] for part in parts.values()]
    return None if any(array is None for array in given) else np.concatenate(given)


def _groups(parts: Mapping[str, Mapping[str, Any]], pieces: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    groups = dict(pieces)
    for piece, part in parts.items():
        for group, members in part["groups"].items():
            name = f"{piece}_{group}"
            if name in groups:
                raise MeshError(f"two groups would be called {name}: give the piece {piece} another name")
            groups[name] = (members + pieces[piece][0]).astype(np.int32)
    return groups
