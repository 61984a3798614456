"""Hands that ask for more cloth than there is: held back at its end, then without it; what they leave is whole."""

from __future__ import annotations

import io
import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig
from cloth_core.validation.geometry import irregular_sheet

MARGIN = 0.05
SHEET = ClothMesh.grid(width=0.5, height=0.5, columns=15, rows=15)


def chain(count=21, length=0.5):
    place = np.zeros((count, 3))
    place[:, 0] = np.linspace(-0.5 * length, 0.5 * length, count)
    links = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    return ClothMesh.from_springs(place, links, stiffness=500.0, mass=0.002)


CLOTHS = {"grid": SHEET, "irregular": irregular_sheet(0.5, 0.4, 12, seed=3), "chain": chain()}


def hand(place, closure=1.0, radius=0.03, turn=(0.0, 0.0, 0.0, 1.0), **settings) -> Grasp:
    return Grasp(pose=Pose(tuple(place), turn), closure=closure, radius=radius, **settings)


def far_ends(mesh):
    rest = mesh.rest_position
    first = int(np.argmax(np.linalg.norm(rest - rest.mean(axis=0), axis=1)))
    return first, int(np.argmax(np.linalg.norm(rest - rest[first], axis=1)))


def torn(solver, mesh, apart, seconds, after=0.4):
    """Two hands take far ends and go ``apart`` m asunder in so many seconds; yields states."""
    a, b = mesh.rest_position[list(far_ends(mesh))]
    outward = (a - b) / np.linalg.norm(a - b)
    dt = solver.config.dt
    state = solver.initial_state()
    for n in range(round((seconds + after) / dt) + 1):
        way = 0.5 * apart * min(1.0, n * dt / max(seconds, dt)) * outward
        state = solver.step(state, Inputs(grasps={"left": hand(a + way), "right": hand(b - way)}))
        yield state


@pytest.mark.parametrize("apart", [2.0, 10.0])
@pytest.mark.parametrize("seconds", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("name", CLOTHS)
def test_hands_that_tear_find_the_cloth_taut_and_one_of_them_loses_it(name, seconds, apart):
    mesh = CLOTHS[name]
    ends = list(far_ends(mesh))
    length = np.linalg.norm(np.diff(mesh.rest_position[ends], axis=0))
    solver, slipped, extent = ClothSolver(mesh, Material()), [], []
    for state in torn(solver, mesh, apart, seconds):
        assert solver.report.max_stretch <= 1.03 + MARGIN
        slipped += solver.report.slipped
        extent.append(np.linalg.norm(np.diff(state.position[ends], axis=0)) / length)
    assert slipped == ["left"]  # of two that ask for as much, the first by name
    assert 1.02 < max(extent) <= 1.03 + MARGIN
    assert {grip: len(state.grips[grip].vertex) > 0 for grip in state.grips} == {"left": False, "right": True}
    assert state.grips["left"].closed
    if solver.report.slowed == ():
        right = state.grips["right"]
        np.testing.assert_allclose(state.position[right.vertex], right.pose.apply(right.offset), atol=1e-9)


def test_the_hand_that_pulls_slips_out_of_a_cloth_that_another_holds_still():
    solver = ClothSolver(SHEET, Material())
    state, slipped = solver.initial_state(), []
    for n in range(60):
        grasps = {"alpha": hand((-0.25, 0.25, 0.0)), "zeta": hand((0.25 + 0.01 * n, 0.25, 0.0))}
        state = solver.step(state, Inputs(grasps=grasps))
        slipped += solver.report.slipped
        still = state.grips["alpha"]
        assert still.pose.position == (-0.25, 0.25, 0.0) and len(still.vertex) > 0
    assert slipped == ["zeta"]


def test_a_hand_slips_off_a_pinned_cloth_after_its_slip_distance_and_takes_hold_again_once_opened():
    solver = ClothSolver(SHEET, Material())
    solver.pin(SHEET.group("left"))
    corner, length = np.array([0.25, 0.25, 0.0]), 0.5
    state, lost = solver.initial_state(), None
    for n in range(100):
        place = corner + np.array([0.002 * n, 0.0, 0.0])
        state = solver.step(state, Inputs(grasps={"hand": hand(place, slip_distance=0.03)}))
        if solver.report.slipped:
            lost = place[0] + 0.25
            break
        assert ("hand" in solver.report.taut) == (state.grips["hand"].pose.position != tuple(place))
    assert 1.03 * length + 0.03 < lost <= 1.03 * length + 0.03 + 2 * 0.002
    corner = state.position[SHEET.group("top_right")[0]]
    held = []
    for closure in (1.0, 0.5, 0.3, 1.0):
        state = solver.step(state, Inputs(grasps={"hand": hand(corner, closure=closure, radius=0.05)}))
        held.append(len(state.grips["hand"].vertex) > 0)
    assert held == [False, False, False, True]


def test_a_hand_walks_round_at_the_end_of_the_cloth():
    """Beyond the reach by less than the slip distance, the grip goes round with the hand."""
    solver = ClothSolver(SHEET, Material())
    solver.pin(SHEET.group("bottom_left"))
    pivot, arm = SHEET.rest_position[SHEET.group("bottom_left")[0]], 0.5 * np.sqrt(2.0)
    state = solver.initial_state()
    for n in range(120):
        angle, radius = np.pi / 4 + 0.01 * n, arm * 1.03 + min(0.03, 0.001 * n) - 0.02
        place = pivot + radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        state = solver.step(state, Inputs(grasps={"hand": hand(place, radius=0.04)}))
        assert solver.report.slipped == ()
        grip = state.grips["hand"]
        assert np.linalg.norm(np.subtract(grip.pose.position, place)) < 0.05
    assert solver.report.taut == ("hand",)


places = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@settings(max_examples=40, deadline=None)
@given(places, places, places, st.integers(5, 30))
def test_hands_within_reach_of_each_other_never_slip(direction, turn, drift, steps):
    """Wherever they go, turning and together or towards each other, they are followed exactly."""
    a, b = np.array([-0.25, -0.25, 0.0]), np.array([0.25, -0.25, 0.0])
    solver = ClothSolver(SHEET, Material())
    state = solver.step(solver.initial_state(), Inputs(grasps={"a": hand(a), "b": hand(b)}))
    axis = np.asarray(direction) / max(np.linalg.norm(direction), 1e-3)
    for n in range(1, steps + 1):
        share = 0.5 - 0.5 * np.cos(np.pi * n / steps)
        spin = Rotation.from_rotvec(0.5 * share * np.asarray(turn))
        shift = 0.05 * steps * share * np.asarray(drift) * 0.3
        near = 1.0 - 0.2 * share * abs(axis[0])
        quaternion = tuple(spin.as_quat())
        grasps = {name: hand(near * spin.apply(place) + shift, turn=quaternion) for name, place in (("a", a), ("b", b))}
        state = solver.step(state, Inputs(grasps=grasps))
        assert solver.report.slipped == () and solver.report.taut == ()
        assert all(state.grips[name].pose == grasps[name].pose for name in grasps)


@pytest.mark.parametrize("fabric", ["default", "denim", "interlock"])
def test_a_hand_of_2_metres_a_second_is_followed_exactly(fabric):
    """It starts and turns at 20 m/s^2, with the whole cloth on one corner."""
    material = Material() if fabric == "default" else Material.preset(fabric)
    mesh = ClothMesh.grid(width=0.8, height=0.8, columns=30, rows=30)
    solver = ClothSolver(mesh, material)
    state, place = solver.initial_state(), np.array([-0.4, 0.4, 0.0])
    random = np.random.default_rng(4)
    speed = aim = np.zeros(3)
    for n in range(100):
        if n % 10 == 0:
            aim = random.normal(size=3)
            aim *= 2.0 / np.linalg.norm(aim)
        change = aim - speed
        speed = speed + change * min(1.0, 0.4 / max(np.linalg.norm(change), 1e-9))
        place = place + 0.02 * speed
        state = solver.step(state, Inputs(grasps={"hand": hand(place if n else (-0.4, 0.4, 0.0))}))
        assert n == 0 or state.grips["hand"].pose.position == tuple(place)
        assert len(state.grips["hand"].vertex) > 0 and solver.report.slipped == ()
        assert solver.report.max_stretch <= material.stretch_limit + MARGIN


@pytest.mark.parametrize("dt", [0.002, 0.02, 0.1])
def test_a_jerk_of_10_metres_does_not_tear_what_is_free(dt):
    solver = ClothSolver(SHEET, Material(areal_density=2.0), SolverConfig(dt=dt))
    state = solver.step(solver.initial_state(), Inputs(grasps={"hand": hand((0.25, 0.25, 0.0))}))
    for _ in range(round(0.6 / dt)):
        state = solver.step(state, Inputs(grasps={"hand": hand((10.0, 0.25, 0.0))}))
        assert solver.report.max_stretch <= 1.03 + MARGIN
    assert state.position[:, 0].mean() > 2.0  # it went along


HEAVY = Material(areal_density=2.0)
HEAVY_CLOTHS = {
    "grid": ClothMesh.grid(width=1.0, height=1.0, columns=14, rows=14),
    "irregular": irregular_sheet(1.0, 1.0, 11, seed=5),
    "all in hand": ClothMesh.grid(width=0.1, height=0.1, columns=4, rows=4),
}


def lifted(mesh, strongest, dt=0.02, seconds=1.2, radius=0.08):
    """A hand closes at a corner (or around it all) and rises by 0.3 m/s; solver, last state and slips."""
    solver = ClothSolver(mesh, HEAVY, SolverConfig(dt=dt, max_grasp_force=strongest))
    corner, state, slips = mesh.rest_position[0], solver.initial_state(), []
    for n in range(round(seconds / dt)):
        place = corner + np.array([0.0, 0.0, 0.3 * n * dt])
        state = solver.step(state, Inputs(grasps={"hand": hand(place, radius=radius)}))
        slips += [(n * dt, slip) for slip in solver.report.slips]
    return solver, state, slips


@pytest.mark.parametrize("dt", [0.004, 0.02, 0.1])
@pytest.mark.parametrize("name", ["grid", "irregular"])
def test_a_cloth_of_20_newton_slips_from_a_hand_that_bears_1_and_hangs_on_one_that_bears_100(name, dt):
    mesh = HEAVY_CLOTHS[name]
    _, fallen, slips = lifted(mesh, 1.0, dt)
    assert [slip.name for _, slip in slips] == ["hand"] and slips[0][0] < 0.2
    assert slips[0][1].load > 1.0 and slips[0][1].beyond == 0.0
    assert fallen.grips["hand"].closed and len(fallen.held) == 0
    assert fallen.position[:, 2].max() < -2.0
    _, carried, slips = lifted(mesh, 100.0, dt)
    grip = carried.grips["hand"]
    assert slips == [] and len(grip.vertex) > 0
    assert carried.position[:, 2].max() == pytest.approx(grip.pose.position[2], abs=0.1)


@pytest.mark.parametrize(("limit", "missing"), [(10.0, 0.001), (1.03, 0.1)])
@pytest.mark.parametrize("name", HEAVY_CLOTHS)
def test_what_a_hand_bears_is_the_weight_of_the_cloth_that_hangs_still(name, limit, missing):
    """Up to what the sweeps lift of a cloth at its stretch limit."""
    mesh = HEAVY_CLOTHS[name]
    solver = ClothSolver(mesh, replace(HEAVY, damping=4.0, stretch_limit=limit))
    radius = 0.2 if name == "all in hand" else 0.08
    corner, state = mesh.rest_position[0], solver.initial_state()
    for _ in range(300):
        state = solver.step(state, Inputs(grasps={"hand": hand(corner, radius=radius)}))
    weight = 9.81 * mesh.vertex_mass(HEAVY).sum()
    sideways, load = np.abs(state.grips["hand"].load[:2]), -state.grips["hand"].load[2]
    assert sideways.max() < 0.01 * weight
    assert (1.0 - missing) * weight < load < 1.001 * weight


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_hand_drops_what_weighs_a_little_more_than_it_bears_and_carries_what_weighs_less(factor):
    """The cloth hangs still on a hand that could carry any; then the hand is told what it can."""
    mesh = HEAVY_CLOTHS["grid"]
    weight = 9.81 * mesh.vertex_mass(HEAVY).sum()
    inputs = Inputs(grasps={"hand": hand(mesh.rest_position[0], radius=0.08)})
    solver = ClothSolver(mesh, replace(HEAVY, damping=4.0, stretch_limit=10.0))
    state = solver.initial_state()
    for _ in range(300):
        state = solver.step(state, inputs)
    weaker = solver.changed(config=SolverConfig(max_grasp_force=factor * weight))
    for _ in range(20):
        state = weaker.step(state, inputs)
    assert (len(state.held) > 0) == (factor > 1.0)


def test_two_hands_share_a_weight_that_is_too_much_for_one():
    mesh = HEAVY_CLOTHS["grid"]
    weight = 9.81 * mesh.vertex_mass(HEAVY).sum()
    corners = mesh.rest_position[mesh.group("corners")[:2]]
    fabric = replace(HEAVY, damping=4.0, stretch_limit=10.0)
    solver = ClothSolver(mesh, fabric, SolverConfig(max_grasp_force=0.9 * weight))
    state = solver.initial_state()
    for n in range(200):
        inward = np.array([min(0.001 * n, 0.1), 0.0, 0.0])
        grasps = {"left": hand(corners[0] + inward, radius=0.08), "right": hand(corners[1] - inward, radius=0.08)}
        state = solver.step(state, Inputs(grasps=grasps))
        assert solver.report.slips == ()
    loads = np.array([state.grips[name].load for name in grasps])
    np.testing.assert_allclose(loads.sum(axis=0), [0.0, 0.0, -weight], atol=0.01 * weight)
    del grasps["left"]
    dropped = [solver.report.slipped for _ in range(60) if (state := solver.step(state, Inputs(grasps=grasps)))]
    assert ("right",) in dropped


def test_what_a_hand_slipped_away_from_says_how_far_it_was_ahead():
    solver = ClothSolver(SHEET, Material())
    solver.pin(SHEET.group("left"))
    state, slips = solver.initial_state(), []
    for n in range(100):
        state = solver.step(state, Inputs(grasps={"hand": hand((0.25 + 0.002 * n, 0.25, 0.0), slip_distance=0.03)}))
        slips += solver.report.slips
    assert [slip.name for slip in slips] == ["hand"]
    assert 0.03 < slips[0].beyond < 0.03 + 2 * 0.002 and slips[0].load == 0.0


def test_the_rest_of_a_slip_is_bit_equal_after_a_restore():
    solver, states = ClothSolver(SHEET, Material()), []
    inputs = []
    state = solver.initial_state()
    for n in range(14):
        way = 0.012 * n
        inputs.append(
            Inputs(grasps={"a": hand((-0.25 - way, 0.25, 0.0)), "b": hand((0.25 + way, 0.25, 0.0), slip_distance=0.1)})
        )
        state = solver.step(state, inputs[-1])
        states.append((state, solver.report, solver.snapshot(state)))
    slip = next(n for n, (_, report, _) in enumerate(states) if report.slipped)
    taut = next(n for n, (_, report, _) in enumerate(states) if report.taut)
    assert taut < slip < 12
    for begin in (taut, slip - 1, slip):
        stream = io.BytesIO()
        np.savez(stream, **states[begin][2])
        stream.seek(0)
        fresh = ClothSolver(SHEET, Material())
        state = fresh.restore(np.load(stream))
        for n in range(begin + 1, 14):
            state = fresh.step(state, inputs[n])
            assert state.digest == states[n][0].digest
            assert (fresh.report.slipped, fresh.report.taut) == (states[n][1].slipped, states[n][1].taut)
            assert state.grips["b"].pose == states[n][0].grips["b"].pose


def test_hands_of_separate_cloths_do_not_mind_each_other():
    one, other = chain(), chain()
    place = np.concatenate([one.rest_position, other.rest_position + np.array([0.0, 1.0, 0.0])])
    links = np.concatenate([one.spring_vertex, other.spring_vertex + one.vertex_count])
    mesh = ClothMesh.from_springs(place, links, stiffness=500.0, mass=0.002)
    solver = ClothSolver(mesh, Material())
    state = solver.initial_state()
    for n in itertools.count():
        way = min(0.03 * n, 3.0)
        grasps = {"low": hand((0.25, -way, 0.0)), "high": hand((0.25, 1.0 + way, 0.0))}
        state = solver.step(state, Inputs(grasps=grasps))
        assert solver.report.taut == () and solver.report.slipped == ()
        if way == 3.0:
            break
    assert all(len(grip.vertex) for grip in state.grips.values())
