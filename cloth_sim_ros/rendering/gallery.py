"""Which pictures the documents show: for every scene its best moment, and the animation of the README."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Shot:
    """A still.

    Args:
        time: s after the scene's start.
        fabric: what the cloth is printed with.
    """

    time: float = 4.0
    fabric: str = "silk"


@dataclass(frozen=True)
class Clip:
    """An animation of a scene from ``start`` to ``end`` s."""

    scene: str
    start: float
    end: float
    fps: float
    size: tuple[int, int]


SHOTS = {
    "scarf": Shot(2.8, "silk"),
    "flag": Shot(4.0, "bunting"),
    "drape": Shot(3.0, "cotton"),
    "tablecloth": Shot(6.4, "gingham"),
    "gripper": Shot(6.0, "silk"),
    "runner": Shot(5.2, "silk"),
    "clothesline": Shot(5.2, "silk"),
    "mannequin": Shot(2.5, "cotton"),
    "bust": Shot(5.0, "silk"),
    "office": Shot(3.3, "gingham"),
    "ellipsoid_man": Shot(4.0, "silk"),
}
"""By the scene's name; others are shown by ``Shot()``."""

README_CLIP = Clip("scarf", 0.4, 13.4, 20.0, (480, 360))
