"""Grasps: capture, hysteresis, a rigid hold, and a release at the hand's velocity."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig
from cloth_core.config import INTEGRATORS
from cloth_core.physics.grasping import update_grips

MESH = ClothMesh.grid(width=0.5, height=0.5, columns=11, rows=11)
CORNER = (-0.25, -0.25, 0.0)
BOTH = pytest.mark.parametrize("integrator", INTEGRATORS)
NOBODY = np.zeros(0, np.int32)


def closing(position=CORNER, closure=1.0, radius=0.06, orientation=(0.0, 0.0, 0.0, 1.0)) -> Grasp:
    return Grasp(pose=Pose(position, orientation), closure=closure, radius=radius)


def grips_after(grips, pinned=NOBODY, **grasps: Grasp):
    return update_grips(grips, grasps, MESH.rest_position, np.asarray(pinned))


@pytest.mark.parametrize("radius", [0.01, 0.06, 0.2])
def test_closing_captures_what_lies_within_the_radius(radius):
    grip = grips_after({}, hand=closing(radius=radius))["hand"]
    away = np.linalg.norm(MESH.rest_position - CORNER, axis=1)
    np.testing.assert_array_equal(grip.vertex, np.flatnonzero(away <= radius))
    np.testing.assert_allclose(grip.pose.apply(grip.offset), MESH.rest_position[grip.vertex], atol=1e-15)


def test_closure_has_hysteresis():
    grips, held = {}, []
    for closure in (0.0, 0.5, 0.59, 0.6, 0.5, 0.41, 0.4, 0.39, 0.5, 0.59, 1.0):
        grips = grips_after(grips, hand=closing(closure=closure))
        held.append(len(grips["hand"].vertex) > 0)
    assert held == [False, False, False, True, True, True, True, False, False, False, True]


def test_a_hand_that_closes_on_nothing_stays_empty_until_it_opens():
    grips = grips_after({}, hand=closing(position=(5.0, 0.0, 0.0)))
    assert grips["hand"].closed and len(grips["hand"].vertex) == 0
    assert len(grips_after(grips, hand=closing())["hand"].vertex) == 0
    opened = grips_after(grips, hand=closing(closure=0.0))
    assert len(grips_after(opened, hand=closing())["hand"].vertex) > 0


def test_pinned_vertices_and_those_of_another_hand_are_not_captured():
    first = grips_after({}, hand=closing())
    both = grips_after(first, pinned=[0], hand=closing(), rival=closing(radius=0.2))
    assert set(both["rival"].vertex).isdisjoint(both["hand"].vertex)
    assert 0 not in both["rival"].vertex
    together = grips_after({}, zeta=closing(), alpha=closing())
    assert len(together["alpha"].vertex) > 0 and len(together["zeta"].vertex) == 0


def test_a_grasp_that_disappears_lets_go():
    grips = grips_after({}, hand=closing())
    assert grips_after(grips) == {}


@BOTH
def test_held_vertices_ride_rigidly_in_the_turning_hand(integrator):
    solver = ClothSolver(MESH, Material(), SolverConfig(integrator=integrator))
    state = solver.step(solver.initial_state(), Inputs(grasps={"hand": closing()}))
    grip = state.grips["hand"]
    assert len(grip.vertex) == 3
    for n in range(1, 26):
        turn = Rotation.from_rotvec([0.02 * n, 0.03 * n, -0.01 * n])
        pose = Pose((-0.25 + 0.01 * n, -0.25, 0.005 * n), tuple(turn.as_quat()))
        state = solver.step(state, Inputs(grasps={"hand": Grasp(pose=pose, closure=1.0, radius=0.06)}))
        np.testing.assert_allclose(state.position[grip.vertex], pose.apply(grip.offset), atol=1e-12)
    assert solver.report.held == 3 and solver.report.slowed == ()


@BOTH
def test_release_leaves_the_velocity_of_the_hand(integrator):
    solver = ClothSolver(MESH, Material(), SolverConfig(integrator=integrator, air_density=0.0))
    weightless, whole = (0.0, 0.0, 0.0), Grasp(pose=Pose(), closure=1.0, radius=1.0)
    state = solver.step(solver.initial_state(), Inputs(grasps={"hand": whole}, gravity=weightless))
    assert len(state.held) == MESH.vertex_count
    for n in range(1, 11):
        hand = Grasp(pose=Pose((0.02 * n, 0.0, 0.01 * n)), closure=1.0, radius=1.0)
        state = solver.step(state, Inputs(grasps={"hand": hand}, gravity=weightless))
    for _ in range(10):
        before = state.position
        state = solver.step(state, Inputs(grasps={"hand": closing(closure=0.0)}, gravity=weightless))
        assert len(state.held) == 0
        np.testing.assert_allclose(state.velocity, np.tile([1.0, 0.0, 0.5], (121, 1)), atol=1e-8)
        np.testing.assert_allclose(state.position - before, np.tile([0.02, 0.0, 0.01], (121, 1)), atol=1e-9)


@BOTH
def test_release_from_a_turning_hand_leaves_its_spin(integrator):
    solver = ClothSolver(MESH, Material(), SolverConfig(integrator=integrator, substeps=10, air_density=0.0))
    weightless, rate = (0.0, 0.0, 0.0), 3.0
    state = solver.initial_state()
    for n in range(11):
        half = 0.5 * rate * 0.02 * n
        hand = closing((0.0, 0.0, 0.0), radius=1.0, orientation=(0.0, 0.0, math.sin(half), math.cos(half)))
        state = solver.step(state, Inputs(grasps={"hand": hand}, gravity=weightless))
    np.testing.assert_allclose(state.velocity, np.cross([0.0, 0.0, rate], state.position), atol=0.01)


def test_two_hands_stretch_a_cloth_between_them():
    solver = ClothSolver(MESH, Material(), SolverConfig())
    left, right = (-0.25, 0.25, 0.0), (0.25, 0.25, 0.0)
    state = solver.initial_state()
    for n in range(60):
        apart = min(0.001 * n, 0.005)
        hands = {"left": closing((left[0] - apart, 0.25, 0.0)), "right": closing((right[0] + apart, 0.25, 0.0))}
        state = solver.step(state, Inputs(grasps=hands))
    assert {name: len(grip.vertex) for name, grip in state.grips.items()} == {"left": 3, "right": 3}
    top = MESH.group("top")
    assert np.linalg.norm(state.position[top[-1]] - state.position[top[0]]) == pytest.approx(0.51, abs=1e-9)
    assert solver.report.max_stretch < 1.1


def test_a_hand_that_jumps_is_followed_at_the_speed_limit():
    config = SolverConfig(max_grasp_speed=2.0, max_grasp_turn=5.0)
    solver = ClothSolver(MESH, Material(), config)
    state = solver.step(solver.initial_state(), Inputs(grasps={"hand": closing()}))
    held = state.grips["hand"].vertex
    far = Inputs(grasps={"hand": closing((10.0, 0.0, 0.0))})
    for _ in range(5):
        before, state = state, solver.step(state, far)
        way = np.linalg.norm(np.subtract(state.grips["hand"].pose.position, before.grips["hand"].pose.position))
        assert way == pytest.approx(2.0 * config.dt)
        assert np.linalg.norm(state.position[held] - before.position[held], axis=1).max() <= 2.0 * config.dt * (
            1 + 1e-9
        )
        assert solver.report.slowed == ("hand",)
    turned = Inputs(grasps={"hand": closing(state.grips["hand"].pose.position, orientation=(0.0, 0.0, 1.0, 0.0))})
    before, state = state, solver.step(state, turned)
    turn = before.grips["hand"].pose.rotation_vector_to(state.grips["hand"].pose)
    assert np.linalg.norm(turn) == pytest.approx(5.0 * config.dt)


def test_an_empty_hand_is_followed_at_any_speed():
    solver = ClothSolver(MESH, Material())
    state = solver.step(solver.initial_state(), Inputs(grasps={"hand": closing((9.0, 0.0, 0.0), closure=0.0)}))
    state = solver.step(state, Inputs(grasps={"hand": closing(closure=1.0)}))
    assert len(state.grips["hand"].vertex) == 3
    assert solver.report.slowed == ()
