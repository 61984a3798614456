"""Obstacles that move as one, or that all stand still, as one field (paper, 4.2.3: compound objects)."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cloth_core.errors import SettingError
from cloth_core.fields.make import Part
from cloth_core.fields.obstacle import FieldObstacle, VoxelField
from cloth_core.fields.solid import Solid
from cloth_core.fields.surface import Closed
from cloth_core.obstacles import ANALYTIC, Obstacle, read_shape
from cloth_core.settings import Settings, check_named

PARTS: dict[str, type[Obstacle]] = {n: shape for n, shape in ANALYTIC.items() if n != "plane"}
PARTS["voxel_field"] = VoxelField
"""Shapes that have an end, by name."""
OF_ALL = {"friction": None, "voxel": None, "query": "trilinear"}
"""What is said of a compound as a whole, and what a part must leave it at."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compound(FieldObstacle):
    """Shapes and meshes that keep their places to each other, known by one distance field.

    ``center`` and ``orientation`` of each of the ``parts`` say where it stands in the frame of the compound. To ask for
    distances costs what it would cost for one of them.
    """

    parts: Mapping[str, Obstacle] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        Settings.__post_init__(self)
        check_named("parts", self.parts, Obstacle, "Box(extents=(1.0, 1.0, 1.0))")
        if not self.parts:
            raise SettingError("parts", f"is empty: names and shapes, each one of {', '.join(PARTS)}")
        for name, part in self.parts.items():
            if type(part) not in PARTS.values():
                raise SettingError(f"parts.{name}", f"is a {type(part).__name__}, not one of {', '.join(PARTS)}")
            for key, plain in OF_ALL.items():
                if getattr(part, key, plain) != plain:
                    raise SettingError(f"parts.{name}.{key}", "has no effect: it is the compound's to say")

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Compound:
        """Build from a section of a scene file, in which ``parts`` are named like obstacles."""
        parts = values.get("parts", {}) if isinstance(values, Mapping) else {}
        if not isinstance(parts, Mapping):
            raise SettingError("parts", f"{parts!r} is not a section of names")
        read = {}
        for name, given in parts.items():
            try:
                read[str(name)] = read_shape(given, PARTS)[1]
            except SettingError as error:
                raise error.under(f"parts.{name}") from None
        return super(Compound, cls).from_mapping({**values, "parts": read} if read else values)

    def as_mapping(self) -> dict[str, Any]:
        """What :meth:`from_mapping` reads back."""
        parts = {name: {_name_of(part): part.as_mapping()} for name, part in self.parts.items()}
        return {**Settings.as_mapping(self), "parts": parts}

    def within(self, folder: Path) -> Compound:
        """The same, with the files of its parts looked up from ``folder``."""
        return replace(self, parts={name: part.within(folder) for name, part in self.parts.items()})

    def check(self) -> None:
        """Check the parts, too."""
        Obstacle.check(self)
        for name, part in self.parts.items():
            try:
                part.check()
            except SettingError as error:
                raise error.under(f"parts.{name}.{_name_of(part)}") from None

    @property
    def pieces(self) -> Sequence[Part]:
        """The parts where they stand."""
        return [(part.mesh, part.pose) if isinstance(part, VoxelField) else part for part in self.parts.values()]

    @property
    def meshes(self) -> Mapping[str, Closed]:
        """Those of the parts that are meshes, each in the frame of its part."""
        return {name: part.mesh for name, part in self.parts.items() if isinstance(part, VoxelField)}

    def with_meshes(self, meshes: Mapping[str, Closed]) -> Compound:
        """The same of surfaces that :attr:`meshes` gave."""
        parts = dict(self.parts)
        for name, mesh in meshes.items():
            parts[name] = parts[name].with_meshes({"": mesh})  # type: ignore[attr-defined]
        return replace(self, parts=parts)

    @property
    def reach(self) -> float:
        """Of the farthest corner of the box around all parts."""
        return float(np.linalg.norm(np.abs(self.box).max(axis=0)))

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """That of all parts."""
        lows, highs = [], []
        for part in self.parts.values():
            if isinstance(part, VoxelField):
                position = part.pose.apply(part.mesh.position)
                low, high = position.min(axis=0), position.max(axis=0)
            else:
                solid = Solid.of_shape(part)
                low, high = solid.low, solid.high
            lows.append(low)
            highs.append(high)
        return np.min(lows, axis=0), np.max(highs, axis=0)


def _name_of(part: Obstacle) -> str:
    return next(name for name, shape in PARTS.items() if type(part) is shape)
