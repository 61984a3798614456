"""Pinned groups that are moved: exactly there, rigidly, in time, and no farther than the cloth reaches."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Grasp, InputError, Inputs, Material, Pose, SolverConfig
from cloth_core.config import INTEGRATORS
from cloth_core.physics.restraint import MARGIN

MESH = ClothMesh.grid(width=0.5, height=0.5, columns=9, rows=9)
TOP = MESH.group("top")
MIDDLE = MESH.rest_position[TOP].mean(axis=0)
TURN = math.radians(50.0)
BOTH = pytest.mark.parametrize("integrator", INTEGRATORS)


def pinned_at(*groups: str, **config) -> ClothSolver:
    solver = ClothSolver(MESH, Material(damping=2.0), SolverConfig(**config))
    for group in groups:
        solver.pin(MESH.group(group))
    return solver


def moved(*way: float, angle: float = 0.0) -> Pose:
    """The frame of the top, ``way`` m from where it began, turned about z."""
    return Pose(tuple(MIDDLE + way), (0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)))


def states_on_the_way(solver, steps, state=None, **groups: Pose):
    state = state or solver.initial_state()
    for _ in range(steps):
        state = solver.step(state, Inputs(groups=groups))
        yield state


@BOTH
def test_a_moved_group_ends_exactly_at_its_pose_and_stays_one_body_on_the_way(integrator):
    solver, goal = pinned_at("top", integrator=integrator), moved(0.2, -0.1, 0.4, angle=TURN)
    shape = np.linalg.norm(MESH.rest_position[TOP] - MESH.rest_position[TOP[0]], axis=1)
    for state in states_on_the_way(solver, 20, top=goal):
        place = state.position[TOP]
        np.testing.assert_allclose(np.linalg.norm(place - place[0], axis=1), shape, atol=1e-14)
    np.testing.assert_allclose(place, goal.apply(MESH.rest_position[TOP] - MIDDLE), rtol=0.0, atol=1e-15)
    assert not state.velocity[TOP].any() and solver.report.slowed == ()


@BOTH
def test_it_is_followed_no_faster_than_a_hand_and_no_slower(integrator):
    solver = pinned_at("top", integrator=integrator, max_grasp_speed=2.0, max_grasp_turn=100.0)
    heights = [state.position[TOP, 2] for state in states_on_the_way(solver, 26, top=moved(0.0, 0.0, 1.0))]
    climbed = np.diff([np.zeros(len(TOP)), *heights], axis=0)
    np.testing.assert_allclose(climbed[:25], 2.0 * 0.02, rtol=1e-5)  # 1 m at 2 m/s: 25 steps
    np.testing.assert_allclose(climbed[25], 0.0, atol=1e-6)
    np.testing.assert_array_equal(heights[25], 1.0)


def test_what_is_named_no_longer_stays_and_keeps_its_frame():
    solver = pinned_at("top")
    *_, there = states_on_the_way(solver, 20, top=moved(0.0, 0.0, 0.2, angle=TURN))
    *_, later = states_on_the_way(solver, 10, state=there)
    np.testing.assert_array_equal(later.position[TOP], there.position[TOP])
    *_, back = states_on_the_way(solver, 30, state=later, top=moved(0.0, 0.0, 0.0))
    np.testing.assert_allclose(back.position[TOP], MESH.rest_position[TOP], rtol=0.0, atol=1e-15)


def test_a_moved_cloth_hangs_from_its_pins_with_all_its_weight():
    solver = pinned_at("top")
    *_, state = states_on_the_way(solver, 300, top=moved(0.3, 0.0, 0.3))
    weight = 9.81 * MESH.vertex_mass(solver.material).sum()
    assert solver.report.pin_wrench.force[2] == pytest.approx(-weight, rel=0.02)
    assert solver.report.grasp_wrenches == {}
    down = moved(0.3, 0.0, 0.3).position - state.position[MESH.group("bottom")].mean(axis=0)
    np.testing.assert_allclose(down, [0.0, 0.0, 0.5], atol=0.02)


def test_a_group_goes_no_farther_than_the_cloth_to_the_next_pin_reaches():
    solver = pinned_at("top", "bottom", max_grasp_speed=2.0)
    apart = []
    for state in states_on_the_way(solver, 100, top=moved(0.0, 5.0, 0.0)):
        apart.append(np.ptp(state.position[:, 1]))
        np.testing.assert_array_equal(state.position[MESH.group("bottom")], MESH.rest_position[MESH.group("bottom")])
    limit = 0.5 * solver.material.stretch_limit
    assert apart[-1] == pytest.approx(limit, rel=1e-6) and max(apart) <= limit + 1e-6
    assert solver.report.taut == ("group/top",) and solver.report.slips == ()


def test_a_hand_at_the_other_end_is_held_back_or_slips_but_the_group_keeps_its_cloth():
    solver = pinned_at("top")
    hand = Grasp(pose=Pose((-0.25, -0.25, 0.0)), closure=1.0, radius=0.01)
    state, away = solver.initial_state(), moved(0.0, 3.0, 0.0)
    for _ in range(60):
        state = solver.step(state, Inputs(groups={"top": away}, grasps={"hand": hand}))
        assert solver.report.max_stretch < solver.material.stretch_limit + 0.03
    held = solver.pinned
    np.testing.assert_array_equal(state.grips["group/top"].vertex, held)
    assert np.isfinite(state.position).all()


def test_no_group_without_a_pin_is_moved_and_those_that_share_a_vertex_share_it_by_name():
    solver = pinned_at("top_left")
    *_, state = states_on_the_way(solver, 3, bottom=Pose((0.0, 0.0, 5.0)))
    assert state.grips == {}
    pose = Pose(tuple(MESH.rest_position[TOP[0]] + [0.0, 0.0, 0.1]))
    *_, state = states_on_the_way(solver, 10, top=Pose((9.0, 9.0, 9.0)), left=pose)
    assert list(state.grips) == ["group/left"]
    np.testing.assert_array_equal(state.position[TOP[0]], pose.position)


def test_a_frame_lasts_as_long_as_a_vertex_of_it_is_pinned():
    solver = pinned_at("top")
    *_, up = states_on_the_way(solver, 10, top=moved(0.0, 0.0, 0.1))
    solver.unpin(TOP[4:])
    *_, half = states_on_the_way(solver, 10, state=up, top=moved(0.0, 0.0, 0.2))
    np.testing.assert_allclose(half.position[TOP[:4]], MESH.rest_position[TOP[:4]] + [0.0, 0.0, 0.2], atol=1e-15)
    solver.unpin()
    *_, free = states_on_the_way(solver, 1, state=half)
    assert free.grips == {}


@BOTH
def test_it_goes_on_bit_equal_from_a_snapshot_and_from_recorded_inputs(integrator):
    solver, goal = pinned_at("top", integrator=integrator), moved(0.0, 0.3, 0.7, angle=-TURN)
    *_, middle = states_on_the_way(solver, 3, top=goal)
    kept = {name: array.copy() for name, array in solver.snapshot(middle).items()}
    *_, end = states_on_the_way(solver, 12, state=middle, top=goal)
    other = ClothSolver(MESH, solver.material, solver.config)
    state = other.restore(kept)
    for _ in range(12):
        state = other.step(state, Inputs.from_mapping(Inputs(groups={"top": goal}).as_mapping()))
    assert state.digest == end.digest


def test_what_cannot_be_is_refused_by_name():
    solver = pinned_at("top")
    with pytest.raises(InputError, match=r"groups: no vertex group waist; this cloth has bottom, "):
        solver.step(solver.initial_state(), Inputs(groups={"waist": Pose()}))
    with pytest.raises(InputError, match=r"groups\.top: 3 is not of the type Pose"):
        Inputs(groups={"top": 3})
    with pytest.raises(InputError, match=r"'group/top' begins with 'group/'"):
        solver.step(solver.initial_state(), Inputs(grasps={"group/top": Grasp(pose=Pose())}))


def test_a_group_beyond_all_poses_is_pinned_and_moved_without_complaint():
    solver = pinned_at("top")
    start = solver.initial_state()
    far = dataclasses.replace(start, position=start.position + np.array([5e6, 0.0, 0.0]))
    *_, state = states_on_the_way(solver, 2, state=far, top=moved(0.0, 0.0, 0.0))
    assert np.isfinite(state.position).all() and state.grips["group/top"].pose.position[0] < 1e6


def test_no_vertex_of_a_turning_group_is_faster_than_a_hand():
    solver, about_y = pinned_at("top", max_grasp_speed=1.0), (0.0, 1.0, 0.0, 0.0)
    before = solver.initial_state().position[TOP]
    fastest = []
    for state in states_on_the_way(solver, 60, top=Pose(tuple(MIDDLE), about_y)):
        fastest.append(np.linalg.norm(state.position[TOP] - before, axis=1).max() / 0.02)
        before = state.position[TOP]
    assert max(fastest) == pytest.approx(1.0, rel=0.01)  # half a turn with arms of 0.25 m: 0.79 s
    assert np.count_nonzero(np.array(fastest) > 0.9) == pytest.approx(math.pi * 0.25 / 0.02, abs=2)
    np.testing.assert_allclose(before, MESH.rest_position[TOP[::-1]], atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_groups_that_are_torn_about_tear_no_thread(seed):
    random, solver = np.random.default_rng(seed), pinned_at("top", "left")
    state, poses = solver.initial_state(), {}
    for number in range(80):
        if number % 7 == 0:
            size = random.choice([0.2, 1.0, 50.0])
            group = random.choice(["top", "left", "corners"])
            poses[group] = Pose(tuple(random.uniform(-size, size, 3)), tuple(random.normal(size=4)))
        if number % 20 == 10:
            (solver.pin if number % 40 == 10 else solver.unpin)(MESH.group("bottom"))
        state = solver.step(state, Inputs(groups=poses))
        assert solver.report.max_stretch < solver.material.stretch_limit + MARGIN + 1e-3
        assert not solver.report.recovered
