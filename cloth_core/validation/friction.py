"""Laws of dry friction on an inclined and on a level plane."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.inputs import Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Plane
from cloth_core.pose import Pose
from cloth_core.solver import ClothSolver
from cloth_core.state import State
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import GRAVITY, fine, last, moving


def _on_plane(integrator: str, slope: float, friction: float) -> tuple[ClothSolver, State, np.ndarray]:
    """A patch that lies on a plane of ``slope`` = tan(angle), its state at rest, and the direction downhill."""
    angle = math.atan(slope)
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    downhill = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    solver = ClothSolver(
        ClothMesh.grid(width=0.2, height=0.2, columns=4, rows=4),
        Material(friction=friction),
        fine(integrator),
        obstacles={"ground": Plane(normal=tuple(normal))},
    )
    half = 0.5 * angle
    lying = Pose(tuple(normal * solver.config.contact_shell), (0.0, math.sin(half), 0.0, math.cos(half)))
    return solver, solver.initial_state(lying), downhill


def incline_threshold(integrator: str) -> Measurement:
    """A patch on a slope slides if and only if tan(angle) > mu.

    Measured is the least slope that slides, found by bisection.
    """
    friction, holds, slides = 0.5, 0.25, 1.0
    for _ in range(14):
        slope = 0.5 * (holds + slides)
        solver, state, downhill = _on_plane(integrator, slope, friction)
        way = (last(solver, state, Inputs(), 0.4).position - state.position) @ downhill
        if way.mean() > 1e-6:
            slides = slope
        else:
            holds = slope
    return Measurement(friction, 0.5 * (holds + slides), 2e-4)


def sliding_acceleration(integrator: str) -> Measurement:
    """Down a slope of angle t steeper than mu a patch accelerates with g (sin t - mu cos t).

    Read off the speed after half a second; that of the midpoint rule is the mean one of its last substep.
    """
    friction, slope, duration = 0.3, 0.7, 0.5
    solver, state, downhill = _on_plane(integrator, slope, friction)
    angle = math.atan(slope)
    speed = (last(solver, state, Inputs(), duration).velocity @ downhill).mean()
    lateness = 0.0 if integrator == "meyer2000" else 0.5 * solver.config.dt / solver.substeps
    expected = GRAVITY * (math.sin(angle) - friction * math.cos(angle))
    return Measurement(expected, float(speed) / (duration - lateness), 1e-9, "m/s^2")


def stopping_distance(integrator: str) -> Measurement:
    """Thrown along a level plane with v0, a patch stops after v0^2 / (2 mu g).

    A step h of the paper takes its share of speed before it moves, so that v0 h / 2 is missing: the error to
    expect. The midpoint rule errs within its last substep alone, by less than mu g h^2 / 2.
    """
    friction, speed = 0.3, 2.0
    solver, lying, _ = _on_plane(integrator, 0.0, friction)
    state = State(lying.position, moving(solver, np.array([speed, 0.0, 0.0])).velocity, obstacles=lying.obstacles)
    way = (last(solver, state, Inputs(), 1.0).position - lying.position)[:, 0].mean()
    bound = 0.004 if integrator == "meyer2000" else 1e-5
    return Measurement(speed**2 / (2 * friction * GRAVITY), float(way), bound, "m")


LAWS = (
    Law("incline threshold", incline_threshold),
    Law("sliding acceleration", sliding_acceleration),
    Law("stopping distance", stopping_distance),
)
