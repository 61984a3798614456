"""Contacts: nothing stays inside, nothing is shot away, what moves drags along."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig, State
from cloth_core.kernels.shapes import signed_distance
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere

SHELL = SolverConfig().contact_shell
BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
WEIGHTLESS = (0.0, 0.0, 0.0)


def shapes(seed: int) -> dict[str, Obstacle]:
    """One of each kind in a random pose near the origin."""
    turns = Rotation.random(3, rng=seed).as_quat()
    return {
        "plane": Plane(normal=(0.2, -0.1, 1.0), center=(0.0, 0.0, -0.1)),
        "sphere": Sphere(radius=0.15),
        "box": Box(extents=(0.3, 0.2, 0.15), orientation=tuple(turns[0])),
        "capsule": Capsule(radius=0.08, length=0.25, orientation=tuple(turns[1])),
        "ellipsoid": Ellipsoid(radii=(0.2, 0.12, 0.08), orientation=tuple(turns[2])),
    }


def distances(shape: Obstacle, position: np.ndarray, pose: Pose | None = None) -> np.ndarray:
    """Signed distance of every vertex."""
    local = (pose or shape.pose).inverse_apply(position)
    return np.array([signed_distance(shape.kind, np.array(shape.size), *p)[0] for p in local])


def dropping(shape: Obstacle, integrator: str, height: float = 0.25) -> tuple[ClothSolver, State]:
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=15, rows=15)
    solver = ClothSolver(mesh, Material(friction=0.5), SolverConfig(integrator=integrator), obstacles={"it": shape})
    return solver, solver.initial_state(Pose((0.013, 0.021, height), (0.05, 0.02, 0.0, 1.0)))


@BOTH
@pytest.mark.parametrize("kind", ["plane", "sphere", "box", "capsule", "ellipsoid"])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_dropped_cloth_never_gets_inside(integrator, kind, seed):
    shape = shapes(seed)[kind]
    solver, state = dropping(shape, integrator)
    touched = 0
    for _ in range(50):
        state = solver.step(state, Inputs())
        touched = max(touched, solver.report.contacts)
        assert distances(shape, state.position).min() > -1e-6
    assert touched > 0


@BOTH
def test_a_still_cloth_on_a_plane_stays_still(integrator):
    mesh = ClothMesh.grid(width=0.4, height=0.4, columns=8, rows=8)
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator), obstacles={"floor": Plane()})
    start = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    state = start
    for _ in range(100):
        state = solver.step(state, Inputs())
        np.testing.assert_allclose(state.velocity, 0, atol=1e-9)
    np.testing.assert_allclose(state.position, start.position, atol=1e-9)


@BOTH
@pytest.mark.parametrize("speed", [0.3, 2.0])
def test_an_obstacle_that_jumps_into_the_cloth_pushes_no_faster_than_allowed(integrator, speed):
    """The box appears around a part of a weightless cloth: it comes out at max_push_speed and is then at rest."""
    mesh = ClothMesh.grid(width=0.3, height=0.3, columns=7, rows=7)
    config = SolverConfig(integrator=integrator, max_push_speed=speed, air_density=0.0)
    box = Box(extents=(1.0, 1.0, 0.2), center=(0.0, 0.0, -5.0))
    solver = ClothSolver(mesh, Material(), config, obstacles={"box": box})
    state = solver.initial_state()
    inside = Inputs(gravity=WEIGHTLESS, obstacles={"box": Pose((0.0, 0.0, -0.06))})
    first = True
    for _ in range(round(0.1 / speed / config.dt) + 5):
        before, state = state, solver.step(state, inside)
        assert solver.report.teleported == (("box",) if first else ())
        moved = np.linalg.norm(state.position - before.position, axis=1).max()
        assert moved <= speed * config.dt * (1 + 1e-9)
        assert np.linalg.norm(state.velocity, axis=1).max() < 1e-9
        first = False
    np.testing.assert_allclose(state.position[:, 2], 0.04 + SHELL, atol=1e-9)


@BOTH
def test_a_moving_plane_drags_cloth_along(integrator):
    """Friction brings the cloth to the surface's speed within the time v / (mu g), and no sooner."""
    speed, friction = 0.5, 0.4
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    config = SolverConfig(integrator=integrator, substeps=10, air_density=0.0)
    solver = ClothSolver(mesh, Material(friction=friction), config, obstacles={"belt": Plane()})
    state = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    history = []
    for n in range(1, 16):
        state = solver.step(state, Inputs(obstacles={"belt": Pose((speed * n * config.dt, 0.0, 0.0))}))
        history.append(state.velocity[:, 0].mean())
    expected = np.minimum(speed, friction * 9.81 * config.dt * np.arange(1, 16))
    np.testing.assert_allclose(history, expected, atol=0.01)
    assert history[-1] == pytest.approx(speed, rel=1e-6)


@BOTH
def test_a_spinning_plane_drags_cloth_around(integrator):
    rate = 2.0
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    config = SolverConfig(integrator=integrator, substeps=10, air_density=0.0)
    solver = ClothSolver(mesh, Material(friction=5.0), config, obstacles={"table": Plane()})
    state = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    for n in range(1, 26):
        half = 0.5 * rate * n * config.dt
        state = solver.step(
            state, Inputs(obstacles={"table": Pose(orientation=(0, 0, math.sin(half), math.cos(half)))})
        )
    turned = Rotation.from_rotvec([0, 0, rate * 25 * config.dt]).apply(mesh.rest_position.copy())
    np.testing.assert_allclose(state.position[:, :2], turned[:, :2], atol=0.005)
    np.testing.assert_allclose(state.velocity, np.cross([0, 0, rate], state.position * [1, 1, 0]), atol=0.05)


@BOTH
def test_a_lift_carries_cloth_at_its_own_speed(integrator):
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    solver = ClothSolver(
        mesh, Material(), SolverConfig(integrator=integrator, air_density=0.0), obstacles={"lift": Plane()}
    )
    state = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    for n in range(1, 31):
        state = solver.step(state, Inputs(obstacles={"lift": Pose((0.0, 0.0, 0.01 * n))}))
    np.testing.assert_allclose(state.position[:, 2], 0.3 + SHELL, atol=1e-9)
    np.testing.assert_allclose(state.velocity[:, 2], 0.5, atol=1e-6)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9])
def test_an_impact_gives_back_its_share_of_the_speed(restitution):
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=4, rows=4)
    config = SolverConfig(air_density=0.0)
    solver = ClothSolver(mesh, Material(restitution=restitution), config, obstacles={"floor": Plane()})
    lying = solver.initial_state(Pose((0.0, 0.0, SHELL + 0.021)))
    state = State(lying.position, np.tile([0.0, 0.0, -2.0], (16, 1)), obstacles=lying.obstacles)
    for _ in range(2):
        state = solver.step(state, Inputs(gravity=WEIGHTLESS))
    np.testing.assert_allclose(state.velocity[:, 2], 2.0 * restitution, atol=1e-9)


@BOTH
def test_friction_of_an_obstacle_overrules_that_of_the_cloth(integrator):
    """On a slope of 0.3 the slippery plank lets go, the rough one holds."""
    for friction, slides in ((0.1, True), (0.6, False)):
        mesh = ClothMesh.grid(width=0.2, height=0.2, columns=4, rows=4)
        plank = Plane(normal=(0.3, 0.0, 1.0), friction=friction)
        solver = ClothSolver(
            mesh, Material(friction=0.3), SolverConfig(integrator=integrator), obstacles={"plank": plank}
        )
        tilt = math.atan(0.3)
        lying = Pose(
            (SHELL * math.sin(tilt), 0.0, SHELL * math.cos(tilt)), (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2))
        )
        start = state = solver.initial_state(lying)
        for _ in range(25):
            state = solver.step(state, Inputs())
        assert (np.abs(state.position - start.position).max() > 0.05) == slides


def test_a_cloth_between_two_obstacles_keeps_out_of_both():
    mesh = ClothMesh.grid(width=0.5, height=0.3, columns=16, rows=10)
    balls = {
        "left": Sphere(radius=0.12, center=(-0.13, 0.0, 0.0)),
        "right": Sphere(radius=0.12, center=(0.13, 0.0, 0.0)),
    }
    solver = ClothSolver(mesh, Material(), obstacles=balls)
    state = solver.initial_state(Pose((0.0, 0.0, 0.15)))
    for _ in range(75):
        state = solver.step(state, Inputs())
        for ball in balls.values():
            assert distances(ball, state.position).min() > 0
    assert state.position[:, 2].min() < 0.1


@BOTH
def test_a_cloth_draped_over_a_ball_comes_to_rest(integrator):
    """With iterations enough: few of them leave a draped cloth trembling."""
    mesh = ClothMesh.grid(width=0.6, height=0.5, columns=12, rows=10)
    config = SolverConfig(integrator=integrator, iterations=20)
    ball = Sphere(radius=0.12, center=(0.05, 0.0, -0.2))
    solver = ClothSolver(mesh, Material(friction=0.4, damping=2.0), config, obstacles={"ball": ball})
    state = solver.initial_state(Pose((0.05, 0.0, -0.06)))
    speeds = []
    for _ in range(300):
        state = solver.step(state, Inputs())
        speeds.append(np.sqrt((state.velocity**2).sum(axis=1).mean()))
    assert max(speeds) > 0.2
    assert speeds[-1] < 0.02
    assert solver.report.contacts > 5
