"""Cloth on distance fields: as on the shapes that they are made of, within what a field knows."""

from __future__ import annotations

import math

import bodies
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig, State
from cloth_core.fields import Closed, Compound, VoxelField
from cloth_core.obstacles import Box, Obstacle, Sphere

SHELL = SolverConfig().contact_shell
VOXEL = 0.01
BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
QUERIES = pytest.mark.parametrize("query", ["trilinear", "tangent_plane"])
ASKEW = tuple(Rotation.from_rotvec([0.3, -0.2, 0.5]).as_quat())


def undone(pose: Pose) -> Pose:
    turn = Rotation.from_quat(pose.orientation).inv()
    return Pose(tuple(-turn.apply(pose.position)), tuple(turn.as_quat()))


def middles(mesh: ClothMesh, x: np.ndarray) -> np.ndarray:
    """Of all edges, and of all triangles."""
    corner = x[mesh.triangles]
    return np.concatenate([0.5 * (corner + np.roll(corner, 1, axis=1)).reshape(-1, 3), corner.mean(axis=1)])


def settled(obstacle: Obstacle, height: float, steps: int = 90) -> tuple[ClothSolver, State]:
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=21, rows=21)
    solver = ClothSolver(mesh, Material(damping=2.0, friction=0.4), obstacles={"it": obstacle})
    state = solver.initial_state(Pose((0.007, 0.004, height)))
    for _ in range(steps):
        state = solver.step(state, Inputs())
    return solver, state


TORUS = bodies.torus(0.15, 0.05)
BLOCK = bodies.box(0.12, 0.09, 0.06)


@BOTH
@QUERIES
@pytest.mark.parametrize("shape", ["torus", "block"])
def test_a_dropped_cloth_never_gets_inside(integrator, query, shape):
    """Vertices against the formula; the paper's planes may be half a voxel off where a surface bends."""
    surface: Closed = TORUS if shape == "torus" else BLOCK
    field = VoxelField(surface=surface, voxel=VOXEL, query=query, center=(0.02, 0.0, 0.0), orientation=ASKEW)
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=15, rows=15)
    config = SolverConfig(integrator=integrator)
    solver = ClothSolver(mesh, Material(friction=0.5), config, obstacles={"it": field})
    state = solver.initial_state(Pose((0.013, 0.021, 0.2), (0.05, 0.02, 0.0, 1.0)))
    touched = 0
    for _ in range(50):
        state = solver.step(state, Inputs())
        touched = max(touched, solver.report.contacts)
        local = field.pose.inverse_apply(state.position)
        gap = (
            bodies.torus_distance(local, 0.15, 0.05)
            if shape == "torus"
            else bodies.box_distance(local, np.array([0.12, 0.09, 0.06]))
        )
        assert gap.min() > (0.0 if query == "trilinear" else SHELL - 0.9 * VOXEL)
    assert touched > 0


def test_a_cloth_drapes_over_a_field_as_over_the_ball_itself():
    """Their caps lie as far off the ball, to a tenth of a voxel, and no less than the shell; the hems hang as low."""
    ball = Sphere(radius=0.15)
    heights, gaps = [], []
    for obstacle in (ball, Compound(parts={"ball": ball}, voxel=VOXEL)):
        solver, state = settled(obstacle, 0.16)
        gap = np.linalg.norm(state.position, axis=1) - 0.15
        cap = np.linalg.norm(state.position[:, :2], axis=1) < 0.08
        assert solver.report.contacts > 50
        assert np.count_nonzero(cap) > 30
        assert gap.min() > SHELL - 0.05 * VOXEL
        gaps.append(np.median(gap[cap]))
        assert np.linalg.norm(middles(solver.mesh, state.position), axis=1).min() > 0.15 + 0.5 * SHELL
        heights.append(np.sort(state.position[:, 2]))
    assert gaps[0] == pytest.approx(gaps[1], abs=0.1 * VOXEL)
    assert heights[0].mean() == pytest.approx(heights[1].mean(), abs=0.01)


@pytest.mark.parametrize("part", [Pose(), Pose((0.003, 0.001, 0.002), ASKEW)], ids=["along", "askew"])
def test_nothing_between_vertices_gets_into_the_edges_of_a_table(part):
    """However the table lies in its voxels: neither vertices nor middles of edges and triangles."""
    table = Box(extents=(0.3, 0.24, 0.2), center=part.position, orientation=part.orientation)
    turned = undone(part)
    field = Compound(parts={"table": table}, voxel=VOXEL, center=turned.position, orientation=turned.orientation)
    solver, state = settled(field, 0.12)
    half = 0.5 * np.array(table.extents)
    assert bodies.box_distance(state.position, half).min() > 0.8 * SHELL
    assert bodies.box_distance(middles(solver.mesh, state.position), half).min() > 0.0
    assert bodies.box_distance(state.position, half).min() < 1.1 * SHELL  # it lies there
    assert state.position[:, 2].min() < 0.0  # and hangs over the edge


@pytest.mark.parametrize("part", [Pose(), Pose((0.003, 0.001, 0.002), ASKEW)], ids=["along", "askew"])
def test_on_an_incline_friction_holds_what_it_would_on_the_box_itself(part):
    """3 % on either side of tan(angle) = mu."""
    friction = 0.5
    for slope, slides in ((0.97 * friction, False), (1.03 * friction, True)):
        angle = math.atan(slope)
        tilt = Pose(orientation=(0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2)))
        plank = Box(extents=(0.6, 0.4, 0.1), center=part.position, orientation=part.orientation)
        pose = tilt.compose(Pose((0.0, 0.0, -0.05))).compose(undone(part))
        field = Compound(
            parts={"plank": plank}, voxel=VOXEL, center=pose.position, orientation=pose.orientation, friction=friction
        )
        mesh = ClothMesh.grid(width=0.2, height=0.2, columns=6, rows=6)
        solver = ClothSolver(mesh, Material(), SolverConfig(air_density=0.0), obstacles={"plank": field})
        start = state = solver.initial_state(tilt.compose(Pose((0.0, 0.0, SHELL))))
        for _ in range(40):
            state = solver.step(state, Inputs())
        downhill = tilt.rotation @ [1.0, 0.0, 0.0]
        way = ((state.position - start.position) @ downhill).mean()
        expected = 0.5 * 0.8**2 * 9.81 * (math.sin(angle) - friction * math.cos(angle))
        assert (way > 0.5 * expected and way < 2.0 * expected) if slides else abs(way) < 0.1 * 0.04


@BOTH
def test_a_spinning_field_drags_cloth_around(integrator):
    rate = 2.0
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    config = SolverConfig(integrator=integrator, substeps=10, air_density=0.0)
    table = Compound(parts={"top": Box(extents=(0.4, 0.4, 0.1))}, voxel=VOXEL, center=(0.0, 0.0, -0.05))
    solver = ClothSolver(mesh, Material(friction=5.0), config, obstacles={"table": table})
    state = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    for n in range(1, 26):
        half = 0.5 * rate * n * config.dt
        turn = (0.0, 0.0, math.sin(half), math.cos(half))
        state = solver.step(state, Inputs(obstacles={"table": Pose((0.0, 0.0, -0.05), turn)}))
    turned = Rotation.from_rotvec([0, 0, rate * 25 * config.dt]).apply(mesh.rest_position.copy())
    np.testing.assert_allclose(state.position[:, :2], turned[:, :2], atol=0.005)
    np.testing.assert_allclose(state.velocity, np.cross([0, 0, rate], state.position * [1, 1, 0]), atol=0.05)


def test_a_moving_field_drags_cloth_along_as_fast_as_friction_allows():
    speed, friction = 0.5, 0.4
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    config = SolverConfig(air_density=0.0)
    belt = Compound(parts={"belt": Box(extents=(0.6, 0.4, 0.1))}, voxel=VOXEL, center=(0.0, 0.0, -0.05))
    solver = ClothSolver(mesh, Material(friction=friction), config, obstacles={"belt": belt})
    state = solver.initial_state(Pose((0.0, 0.0, SHELL)))
    history = []
    for n in range(1, 16):
        state = solver.step(state, Inputs(obstacles={"belt": Pose((speed * n * config.dt, 0.0, -0.05))}))
        history.append(state.velocity[:, 0].mean())
    expected = np.minimum(speed, friction * 9.81 * config.dt * np.arange(1, 16))
    np.testing.assert_allclose(history, expected, atol=0.015)


def test_fields_and_shapes_share_a_scene():
    """A cloth over a field, a ball and a second field: it keeps out of each, named in any order."""
    mesh = ClothMesh.grid(width=0.7, height=0.3, columns=29, rows=13)
    ball = {"ball": Sphere(radius=0.1, center=(0.0, 0.0, -0.1))}
    one = {"a": VoxelField(surface=bodies.ball(0.1, 4), voxel=VOXEL, center=(-0.25, 0.0, -0.1))}
    other = {"z": VoxelField(surface=bodies.ball(0.1, 4), voxel=VOXEL, center=(0.25, 0.0, -0.1))}
    ends = []
    for obstacles in ({**one, **ball, **other}, {**ball, **one, **other}):
        solver = ClothSolver(mesh, Material(), obstacles=obstacles)
        state = solver.initial_state(Pose((0.003, 0.002, 0.02)))
        for _ in range(40):
            state = solver.step(state, Inputs())
            for shape in obstacles.values():
                assert np.linalg.norm(state.position - shape.center, axis=1).min() > 0.1
        assert solver.report.contacts > 30
        ends.append(state.position)
    np.testing.assert_array_equal(*ends)


def test_a_field_that_jumps_into_a_cloth_shoots_it_away_no_more_than_a_ball_does():
    """It appears in the middle of the cloth, which comes out of it, and stays in one piece."""
    mesh = ClothMesh.grid(width=0.4, height=0.4, columns=12, rows=12)
    far, there = (0.0, 0.0, -3.0), Pose((0.01, 0.02, -0.03))
    field = VoxelField(surface=bodies.ball(0.1, 4), voxel=VOXEL, center=far)
    fastest = []
    for shape in (Sphere(radius=0.1, center=far), field):
        solver = ClothSolver(mesh, Material(), SolverConfig(air_density=0.0), obstacles={"it": shape})
        state, speeds = solver.initial_state(), []
        for _ in range(30):
            state = solver.step(state, Inputs(gravity=(0.0, 0.0, 0.0), obstacles={"it": there}))
            speeds.append(np.linalg.norm(state.velocity, axis=1).max())
        assert np.linalg.norm(state.position - there.position, axis=1).min() > 0.1
        fastest.append(max(speeds))
    assert 0.5 < fastest[1] < 1.3 * fastest[0]
