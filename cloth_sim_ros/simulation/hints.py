"""What a person at the hands is told: why they hold nothing, or nothing any more."""

from __future__ import annotations

from cloth_sim_ros.simulation.frame import Frame
from cloth_sim_ros.simulation.notices import Notices


def say_hints(hints: Notices, frame: Frame, most_force: float) -> None:
    """Say of grasps that closed on nothing, or lost the cloth, why that is; ``most_force`` N is what they bear."""
    for name in frame.report.empty:
        grasp = frame.inputs.grasps[name]
        where = ", ".join(f"{c:.3f}" for c in grasp.pose.position)
        nothing = f"no vertex is within its radius of {grasp.radius:g} m around ({where})"
        hints.say(f"grasp {name} closed on nothing", f"grasp {name} closed on nothing: {nothing}")
    for slip in frame.report.slips:
        if slip.load:
            why = f"it had to bear {slip.load:.3g} N, solver.max_grasp_force is {most_force:g} N"
        else:
            most = frame.inputs.grasps[slip.name].slip_distance
            why = f"its hand was {slip.beyond:.3g} m ahead of the cloth, slip_distance is {most:g} m"
        text = f"grasp {slip.name} lost the cloth: {why}; open and close it again"
        hints.say(f"grasp {slip.name} slipped", text)
