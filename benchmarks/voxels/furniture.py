"""An office: desks, chairs, shelves, bins, lamps and a plant."""

from __future__ import annotations

from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Sphere

DESK = {"desk": Box(extents=(1.4, 0.7, 0.04), center=(0.0, 0.0, 0.74))}
"""The one that the cloth falls on."""


def office() -> dict[str, Obstacle]:
    """30 things in a room of 5 x 4 m, the first of them that desk."""
    things: dict[str, Obstacle] = dict(DESK)
    for n, (x, y) in enumerate([(-0.65, -0.3), (0.65, -0.3), (-0.65, 0.3), (0.65, 0.3)]):
        things[f"leg_{n}"] = Box(extents=(0.05, 0.05, 0.72), center=(x, y, 0.36))
    for n, (x, y) in enumerate([(0.0, 0.75), (-1.8, 0.4), (1.9, -0.5)]):
        things[f"seat_{n}"] = Ellipsoid(radii=(0.24, 0.24, 0.05), center=(x, y, 0.46))
        things[f"back_{n}"] = Box(extents=(0.42, 0.04, 0.45), center=(x, y + 0.24, 0.75))
        things[f"post_{n}"] = Capsule(radius=0.03, length=0.3, center=(x, y, 0.25))
        things[f"foot_{n}"] = Ellipsoid(radii=(0.28, 0.28, 0.04), center=(x, y, 0.06))
    for n, z in enumerate((0.05, 0.45, 0.85, 1.25, 1.65)):
        things[f"shelf_{n}"] = Box(extents=(1.6, 0.3, 0.03), center=(0.0, -1.4, z))
    for n, x in enumerate((-0.8, 0.8)):
        things[f"side_{n}"] = Box(extents=(0.03, 0.3, 1.7), center=(x, -1.4, 0.85))
    things["bin"] = Capsule(radius=0.14, length=0.15, center=(0.9, 0.6, 0.22))
    things["lamp"] = Sphere(radius=0.12, center=(-0.55, -0.2, 1.2))
    things["stem"] = Capsule(radius=0.012, length=0.4, center=(-0.55, -0.2, 0.96))
    things["pot"] = Ellipsoid(radii=(0.16, 0.16, 0.18), center=(-2.0, -1.2, 0.18))
    things["plant"] = Ellipsoid(radii=(0.3, 0.3, 0.45), center=(-2.0, -1.2, 0.8))
    things["cabinet"] = Box(extents=(0.45, 0.6, 0.7), center=(2.1, 1.2, 0.35))
    return things
