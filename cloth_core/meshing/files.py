"""Vertices and triangles of mesh files, numbered as in the file."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from cloth_core.errors import MeshError


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """(V, 3) float64 in the file's unit and (T, 3) int64, from 0, unchecked.

    Raises:
        MeshError: the file cannot be read; the message says why, and leaves it to the caller to name the file.
    """
    kind = path.suffix.lower()
    if not path.is_file():
        problem = "it is a folder" if path.is_dir() else "there is no such file"
        raise MeshError(f"cannot be read as a mesh: {problem}")
    try:
        return _read_obj(path) if kind == ".obj" else _read_any(path)
    except _LineError as error:
        raise MeshError(f"cannot be read as a mesh: {error}") from None
    except OSError as error:
        raise MeshError(f"cannot be read as a mesh: {error.strerror or error}") from None
    except Exception:  # whatever trimesh stumbles over, its words are about its own code
        if kind.lstrip(".") not in _formats().split(", "):
            raise MeshError(f"cannot be read as a mesh: {kind or 'no ending'} is not one of {_formats()}") from None
        raise MeshError(f"cannot be read as a mesh: it does not hold a whole and sound {kind} file") from None


class _LineError(ValueError):
    """A line of a text file makes no sense; the message has it."""


def _formats() -> str:
    import trimesh

    return ", ".join(sorted(trimesh.available_formats()))


def _read_any(path: Path) -> tuple[np.ndarray, np.ndarray]:
    import trimesh

    mesh = trimesh.load(str(path), force="mesh", process=False, skip_materials=True)
    return np.array(mesh.vertices, dtype=float).reshape(-1, 3), np.array(mesh.faces, dtype=np.int64).reshape(-1, 3)


def _read_obj(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Wavefront OBJ, the format of cloth: trimesh renumbers its vertices and drops those without a triangle."""
    position: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        keyword, *values = line.split("#")[0].split() or [""]
        try:
            if keyword == "v":
                x, y, z = values[:3]
                position.append([float(x), float(y), float(z)])
            elif keyword == "f":
                corners = [int(value.split("/")[0]) for value in values]
                # 1 is the first vertex, -1 the last one above this line; 0 is none, and -1 here.
                corners = [c - 1 if c >= 0 else len(position) + c for c in corners]
                triangles += [(corners[0], b, c) for b, c in itertools.pairwise(corners[1:])]
        except ValueError:
            raise _LineError(f"line {number} is not a vertex or face of an OBJ file: {line.strip()[:60]!r}") from None
    return np.array(position, dtype=float).reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3)
