"""What hands, pins and obstacles feel: the weight they carry, as statics share it, and what a motion asks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import twins
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import brentq

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig, Wind
from cloth_core.kernels import leverage
from cloth_core.kernels import reaction as kernels
from cloth_core.obstacles import Box, Capsule, Plane, Sphere
from cloth_core.report import Wrench
from cloth_core.validation.geometry import irregular_sheet
from cloth_core.validation.scenes import UNLIMITED, hanging_strip

GRAVITY = 9.81
BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
CLOTHS = {
    "coarse": ClothMesh.grid(width=0.5, height=0.5, columns=6, rows=6),
    "fine": ClothMesh.grid(width=1.0, height=0.8, columns=30, rows=24),
    "irregular": irregular_sheet(0.8, 0.5, 14, seed=3),
}
FABRICS = {
    "default": Material(),
    "denim": Material.preset("denim"),
    "heavy": Material(areal_density=2.0),
    "unlimited": Material(stretch_limit=UNLIMITED),
}


def hand(place, radius=0.06, closure=1.0) -> Grasp:
    return Grasp(pose=Pose(tuple(place)), closure=closure, radius=radius)


def weight_of(solver) -> float:
    return GRAVITY * solver.mesh.vertex_mass(solver.material).sum()


def center_of(solver, state) -> np.ndarray:
    mass = solver.mesh.vertex_mass(solver.material)
    return mass @ state.position / mass.sum()


def played(solver, state, grasps, seconds, mean=0.4):
    """The last state, and means over the last ``mean`` s: of force and torque of every hand, and of all pins."""
    felt, dt = [], solver.config.dt
    for _ in range(round(seconds / dt)):
        state = solver.step(state, Inputs(grasps=grasps))
        wrenches = [solver.report.grasp_wrenches[name] for name in grasps]
        felt.append([(w.force, w.torque) for w in (*wrenches, solver.report.pin_wrench)])
    return state, np.mean(felt[-round(mean / dt) :], axis=0)


@pytest.mark.parametrize("fabric", FABRICS)
@pytest.mark.parametrize("name", CLOTHS)
def test_a_hand_feels_the_weight_that_hangs_on_it_and_where_it_hangs(name, fabric):
    mesh, material = CLOTHS[name], replace(FABRICS[fabric], damping=4.0)
    solver = ClothSolver(mesh, material)
    corner = mesh.rest_position[0]
    state, felt = played(solver, solver.initial_state(), {"hand": hand(corner)}, 6.0)
    weight = weight_of(solver)
    force, torque = felt[0]
    np.testing.assert_allclose(force, [0.0, 0.0, -weight], atol=0.01 * weight)
    lever = np.cross(center_of(solver, state) - corner, [0.0, 0.0, -weight])
    np.testing.assert_allclose(torque, lever, atol=0.01 * weight * 0.5)
    assert solver.report.pin_wrench == Wrench()


def test_of_meyer2000_a_hand_feels_the_weight_while_it_creeps():
    """Its cloth creeps to rest for a long time: less than two hundredths of g remain."""
    mesh = CLOTHS["fine"]
    solver = ClothSolver(mesh, Material(damping=4.0), SolverConfig(integrator="meyer2000"))
    _, felt = played(solver, solver.initial_state(), {"hand": hand(mesh.rest_position[0])}, 20.0)
    np.testing.assert_allclose(felt[0, 0], [0.0, 0.0, -weight_of(solver)], atol=0.01 * weight_of(solver))


@BOTH
@pytest.mark.parametrize("lower", [0.0, 0.25])
def test_two_hands_share_the_weight_by_the_law_of_the_lever(integrator, lower):
    """Moments of the forces and torques of both hands about any point are those of the weight at its centre."""
    mesh = CLOTHS["fine"]
    material = Material(damping=4.0, areal_density=0.5)
    solver = ClothSolver(mesh, material, SolverConfig(integrator=integrator))
    corners = mesh.rest_position[mesh.group("corners")[:2]]
    state = solver.initial_state()
    for n in range(100):
        share = min(1.0, n / 50)
        ways = np.array([[0.2, 0.0, 0.0], [-0.1, 0.0, -lower]]) * share
        grasps = {name: hand(corner + way) for name, corner, way in zip("lr", corners, ways, strict=True)}
        state = solver.step(state, Inputs(grasps=grasps))
    state, felt = played(solver, state, grasps, 8.0)
    weight = weight_of(solver)
    left, right = felt[0, 0], felt[1, 0]
    np.testing.assert_allclose(left + right, [0.0, 0.0, -weight], atol=0.01 * weight)
    poses = [np.array(grasps[name].pose.position) for name in "lr"]
    about = poses[0]
    moments = felt[0, 1] + felt[1, 1] + np.cross(poses[1] - about, right)
    lever = np.cross(center_of(solver, state) - about, [0.0, 0.0, -weight])
    np.testing.assert_allclose(moments, lever, atol=0.01 * weight)
    assert 0.1 * weight < -right[2] < 0.9 * weight
    if lower == 0.0 and integrator == "implicit_midpoint":
        gap = float(np.linalg.norm(poses[1] - about))
        np.testing.assert_allclose(-right[2] / weight, (center_of(solver, state) - about)[0] / gap, atol=0.03)


def test_a_strip_in_two_hands_pulls_inwards_as_a_catenary_does():
    """H = w a: weight per length times the catenary's parameter, which follows from its length and the span.

    One iteration leaves a strip as narrow as this 2 % off its shape, and the pull 4 %.
    """
    length = 1.2
    mesh = ClothMesh.grid(width=length, height=0.06, columns=61, rows=4)
    fabric = Material(bend=0.0, damping=4.0, stretch_limit=UNLIMITED)
    solver = ClothSolver(mesh, fabric, SolverConfig(iterations=20))
    state, ends = solver.initial_state(), np.array([[-0.5 * length, 0.0, 0.0], [0.5 * length, 0.0, 0.0]])
    for n in range(101):
        inwards = np.array([[0.001, 0.0, 0.0], [-0.001, 0.0, 0.0]]) * min(n, 100)
        places = ends + inwards
        grasps = {name: hand(place, 0.035) for name, place in zip("ab", places, strict=True)}
        state = solver.step(state, Inputs(grasps=grasps))
    state, felt = played(solver, state, grasps, 6.0)
    ends = np.abs(state.position[state.held, 0]).min(), np.abs(mesh.rest_position[state.held, 0]).min()
    a = brentq(lambda a: a * math.sinh(ends[0] / a) - ends[1], 0.05, 10.0)
    per_length = weight_of(solver) / length
    np.testing.assert_allclose([felt[0, 0, 0], -felt[1, 0, 0]], per_length * a, rtol=0.01)
    np.testing.assert_allclose(felt[:2, 0, 2], -0.5 * weight_of(solver), rtol=1e-3)


@BOTH
def test_pins_and_a_hand_carry_the_weight_together(integrator):
    mesh = CLOTHS["coarse"]
    solver = ClothSolver(mesh, Material(damping=4.0), SolverConfig(integrator=integrator))
    solver.pin(mesh.group("left"))
    _, felt = played(solver, solver.initial_state(), {"hand": hand((0.25, 0.25, 0.0))}, 12.0)
    weight = weight_of(solver)
    np.testing.assert_allclose(felt[0, 0] + felt[1, 0], [0.0, 0.0, -weight], atol=0.01 * weight)
    assert 0.2 * weight < -felt[0, 0, 2] < 0.8 * weight
    state = solver.step(solver.initial_state(), Inputs(grasps={"away": hand((0.0, 0.0, 5.0))}))
    assert solver.report.grasp_wrenches == {"away": Wrench()} and len(state.held) == 0


def test_a_stone_that_swings_pulls_with_its_weight_and_its_centripetal_force():
    """N(angle) = m g (3 cos(angle) - 2 cos(amplitude)), along the thread, in every step of a swing."""
    length, amplitude, mass = 0.5, 0.9, 0.3
    place = np.array([[0.0, 0.0, 0.0], [length * math.sin(amplitude), 0.0, -length * math.cos(amplitude)]])
    thread = ClothMesh.from_springs(place, [[0, 1]], stiffness=2e4, mass=mass, limited=False)
    solver = ClothSolver(thread, Material(damping=0.0), SolverConfig(air_density=0.0, dt=0.01))
    state, seen, held_weight = solver.initial_state(), [], np.array([0.0, 0.0, -GRAVITY * mass])
    for n in range(150):
        before = state
        state = solver.step(state, Inputs(grasps={"hand": hand((0.0, 0.0, 0.0))}))
        way = 0.5 * (before.position + state.position)[1]
        angle = math.atan2(way[0], -way[2])
        force = solver.report.grasp_wrenches["hand"].force - held_weight
        if n > 2:  # it starts with a jerk: the thread is not stretched yet
            seen.append([force @ [math.sin(angle), 0.0, -math.cos(angle)], angle])
            assert abs(force @ [math.cos(angle), 0.0, math.sin(angle)]) < 0.02 * mass * GRAVITY
    pull, angle = np.array(seen).T
    expected = mass * GRAVITY * (3 * np.cos(angle) - 2 * math.cos(amplitude))
    smooth = np.convolve(pull - expected, np.ones(5) / 5, "valid")
    assert np.abs(smooth).max() < 0.02 * mass * GRAVITY
    assert pull.max() > 1.7 * mass * GRAVITY and pull.min() < 0.7 * mass * GRAVITY


@BOTH
@pytest.mark.parametrize("material", [Material(areal_density=0.4, damping=0.0), replace(FABRICS["denim"], damping=0.0)])
def test_impulses_of_a_swung_cloth_that_hits_a_ball_and_a_pin_make_up_its_momentum(integrator, material):
    mesh = CLOTHS["fine"]
    config = SolverConfig(integrator=integrator, air_density=0.0)
    solver = ClothSolver(mesh, material, config, obstacles={"ball": Sphere(radius=0.2, center=(0.0, 0.3, -0.35))})
    solver.pin(mesh.group("top_left"))
    corner, mass = mesh.rest_position[mesh.group("top_right")[0]], mesh.vertex_mass(material)
    state, total, pressed = solver.initial_state(), np.zeros(3), 0.0
    for n in range(120):
        sway = np.array([-0.2, 0.25 * math.sin(0.12 * n), 0.1 * math.sin(0.2 * n)]) * min(1.0, n / 20)
        state = solver.step(state, Inputs(grasps={"hand": hand(corner + sway)}))
        report = solver.report
        wrenches = report.grasp_wrenches["hand"], report.pin_wrench, report.obstacle_wrenches["ball"]
        total += config.dt * np.sum([wrench.force for wrench in wrenches], axis=0)
        pressed = max(pressed, np.linalg.norm(wrenches[2].force))
    momentum = mass @ (state.velocity + state.history.get("lag", 0.0))
    weight = np.array([0.0, 0.0, -weight_of(solver)]) * 120 * config.dt
    np.testing.assert_allclose(total, weight - momentum, atol=1e-3 * np.linalg.norm(weight))
    assert pressed > 0.05 * weight_of(solver)


def test_a_hand_feels_the_wind():
    """A strip that hangs in a level wind at tan(angle) = C v^2 / (sigma g) pulls along itself with W cos(angle).

    The wind pushes across the strip alone, so it carries the rest.
    """
    mesh, top = hanging_strip(0.5, 11)
    soft = Material(bend=0.0, damping=4.0, stretch_warp=100.0, stretch_weft=100.0, shear=20.0, stretch_limit=UNLIMITED)
    solver = ClothSolver(mesh, soft, SolverConfig(iterations=10))
    state, speed = solver.initial_state(), 2.0
    for _ in range(600):
        grasps = {"hand": hand((0.0, 0.0, 0.0), 0.03)}
        state = solver.step(state, Inputs(grasps=grasps, wind=Wind(velocity=(speed, 0.0, 0.0))))
    assert len(state.held) == len(top)
    x, _, z = solver.report.grasp_wrenches["hand"].force
    angle = math.atan(0.5 * 1.2 * soft.drag * speed**2 / (soft.areal_density * GRAVITY))
    assert math.atan2(x, -z) == pytest.approx(angle, rel=0.02)
    assert math.hypot(x, z) == pytest.approx(weight_of(solver) * math.cos(angle), rel=0.02)


CARRIERS = {
    "ball": Sphere(radius=0.3),
    "table": Box(extents=(0.5, 0.5, 0.1)),
    "rail": Capsule(radius=0.05, length=2.0, orientation=(0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))),
    "ground": Plane(),
}


@pytest.mark.parametrize("fabric", ["denim", "heavy"])
@pytest.mark.parametrize("name", CARRIERS)
def test_what_lies_presses_with_its_weight_where_it_lies(name, fabric):
    carrier = CARRIERS[name]
    mesh, material = ClothMesh.grid(width=0.7, height=0.7, columns=16, rows=16), FABRICS[fabric]
    height = {"ball": 0.3, "table": 0.05, "rail": 0.05, "ground": 0.0}[name] + 0.005
    solver = ClothSolver(
        mesh, replace(material, damping=2.0, friction=0.8), obstacles={"far": Plane(center=(0, 0, -5)), name: carrier}
    )
    state, felt = solver.initial_state(Pose((0.02, 0.0, height))), []
    for _ in range(220):
        state = solver.step(state, Inputs())
        felt.append([solver.report.obstacle_wrenches[name].force, solver.report.obstacle_wrenches[name].torque])
    force, torque = np.mean(felt[-70:], axis=0)
    weight = weight_of(solver)
    np.testing.assert_allclose(force, [0.0, 0.0, -weight], atol=0.02 * weight)
    lever = np.cross(center_of(solver, state), [0.0, 0.0, -weight])
    np.testing.assert_allclose(torque, lever, atol=0.02 * weight * 0.35)
    assert solver.report.obstacle_wrenches["far"] == Wrench()


def test_hand_and_table_carry_the_weight_together():
    mesh = ClothMesh.grid(width=0.7, height=0.7, columns=16, rows=16)
    solver = ClothSolver(mesh, Material(damping=2.0), obstacles={"table": Box(extents=(0.5, 0.5, 0.1))})
    corner = mesh.rest_position[0] + [0.0, 0.0, 0.055]
    state, felt = solver.initial_state(Pose((0.0, 0.0, 0.055))), []
    for n in range(400):
        lifted = corner + np.array([0.1, 0.1, 0.15]) * min(1.0, n / 100)
        state = solver.step(state, Inputs(grasps={"hand": hand(lifted)}))
        report = solver.report
        felt.append([report.grasp_wrenches["hand"].force, report.obstacle_wrenches["table"].force])
    hand_force, table_force = np.mean(felt[-100:], axis=0)
    weight = weight_of(solver)
    np.testing.assert_allclose(hand_force + table_force, [0.0, 0.0, -weight], atol=0.01 * weight)
    assert 0.02 * weight < -hand_force[2] < 0.9 * weight


def test_hands_of_two_pieces_of_cloth_feel_their_own():
    one = ClothMesh.grid(width=0.3, height=0.3, columns=6, rows=6)
    both = ClothMesh.from_triangles(
        np.concatenate([one.rest_position, one.rest_position + np.array([1.0, 0.0, 0.0])]),
        np.concatenate([one.triangles, one.triangles + one.vertex_count]),
    )
    solver = ClothSolver(both, Material(damping=4.0))
    grasps = {"a": hand((-0.15, 0.15, 0.0)), "b": hand((1.15, 0.15, 0.0)), "c": hand((0.85, 0.15, 0.0))}
    _, felt = played(solver, solver.initial_state(), grasps, 5.0)
    half = 0.5 * weight_of(solver)
    np.testing.assert_allclose(felt[0, 0], [0.0, 0.0, -half], atol=0.01 * half)
    np.testing.assert_allclose(felt[1, 0] + felt[2, 0], [0.0, 0.0, -half], atol=0.01 * half)


def test_far_from_the_origin_hands_feel_the_same():
    mesh, felt = CLOTHS["coarse"], []
    for far in (0.0, 1000.0):
        solver = ClothSolver(mesh, Material(damping=4.0))
        away = np.array([far, -far, far])
        state = solver.initial_state(Pose(tuple(away)))
        felt.append(played(solver, state, {"hand": hand(mesh.rest_position[0] + away)}, 4.0)[1][0])
    np.testing.assert_allclose(felt[0], felt[1], atol=1e-3 * weight_of(solver))


SEEDS = st.integers(0, 10**6)


@given(SEEDS)
def test_what_is_left_over_is_what_newton_says(seed):
    random = np.random.default_rng(seed)
    mass, held, time, damped = random.uniform(0.1, 2.0, 7), np.flatnonzero(random.random(7) < 0.5), 0.02, 0.3
    gravity, component, about = random.normal(size=3), random.integers(0, 2, 7), random.normal(size=(2, 3))
    outer, start, end, before, after = random.normal(size=(5, 7, 3))
    before_it, free = random.normal(size=(len(held), 3)), np.isin(range(7), held, invert=True)
    force, whole = before_it.copy(), np.zeros((2, 6))
    kernels.left_over(
        mass, gravity, outer, start, end, before, after, damped, time, component, about, held, force, whole
    )
    momentum = mass[:, None] * (after - before + damped * free[:, None] * (end - start))
    rest = mass[:, None] * gravity + outer - momentum / time
    np.testing.assert_allclose(force - before_it, rest[held], atol=1e-9)
    for part in range(2):
        its = component == part
        moments = np.cross(0.5 * (start + end)[its] - about[part], rest[its])
        expected = [rest[its].sum(axis=0), moments.sum(axis=0)]
        np.testing.assert_allclose(whole[part], np.concatenate(expected), atol=1e-9)


@given(SEEDS, st.integers(0, 5), st.integers(0, 3), st.booleans())
def test_what_is_missing_is_shared_in_proportion_and_by_leverage(seed, points, obstacles, slack):
    """As the slow twin shares it, and so that forces and moments balance, whatever part of the cloth it is."""
    assume(points > 1 or obstacles)
    random = np.random.default_rng(seed)
    part, whole = random.permutation([0, 0] + [1] * points), random.normal(size=(2, 6))
    arm, lever = random.normal(size=(points + 2, 3)), random.normal(size=(obstacles, 3))
    force = random.normal(size=(points + 2, 3)) * (0.0 if slack else 1.0)
    its, other = part == 1, part == 0
    press = np.array([[twins.pressed(*random.normal(size=(2, 4, 3))) for _ in range(2)] for _ in range(obstacles)])
    press = press.reshape(obstacles, 2, 19)
    felt, pressing = force.copy(), press.copy()
    leverage.make_up(1, whole, part, arm, lever, felt, pressing)
    np.testing.assert_array_equal(felt[other], force[other])
    np.testing.assert_array_equal(pressing[:, 0], press[:, 0])
    np.testing.assert_array_equal(pressing[:, 1, 6:], press[:, 1, 6:])
    expected = twins.made_up(whole[1], arm[its], force[its], lever, press[:, 1])
    np.testing.assert_allclose(felt[its], expected[0], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(pressing[:, 1, :6], expected[1], rtol=1e-6, atol=1e-6)
    if points > 2 or (points and obstacles):
        moments = np.cross(arm[its], felt[its]).sum(axis=0) + np.cross(lever, pressing[:, 1, :3]).sum(axis=0)
        made_up = np.add([felt[its].sum(axis=0), moments], pressing[:, 1, :6].sum(axis=0).reshape(2, 3))
        np.testing.assert_allclose(made_up, whole[1].reshape(2, 3), atol=1e-6)


@given(SEEDS)
def test_one_point_bears_a_force_and_no_moment(seed):
    """Wherever it is: what differences of rounded numbers seem to resist a turn, do not."""
    random = np.random.default_rng(seed)
    arm, whole, force = *random.normal(size=(2, 1, 6)), random.normal(size=(1, 3))
    leverage.make_up(0, whole, np.zeros(1, np.int64), 10.0 * arm[:, :3], np.zeros((0, 3)), force, np.zeros((0, 1, 19)))
    np.testing.assert_allclose(force[0], whole[0, :3], atol=1e-12)


def test_of_what_is_not_finite_nothing_is_raised():
    arm, force = np.eye(3), np.array([[np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, 1.0]])
    leverage.make_up(0, np.ones((1, 6)), np.zeros(3, np.int64), arm, np.zeros((0, 3)), force, np.zeros((0, 1, 19)))
    assert not np.isfinite(force).any()
