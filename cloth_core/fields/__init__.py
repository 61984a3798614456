"""Distance fields of closed meshes and of groups of obstacles (paper, 4.2)."""

from cloth_core.fields.field import Field, Pool, pooled
from cloth_core.fields.make import make
from cloth_core.fields.obstacle import VoxelField
from cloth_core.fields.solid import Solid
from cloth_core.fields.surface import Closed, closed, read_closed

__all__ = ["Closed", "Field", "Pool", "Solid", "VoxelField", "closed", "make", "pooled", "read_closed"]
