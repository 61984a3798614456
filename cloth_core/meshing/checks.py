"""Refuses what makes no physical sense, with the elements at fault and what to do about them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cloth_core.errors import MeshError
from cloth_core.meshing import faults

SHOWN = 8
"""Elements that a message names; of further ones it gives the number."""


def listed(elements: np.ndarray) -> str:
    """The first few elements, for a message; edges as ``3-8``."""
    shown = ", ".join("-".join(map(str, np.atleast_1d(element))) for element in elements[:SHOWN])
    return f"{shown} and {len(elements) - SHOWN} more" if len(elements) > SHOWN else shown


def refuse(what: str, elements: np.ndarray, remedy: str) -> None:
    """Raise a :class:`MeshError` if there are any ``elements`` at fault."""
    if len(elements):
        raise MeshError(f"{what}: {listed(elements)}; {remedy}")


def is_positive(number: Any) -> bool:
    """Whether that is one finite number above zero."""
    try:
        return not isinstance(number, str) and 0.0 < float(number) < math.inf
    except (TypeError, ValueError, OverflowError):
        return False


def as_numbers(what: str, values: Any, columns: int, unit: str) -> np.ndarray:
    """(N, ``columns``) float64, a copy; not yet checked for being finite."""
    try:
        numbers = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise MeshError(f"{what} must be rows of {columns} numbers{unit}") from None
    if numbers.ndim != 2 or numbers.shape[1] != columns:
        raise MeshError(f"{what} must be rows of {columns} numbers{unit}, not an array of the shape {numbers.shape}")
    return numbers


def as_indices(what: str, values: Any, columns: int, vertex_count: int) -> np.ndarray:
    """(N, ``columns``) int32, a copy, of vertices that exist and differ within a row."""
    numbers = _whole(what, values)
    if numbers.size == 0:
        return np.zeros((0, columns), np.int32)
    if numbers.ndim != 2 or numbers.shape[1] != columns:
        raise MeshError(f"{what} must be rows of {columns} vertex numbers, not an array of the shape {numbers.shape}")
    check_indices(what, numbers, vertex_count)
    return numbers.astype(np.int32)


def _whole(what: str, values: Any) -> np.ndarray:
    """Int64 of any shape; fractions are refused, not cut off."""
    try:
        given = np.asarray(values)
    except ValueError:  # rows of different lengths
        given = np.asarray(None)
    if given.size == 0:
        return np.zeros(given.shape, np.int64)
    with np.errstate(invalid="ignore"):
        numbers = given.astype(np.int64) if given.dtype.kind in "iuf" else None
    if numbers is None or not (numbers == given).all():
        raise MeshError(f"{what} must be vertex numbers: whole numbers from 0, equally many in each row")
    return numbers


def check_positions(position: np.ndarray, vertices: np.ndarray | None = None) -> None:
    """Refuse no vertices at all, and places that are no places; looks at certain ``vertices`` or all."""
    if position.ndim != 2 or position.shape[1] != 3 or len(position) == 0:
        raise MeshError(f"positions must have the shape (V, 3) with V > 0, not {position.shape}")
    wrong = faults.unplaced(position) if vertices is None else vertices[faults.unplaced(position[vertices])]
    refuse(f"vertices not finite or beyond +-{faults.LARGEST_COORDINATE:g} m", wrong, "correct coordinates or unit")


def check_indices(what: str, elements: np.ndarray, vertex_count: int) -> None:
    """Refuse elements that name a vertex that does not exist, or the same one twice."""
    refuse(
        f"{what} that name vertices outside 0 .. {vertex_count - 1}",
        faults.outside(elements, vertex_count),
        "correct or remove them (vertices count from 0)",
    )
    refuse(f"{what} that name the same vertex twice", faults.collapsed(elements), "remove them")


def check_shapes(position: np.ndarray, triangles: np.ndarray) -> None:
    """Refuse triangles without a shape."""
    refuse(
        f"triangles without area, or less high than {faults.SLIVER:g} of their longest edge or {faults.ATOM:g} m",
        faults.slivers(position, triangles),
        "remove them, joining their vertices, or mesh the sheet more evenly",
    )


def check_edges(triangles: np.ndarray, number: np.ndarray | None = None) -> None:
    """Refuse edges of more than two triangles; ``number`` (T,) is what a message calls the triangles."""
    edges, around = faults.crowded(triangles)
    around = around if number is None else number[around]
    together = f"remove all but two of the triangles at each ({listed(around)}), or make the flaps separate parts"
    refuse("edges of more than two triangles", edges, together)


def check_sides(triangles: np.ndarray, number: np.ndarray | None = None) -> np.ndarray:
    """Refuse surfaces with one side; returns the triangles (places in ``triangles``) wound against their neighbours."""
    against, one_sided = faults.turned(triangles)
    one_sided = one_sided if number is None else number[one_sided]
    refuse("triangles of a surface with one side only (a Moebius strip)", one_sided, "cut it open along a line")
    return against


def check_sheet(position: np.ndarray, triangles: np.ndarray) -> None:
    """Refuse what is no sheet of cloth; positions and indices were checked before."""
    if len(triangles) == 0:
        raise MeshError("no triangles; chains and nets without a surface are for from_springs")
    check_shapes(position, triangles)
    refuse("triangles that repeat an earlier one", faults.repeated(triangles), "remove them")
    check_edges(triangles)
    refuse("triangles wound against their neighbours", check_sides(triangles), "reverse the order of their vertices")
    refuse("vertices that belong to no triangle", faults.unused(len(position), triangles), "remove them")


def check_uv(uv: Any, vertex_count: int) -> np.ndarray | None:
    """(V, 2) finite texture coordinates, a copy, or None."""
    if uv is None:
        return None
    checked = as_numbers("uv", uv, 2, "")
    if len(checked) != vertex_count:
        raise MeshError(f"uv must have a row for each of the {vertex_count} vertices, not {len(checked)}")
    refuse("vertices whose uv is not finite", np.flatnonzero(~np.isfinite(checked).all(axis=1)), "correct them")
    return checked


def check_groups(groups: Mapping[str, Sequence[int]], vertex_count: int) -> dict[str, np.ndarray]:
    """Vertex numbers by name, int32."""
    named = {}
    for name, members in groups.items():
        numbers = _whole(f"members of the group {name!r}", members).ravel()
        wrong = numbers[(numbers < 0) | (numbers >= vertex_count)]
        refuse(f"members of the group {name!r} outside 0 .. {vertex_count - 1}", wrong, "correct or remove them")
        named[name] = numbers.astype(np.int32)
    return named


def check_arrays(arrays: Mapping[str, np.ndarray]) -> None:
    """Refuse numbers that are not finite, the last line of defence; ``arrays`` by name, one row an element."""
    for name, values in arrays.items():
        wrong = ~np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
        refuse(f"{name} not finite at", np.flatnonzero(wrong), "the mesh is too extreme to compute with")
