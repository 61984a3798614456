"""Laws of dry friction on an inclined and on a level plane."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.inputs import Grasp, Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Capsule, Plane
from cloth_core.pose import Pose
from cloth_core.solver import ClothSolver
from cloth_core.state import State
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import GRAVITY, UNLIMITED, fine, last, moving

TAUT = "its long steps carry a taut belt into the cylinder, and what pushes it out is no measure of its pull"


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


def capstan(integrator: str) -> Measurement:
    """Drawn over a fixed cylinder by half a turn, a belt pulls e^(mu pi) times as hard at one end as at the other.

    With ten iterations: in one, threads pull as if the cylinder let them through, and the ratio is 9 % too large
    where the tension is the weight of the belt; the error grows with tension over mass.
    """
    friction, radius, length, width = 0.3, 0.1, 1.0, 0.02
    mesh = ClothMesh.grid(width=length, height=width, columns=81, rows=2)
    material = Material(
        friction=friction, areal_density=1.0, bend=0.0, damping=0.2,
        stretch_warp=200.0, stretch_weft=200.0, shear=20.0, stretch_limit=UNLIMITED,
    )  # fmt: skip
    cylinder = Capsule(radius=radius, length=1.0, orientation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    config = fine(integrator, iterations=10, contact_shell=0.002)
    solver = ClothSolver(mesh, material, config, obstacles={"cylinder": cylinder})
    along, reach = mesh.rest_position[:, 0], 0.5 * math.pi * (radius + config.contact_shell)
    angle = np.clip(along, -reach, reach) / (radius + config.contact_shell)
    outer = (radius + config.contact_shell) * np.sin(angle)
    height = (radius + config.contact_shell) * np.cos(angle) - np.maximum(np.abs(along) - reach, 0.0)
    state = State(np.column_stack([outer, mesh.rest_position[:, 1], height]), np.zeros((len(along), 3)),
                  obstacles=solver.initial_state().obstacles)  # fmt: skip
    pull = []
    for n in range(150):  # both ends draw the belt taut, then one of them draws it across
        taut, across = 0.02 * min(1.0, n / 25), 0.001 * max(0, n - 35)
        grasps = {
            name: Grasp(pose=Pose((side * outer.max(), 0.0, height.min() - taut + side * across)), closure=1.0,
                        radius=0.8 * width)
            for name, side in (("drawn", -1.0), ("dragged", 1.0))
        }  # fmt: skip
        state = solver.step(state, Inputs(grasps=grasps, gravity=(0.0, 0.0, 0.0)))
        pull.append([solver.report.grasp_wrenches[name].force[2] for name in grasps])
    drawn, dragged = np.mean(pull[-50:], axis=0)
    return Measurement(math.exp(friction * math.pi), float(drawn / dragged), 0.03)


LAWS = (
    Law("incline threshold", incline_threshold),
    Law("sliding acceleration", sliding_acceleration),
    Law("stopping distance", stopping_distance),
    Law("capstan", capstan, exempt={"meyer2000": TAUT}),
)
