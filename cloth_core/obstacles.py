"""What the cloth collides with: analytic shapes that stand still or move.

Every shape lives in a frame of its own, centred on the origin; ``center`` and ``orientation`` say
where that frame stands at the start.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cloth_core.errors import SettingError
from cloth_core.pose import Pose
from cloth_core.settings import Settings, setting

PLANE, SPHERE, BOX, CAPSULE, ELLIPSOID = range(5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle(Settings):
    """What all shapes have in common."""

    kind: ClassVar[int]

    center: tuple[float, float, float] = setting(
        "vector", (0.0, 0.0, 0.0), size=3, unit="m", low=-1e6, high=1e6, help="position at the start"
    )
    orientation: tuple[float, float, float, float] = setting(
        "vector", (0.0, 0.0, 0.0, 1.0), size=4, low=-1.0, high=1.0, help="quaternion x, y, z, w at the start"
    )
    friction: float | None = setting(
        "float", None, low=0.0, high=10.0, help="Coulomb coefficient against cloth; the material's own if omitted"
    )

    @property
    def pose(self) -> Pose:
        """Where the obstacle stands at the start."""
        return Pose(self.center, self.orientation)

    @property
    def size(self) -> tuple[float, float, float]:
        """The three numbers that the contact kernels know the shape by."""
        raise NotImplementedError

    @property
    def reach(self) -> float:
        """Radius in m of a sphere around the frame's origin that holds the shape."""
        raise NotImplementedError

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the edges in m of a box about the frame's origin, along its axes, that holds the shape."""
        return (self.reach, self.reach, self.reach)

    @property
    def roundness(self) -> float:
        """Least radius of curvature of the surface in m; 0 if it has edges."""
        raise NotImplementedError

    @property
    def inradius(self) -> float:
        """Radius in m of the largest ball that fits inside."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True, kw_only=True)
class Plane(Obstacle):
    """Everything below the frame's x-y plane is solid; ``normal`` turns the frame's z axis to it."""

    kind: ClassVar[int] = PLANE
    normal: tuple[float, float, float] = setting(
        "vector", (0.0, 0.0, 1.0), size=3, low=-1e6, high=1e6, help="direction that faces the cloth, of any length"
    )

    def __post_init__(self) -> None:
        Settings.__post_init__(self)
        if np.linalg.norm(self.normal) < 1e-9:
            raise SettingError("normal", f"{self.normal} has no direction: it is shorter than 1e-9")

    @property
    def pose(self) -> Pose:
        """Frame at ``center`` whose z axis is the normal."""
        z = np.array(self.normal) / np.linalg.norm(self.normal)
        turn = (-z[1], z[0], 0.0, 1.0 + z[2]) if z[2] > -1.0 + 1e-12 else (1.0, 0.0, 0.0, 0.0)
        return Pose(self.center).compose(Pose(orientation=turn)).compose(Pose(orientation=self.orientation))

    @property
    def size(self) -> tuple[float, float, float]:
        """Nothing to say: a plane has no size."""
        return (0.0, 0.0, 0.0)

    @property
    def reach(self) -> float:
        """A plane goes on for ever."""
        return float("inf")

    @property
    def roundness(self) -> float:
        """A plane does not bend."""
        return float("inf")

    @property
    def inradius(self) -> float:
        """Below a plane there is room for any ball."""
        return float("inf")


@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere(Obstacle):
    """A ball."""

    kind: ClassVar[int] = SPHERE
    radius: float = setting("float", help="radius", unit="m", low=1e-4, high=1e3)

    @property
    def size(self) -> tuple[float, float, float]:
        """The radius."""
        return (self.radius, 0.0, 0.0)

    @property
    def reach(self) -> float:
        """The radius."""
        return self.radius

    @property
    def roundness(self) -> float:
        """The radius."""
        return self.radius

    @property
    def inradius(self) -> float:
        """The radius."""
        return self.radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Box(Obstacle):
    """A cuboid."""

    kind: ClassVar[int] = BOX
    extents: tuple[float, float, float] = setting(
        "vector", help="full edge lengths", size=3, unit="m", low=1e-4, high=1e3
    )

    @property
    def size(self) -> tuple[float, float, float]:
        """Half the edge lengths."""
        return tuple(0.5 * e for e in self.extents)  # type: ignore[return-value]

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Half the edge lengths."""
        return self.size

    @property
    def reach(self) -> float:
        """Half the space diagonal."""
        return float(np.linalg.norm(self.size))

    @property
    def roundness(self) -> float:
        """A box has edges."""
        return 0.0

    @property
    def inradius(self) -> float:
        """Half the shortest edge."""
        return min(self.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class Capsule(Obstacle):
    """A rod with round ends along the frame's z axis; ``length`` is measured between the centres of the ends."""

    kind: ClassVar[int] = CAPSULE
    radius: float = setting("float", help="radius", unit="m", low=1e-4, high=1e3)
    length: float = setting("float", help="distance between the centres of the round ends", unit="m", low=0.0, high=1e3)

    @property
    def size(self) -> tuple[float, float, float]:
        """Radius and half length."""
        return (self.radius, 0.5 * self.length, 0.0)

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Radius, radius, half the whole length."""
        return (self.radius, self.radius, self.reach)

    @property
    def reach(self) -> float:
        """Half the whole length."""
        return self.radius + 0.5 * self.length

    @property
    def roundness(self) -> float:
        """The radius."""
        return self.radius

    @property
    def inradius(self) -> float:
        """The radius."""
        return self.radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Ellipsoid(Obstacle):
    """An ellipsoid along the frame's axes."""

    kind: ClassVar[int] = ELLIPSOID
    radii: tuple[float, float, float] = setting(
        "vector", help="semi-axes along x, y, z", size=3, unit="m", low=1e-3, high=1e3
    )

    @property
    def size(self) -> tuple[float, float, float]:
        """The semi-axes."""
        return self.radii

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """The semi-axes."""
        return self.radii

    @property
    def reach(self) -> float:
        """The longest semi-axis."""
        return max(self.radii)

    @property
    def roundness(self) -> float:
        """That at the end of the longest semi-axis, across the shortest."""
        return min(self.radii) ** 2 / max(self.radii)

    @property
    def inradius(self) -> float:
        """The shortest semi-axis."""
        return min(self.radii)


SHAPES: dict[str, type[Obstacle]] = {
    "plane": Plane,
    "sphere": Sphere,
    "box": Box,
    "capsule": Capsule,
    "ellipsoid": Ellipsoid,
}
