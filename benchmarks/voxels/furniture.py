"""The furniture of the scene ``office``, thing by thing."""

from __future__ import annotations

from dataclasses import replace

from cloth_core.fields import Compound
from cloth_core.obstacles import Obstacle
from cloth_core.scene import Scene
from cloth_sim_ros.share import find_scene

LAMP = "things_lamp"
"""Stands where the cloth falls."""


def office() -> dict[str, Obstacle]:
    """30 things by name, each where it stands: all but the lamp, the rug and the bust."""
    things: dict[str, Obstacle] = {}
    for group, compound in Scene.load(find_scene("office")).obstacles.items():
        for name, part in compound.parts.items() if isinstance(compound, Compound) else ():
            pose = compound.pose.compose(part.pose)
            things[f"{group}_{name}"] = replace(part, center=pose.position, orientation=pose.orientation)
    return {name: thing for name, thing in things.items() if not name.startswith(LAMP)}


def desk() -> dict[str, Obstacle]:
    """The one that the cloth falls on."""
    return {"desk_top": office()["desk_top"]}
