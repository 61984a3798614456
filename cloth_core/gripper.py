"""Two-finger grippers: pairs of obstacles that hold by friction what they press together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cloth_core.errors import SettingError
from cloth_core.obstacles import ANALYTIC, FIELD, Obstacle
from cloth_core.settings import Settings, check_named, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class Gripper(Settings):
    """Two obstacles whose surfaces face each other, and the force with which they close.

    Positions of fingers are given, so nothing can be read off them about the force: as a force-controlled gripper does,
    they press with ``force`` whatever is between them, as soon as it is squeezed. Cloth is two contact shells thick.
    It is held as long as it pulls along the fingers with no more than Coulomb allows, the sum of both coefficients of
    friction times ``force``.
    """

    left: str = setting("str", help="name of the obstacle that is one finger")
    right: str = setting("str", help="name of the obstacle that is the other finger")
    force: float = setting(
        "float", 20.0, unit="N", low=0.0, high=1e4, help="with which the fingers press what is between them"
    )


def check_grippers(grippers: object, obstacles: Mapping[str, Obstacle]) -> None:
    """Refuse grippers whose fingers do not exist, are one, or are distance fields.

    Raises:
        SettingError: naming the gripper, the finger, and the obstacles that there are.
    """
    check_named("grippers", grippers, Gripper, 'Gripper(left="thumb", right="finger")')
    for name, gripper in grippers.items():  # type: ignore[attr-defined]
        for side in ("left", "right"):
            finger = getattr(gripper, side)
            if finger not in obstacles:
                known = ", ".join(obstacles) or "none"
                raise SettingError(f"grippers.{name}.{side}", f"no obstacle {finger!r}; this scene has {known}")
            if obstacles[finger].kind == FIELD:
                shapes = ", ".join(ANALYTIC)
                raise SettingError(f"grippers.{name}.{side}", f"{finger!r} is a mesh; fingers are one of {shapes}")
        if gripper.left == gripper.right:
            raise SettingError(f"grippers.{name}.right", f"{gripper.right!r} is the left finger already")
