"""The shapes that obstacles can have, by their names in scene files."""

from __future__ import annotations

from cloth_core.fields import Compound, VoxelField
from cloth_core.obstacles import ANALYTIC, Obstacle

SHAPES: dict[str, type[Obstacle]] = {**ANALYTIC, "voxel_field": VoxelField, "compound": Compound}
