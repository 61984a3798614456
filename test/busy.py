"""A scene in which everything happens at once, for the tests of the whole solver."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig, State, Wind
from cloth_core.obstacles import Plane, Sphere

OBSTACLES = {"ball": Sphere(radius=0.12, center=(0.05, 0.0, -0.2)), "floor": Plane(center=(0.0, 0.0, -0.5))}


def busy_solver(integrator: str, **config: object) -> ClothSolver:
    mesh = ClothMesh.grid(width=0.6, height=0.5, columns=12, rows=10)
    solver = ClothSolver(
        mesh, Material(friction=0.4), SolverConfig(integrator=integrator, **config), obstacles=OBSTACLES
    )
    solver.pin(mesh.group("corners")[:1])
    return solver


def busy_inputs(n: int) -> Inputs:
    """Wind with gusts, a hand that grabs, turns and lets go, a ball that moves."""
    closed = 1.0 if 3 <= n < 18 else 0.0
    turn = tuple(Rotation.from_rotvec([0.0, 0.02 * n, 0.05 * n]).as_quat())
    hand = Grasp(pose=Pose((0.3 - 0.005 * n, -0.25, 0.01 * n), turn), closure=closed, radius=0.1)
    return Inputs(
        grasps={"hand": hand},
        wind=Wind(velocity=(3.0, 1.0, 0.5), gust_intensity=0.4),
        obstacles={"ball": Pose((0.05 + 0.002 * n, 0.0, -0.2))},
    )


def played(solver: ClothSolver, state: State, first: int, last: int) -> State:
    for n in range(first, last):
        state = solver.step(state, busy_inputs(n))
    return state


def assert_same(one: State, other: State) -> None:
    np.testing.assert_array_equal(one.position, other.position)
    np.testing.assert_array_equal(one.velocity, other.velocity)
    assert (one.step_index, one.time, one.digest) == (other.step_index, other.time, other.digest)
    assert one.obstacles == other.obstacles
    assert one.grips.keys() == other.grips.keys()
    for name, grip in one.grips.items():
        assert (grip.pose, grip.closed) == (other.grips[name].pose, other.grips[name].closed)
        np.testing.assert_array_equal(grip.vertex, other.grips[name].vertex)
        np.testing.assert_array_equal(grip.offset, other.grips[name].offset)
