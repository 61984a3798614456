"""Masses joined by springs: see :meth:`cloth_core.mesh.ClothMesh.from_springs`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cloth_core.errors import MeshError, shown
from cloth_core.meshing import checks, faults
from cloth_core.meshing.areas import vertex_areas
from cloth_core.meshing.directions import GIVEN

LIGHTEST = 1e-12
"""kg."""


def fields(
    position: Any,
    springs: Any,
    stiffness: Any,
    mass: Any,
    rest_length: Any,
    limited: Any,
    triangles: Any,
    groups: Mapping[str, Sequence[int]],
) -> dict[str, Any]:
    """The fields of the mesh."""
    position = checks.as_numbers("positions", position, 3, " (m)")
    checks.check_positions(position)
    springs = checks.as_indices("springs", springs, 2, len(position))
    checks.refuse("springs that repeat an earlier one", faults.repeated(springs), "join them (stiffnesses add up)")
    triangles = checks.as_indices("triangles", () if triangles is None else triangles, 3, len(position))
    checks.check_shapes(position, triangles)
    checks.refuse("triangles that repeat an earlier one", faults.repeated(triangles), "remove them")

    weight = np.zeros((len(springs), 4))
    weight[:, GIVEN] = _each("stiffness (N/m)", stiffness, len(springs), 0.0)
    placed = np.linalg.norm(position[springs[:, 0]] - position[springs[:, 1]], axis=1)
    rest = _each("rest length (m)", placed if rest_length is None else rest_length, len(springs), 0.0)
    held = _each("limited (true or false)", limited, len(springs), 0.0).astype(bool)
    checks.refuse(
        f"springs with a stretch limit that are shorter than {faults.ATOM:g} m",
        np.flatnonzero(held & (rest < faults.ATOM)),
        "make them longer or limited=False: a share of nothing limits nothing",
    )
    return dict(
        rest_position=position,
        triangles=triangles,
        spring_vertex=springs,
        spring_rest=rest,
        spring_weight=weight,
        spring_limited=held,
        spring_bias=np.ones(len(springs)),
        triangle_slope=np.zeros((0, 3, 2)),
        hinge_vertex=np.zeros((0, 4), np.int32),
        curvature_start=np.zeros(1, np.int32),
        curvature_vertex=np.zeros(0, np.int32),
        curvature_weight=np.zeros(0),
        vertex_area=vertex_areas(position, triangles),
        explicit_mass=_each("mass (kg)", mass, len(position), LIGHTEST),
        groups=checks.check_groups(groups, len(position)),
    )


def _each(what: str, values: Any, count: int, least: float) -> np.ndarray:
    """(``count``,) float64 of one number for all, or one for each; at least ``least``."""
    try:
        numbers = np.broadcast_to(np.asarray(values, float), count).copy()
    except (TypeError, ValueError, OverflowError):
        raise MeshError(f"{what} must be one number for all or {count} numbers, not {shown(values)}") from None
    wrong = np.flatnonzero(~(np.isfinite(numbers) & (numbers >= least)))
    checks.refuse(f"{what} that is no finite number of at least {least:g}", wrong, "correct it")
    return numbers
