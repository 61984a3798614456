"""Regions of the world that are filled with something other than air: a river, a tank, a jet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from cloth_core.errors import InputError, SettingError
from cloth_core.obstacles import SHAPES, Obstacle, Plane
from cloth_core.pose import Pose
from cloth_core.settings import Settings, check_keys, check_kind, setting

_NAMES = {kind: name for name, kind in SHAPES.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Fluid(Settings):
    """What fills a shape, and how it flows; the cloth goes through its surface as if there were none.

    Water up to the level 0 that flows along x: ``Fluid(shape=Plane(), velocity=(0.5, 0.0, 0.0))``. The shape is one of
    :mod:`cloth_core.obstacles`; that of a plane is all below it.

    Raises:
        SettingError: a value has a wrong type or range, or the shape has a friction.
    """

    shape: Obstacle
    velocity: tuple[float, float, float] = setting(
        "vector", (0.0, 0.0, 0.0), size=3, unit="m/s", low=-100.0, high=100.0, help="velocity of the stream"
    )
    density: float = setting("float", 1000.0, unit="kg/m^3", low=0.0, high=2e4, help="density; 1000: water")
    drag: float | None = setting(
        "float",
        None,
        low=0.0,
        high=10.0,
        help="drag coefficient of a patch face-on; the material's own if omitted",
    )
    skin_drag: float = setting(
        "float", 0.01, low=0.0, high=10.0, help="drag coefficient of a patch along the stream, both sides together"
    )
    displaced: float = setting(
        "float", 1.0, low=0.0, high=1.0,
        help="share of the cloth's volume (area times thickness) that displaces the fluid; a soaked cloth's is "
        "less than 1, for the water is between its fibres",
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_kind("shape", self.shape, Obstacle, "Box(extents=(x, y, z)) (m)")
        if type(self.shape) not in _NAMES:
            allowed = ", ".join(kind.__name__ for kind in _NAMES)
            raise SettingError("shape", f"{type(self.shape).__name__} holds no fluid; allowed are {allowed}")
        if self.shape.friction is not None:
            key = f"{_NAMES[type(self.shape)]}.friction"
            raise SettingError(key, f"{self.shape.friction:g}: a fluid has none; leave it out")
        Settings.__post_init__(self)

    def at(self, pose: Pose) -> Fluid:
        """The same fluid with its shape's frame at ``pose``; a plane's normal is the frame's z axis."""
        turned = {"normal": (0.0, 0.0, 1.0)} if isinstance(self.shape, Plane) else {}
        shape = replace(self.shape, center=pose.position, orientation=pose.orientation, **turned)
        return replace(self, shape=shape)

    def as_mapping(self) -> dict[str, Any]:
        """As a section of a scene file: the shape under its name, beside the settings."""
        return {_NAMES[type(self.shape)]: self.shape.as_mapping(), **Settings.as_mapping(self)}

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Fluid:
        """Read what :meth:`as_mapping` wrote, or a section of a scene file.

        Raises:
            SettingError: a key is unknown, missing, or has a wrong type or range.
        """
        known = [name for name, _ in cls.settings()]
        check_keys(values, [*SHAPES, *known])
        shapes = [name for name in values if name in SHAPES]
        if len(shapes) != 1:
            raise SettingError("", f"needs exactly one shape of {', '.join(SHAPES)}; it has {len(shapes)}")
        (name,) = shapes
        try:
            shape = SHAPES[name].from_mapping(values[name])
            _ = shape.pose
        except SettingError as error:
            raise error.under(name) from None
        except InputError as error:
            raise SettingError(f"{name}.orientation", str(error)) from None
        return cls(shape=shape, **{key: value for key, value in values.items() if key != name})
