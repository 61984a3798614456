"""Laws of what hands and obstacles feel: weights at rest, and the pull of what swings."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.inputs import Grasp, Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Sphere
from cloth_core.pose import Pose
from cloth_core.solver import ClothSolver
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import GRAVITY, fine, last, states

OVERDAMPED = "its viscosity lets a stone that swings sink slowly"


def _hand(place: tuple[float, float, float]) -> Grasp:
    return Grasp(pose=Pose(place), closure=1.0, radius=0.06)


def _weight(solver: ClothSolver) -> float:
    return GRAVITY * float(solver.mesh.vertex_mass(solver.material).sum())


def weight_in_hand(integrator: str) -> Measurement:
    """A hand that holds a cloth by a corner feels its weight at rest, whatever the stretch limit carries of it.

    What creeps to rest is not quite there: meyer2000 has its last hundredths of g for half a minute.
    """
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=16, rows=16)
    solver = ClothSolver(mesh, Material(areal_density=1.0, damping=4.0), fine(integrator))
    grasps = {"hand": _hand((-0.25, 0.25, 0.0))}
    last(solver, solver.initial_state(), Inputs(grasps=grasps), 6.0)
    force = solver.report.grasp_wrenches["hand"].force
    bound = 0.01 if integrator == "meyer2000" else 1e-3
    return Measurement(_weight(solver), -force[2], bound, "N")


def shared_weight(integrator: str) -> Measurement:
    """Two hands at the ends of an edge, drawn together, feel half the weight each; measured is the one farther off."""
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=16, rows=16)
    solver = ClothSolver(mesh, Material(damping=4.0), fine(integrator))
    state = solver.initial_state()
    for n in range(1, 51):
        way = 0.001 * n
        grasps = {"left": _hand((-0.25 + way, 0.25, 0.0)), "right": _hand((0.25 - way, 0.25, 0.0))}
        state = solver.step(state, Inputs(grasps=grasps))
    last(solver, state, Inputs(grasps=grasps), 6.0)
    half = 0.5 * _weight(solver)
    felt = [-solver.report.grasp_wrenches[name].force[2] for name in grasps]
    return Measurement(half, max(felt, key=lambda force: abs(force - half)), 0.01, "N")


def stone_on_a_thread(integrator: str) -> Measurement:
    """A stone let go at an angle a pulls, at the bottom, with m g (3 - 2 cos a)."""
    length, amplitude, mass = 0.5, 0.9, 0.3
    place = np.array([[0.0, 0.0, 0.0], [length * math.sin(amplitude), 0.0, -length * math.cos(amplitude)]])
    thread = ClothMesh.from_springs(place, [[0, 1]], stiffness=2e4, mass=mass, limited=False)
    solver = ClothSolver(thread, Material(damping=0.0), fine(integrator))
    grasps, pull = {"hand": _hand((0.0, 0.0, 0.0))}, []
    for _ in states(solver, solver.initial_state(), Inputs(grasps=grasps), 1.0):
        x, y, z = solver.report.grasp_wrenches["hand"].force
        pull.append(math.hypot(x, y, z + mass * GRAVITY))  # what the end in the hand weighs is no pull
    return Measurement(mass * GRAVITY * (3.0 - 2.0 * math.cos(amplitude)), max(pull), 0.005, "N")


def weight_on_a_ball(integrator: str) -> Measurement:
    """A cloth that lies on a ball presses upon it with its weight, as a mean of a second."""
    mesh = ClothMesh.grid(width=0.6, height=0.6, columns=16, rows=16)
    ball = Sphere(radius=0.25, center=(0.0, 0.0, -0.255))
    solver = ClothSolver(mesh, Material(damping=4.0, friction=0.8), fine(integrator), obstacles={"ball": ball})
    state = last(solver, solver.initial_state(), Inputs(), 4.0)
    press = [-solver.report.obstacle_wrenches["ball"].force[2] for _ in states(solver, state, Inputs(), 1.0)]
    return Measurement(_weight(solver), float(np.mean(press)), 0.02, "N")


LAWS = (
    Law("weight in hand", weight_in_hand),
    Law("shared weight", shared_weight),
    Law("stone on a thread", stone_on_a_thread, exempt={"meyer2000": OVERDAMPED}),
    Law("weight on a ball", weight_on_a_ball),
)
