"""The cloth against itself and other cloths: it keeps its thickness, rubs, rests, and never passes through."""

from __future__ import annotations

import math
from dataclasses import replace

import layers as twins
import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig, State
from cloth_core.obstacles import Plane

BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
THICKNESS = 0.003
WEIGHTLESS = (0.0, 0.0, 0.0)


def crosses(mesh: ClothMesh, x: np.ndarray) -> int:
    """Edges that run through triangles of other vertices."""
    sides = np.unique(np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    low, high = x[mesh.triangles].min(axis=1), x[mesh.triangles].max(axis=1)
    count = 0
    for p, q in sides:
        near = ((np.minimum(x[p], x[q]) <= high) & (np.maximum(x[p], x[q]) >= low)).all(axis=1)
        for row in mesh.triangles[near]:
            count += p not in row and q not in row and twins.runs_through(x[p], x[q], *x[row])
    return count


def layered(
    mesh: ClothMesh, integrator: str = "implicit_midpoint", obstacles: dict | None = None, **material: float
) -> ClothSolver:
    made = Material(**{"thickness": THICKNESS, "friction": 0.3, **material})
    config = SolverConfig(integrator=integrator, self_collision=True, air_density=0.0)
    return ClothSolver(mesh, made, config, obstacles=obstacles or {})


def play(solver: ClothSolver, state: State, steps: int, **inputs: object) -> State:
    for _ in range(steps):
        state = solver.step(state, Inputs(**inputs))
    return state


@BOTH
@pytest.mark.parametrize("thickness", [0.002, 0.008])
def test_two_layers_rest_a_thickness_apart_and_are_quiet(integrator, thickness):
    shell = SolverConfig().contact_shell
    below = ClothMesh.grid(width=0.36, height=0.36, columns=12, rows=12)
    above = twins.sheets((0.011, 0.007, 3.0 * thickness), side=0.3)
    place = np.concatenate([below.rest_position, above.rest_position]) + np.array((0.0, 0.0, shell))
    mesh = ClothMesh.from_triangles(place, np.concatenate([below.triangles, above.triangles + below.vertex_count]))
    solver = layered(mesh, integrator, {"floor": Plane()}, thickness=thickness)
    state = play(solver, solver.initial_state(), 75)
    half = below.vertex_count
    for _ in range(10):
        state = play(solver, state, 1)
        assert np.abs(state.velocity).max() < 0.02
        gap = state.position[half:, 2].mean() - state.position[:half, 2].mean()
        assert 0.9 * thickness < gap < 1.05 * thickness
    assert state.position[half:, 2].min() - state.position[:half, 2].max() > 0.8 * thickness
    assert solver.report.self_contacts > 0 == solver.report.crossings


def incline(tangent: float, seconds: float) -> tuple[float, float]:
    """How far, in m, a cloth slides on a held one that is inclined, and how far it should with friction 0.4."""
    below = ClothMesh.grid(width=0.6, height=0.3, columns=16, rows=8)
    above = ClothMesh.grid(width=0.2, height=0.2, columns=7, rows=7)
    place = np.concatenate([below.rest_position, above.rest_position + np.array((0.013, 0.007, THICKNESS))])
    mesh = ClothMesh.from_triangles(place, np.concatenate([below.triangles, above.triangles + below.vertex_count]))
    solver = layered(mesh, friction=0.4)
    solver.pin(np.arange(below.vertex_count))
    state, g, angle = solver.initial_state(), 9.81, math.atan(tangent)
    state = play(solver, state, round(seconds / 0.02), gravity=(g * math.sin(angle), 0.0, -g * math.cos(angle)))
    moved = (state.position - place)[below.vertex_count :, 0].mean()
    return moved, max(0.0, 0.5 * g * (math.sin(angle) - 0.4 * math.cos(angle)) * seconds**2)


def test_a_cloth_on_a_cloth_sticks_below_the_angle_of_friction_and_slides_above():
    stuck, _ = incline(0.97 * 0.4, 0.5)
    slid, expected = incline(1.03 * 0.4, 0.5)
    assert abs(stuck) < 1e-4
    assert 0.3 * expected < slid < 1.7 * expected and expected > 0.01


def test_a_cloth_slides_down_a_cloth_as_fast_as_coulomb_lets_it():
    slid, expected = incline(0.8, 0.24)
    assert slid == pytest.approx(expected, rel=0.03) and expected > 0.08


def folding() -> tuple[ClothSolver, State]:
    """A cloth folded in two in free flight, whose halves fly together."""
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=17, rows=13)
    # Soft: the arc begins strained, and accelerations that no substep resolves are left out, with their momentum.
    solver = layered(mesh, thickness=0.002, stretch_limit=10.0, stretch_warp=200.0, stretch_weft=200.0, shear=40.0)
    x, radius = mesh.rest_position.copy(), 0.02
    way = x[:, 0] + 0.007
    turn = np.clip(way / radius, -math.pi / 2, math.pi / 2)
    beyond = np.abs(way) - np.abs(turn) * radius
    x[:, 0] = beyond - radius * np.cos(turn)
    x[:, 2] = radius * np.sin(turn)
    x[:, 1] += 0.02 * np.clip(way / 0.15, 0.0, 1.0)
    velocity = np.zeros_like(x)
    velocity[:, 2] = -1.5 * np.sign(way) * np.clip(beyond / 0.1, 0.0, 1.0)
    return solver, replace(solver.initial_state(), position=x, velocity=velocity + np.array((0.3, 0.2, 0.1)))


def colliding(integrator: str) -> tuple[ClothSolver, State]:
    """Two sheets in free flight, one faster than the other and askew."""
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.011, 0.007, 0.01), count=9)
    state, half = (solver := layered(mesh, integrator)).initial_state(), mesh.vertex_count // 2
    place, velocity = state.position.copy(), np.full(state.position.shape, 0.2)
    place[half:, 2] += 0.02 * place[half:, 0] + 0.3 * place[half:, 1] ** 2
    velocity[half:, 2] -= 1.0
    return solver, replace(state, position=place, velocity=velocity)


@pytest.mark.parametrize(
    "start", [folding, lambda: colliding("implicit_midpoint"), lambda: colliding("meyer2000")],
    ids=["folded", "implicit_midpoint", "meyer2000"],
)  # fmt: skip
def test_what_meets_in_free_flight_keeps_its_momentum(start):
    solver, state = start()
    mass = solver.mesh.vertex_mass(solver.material)[:, None]
    before, touched = (mass * state.velocity).sum(axis=0), 0
    for _ in range(25):
        state = play(solver, state, 1, gravity=WEIGHTLESS)
        touched += solver.report.self_contacts
        np.testing.assert_allclose((mass * state.velocity).sum(axis=0), before, atol=1e-12)
        assert crosses(solver.mesh, state.position) == 0
    assert touched > 50


@BOTH
@pytest.mark.parametrize("speed", [1.0, 10.0, 30.0])
def test_a_sheet_thrown_at_a_held_one_does_not_pass(integrator, speed):
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.011, 0.007, 0.1), side=0.3, count=9)
    solver = layered(mesh, integrator)
    half = mesh.vertex_count // 2
    border = np.abs(mesh.rest_position[:half, :2]).max(axis=1) > 0.149
    solver.pin(np.flatnonzero(border))
    start = solver.initial_state()
    velocity = np.zeros_like(start.velocity)
    velocity[half:, 2] = -speed
    state = replace(start, velocity=velocity)
    for _ in range(15):
        state = play(solver, state, 1, gravity=WEIGHTLESS)
        assert crosses(mesh, state.position) == 0
    inner = np.abs(state.position[half:, :2]).max(axis=1) < 0.1
    assert inner.sum() > 9
    np.testing.assert_array_less(-0.2, state.position[half:, 2][inner])


def test_what_starts_crossed_is_uncrossed_after_a_while(integrator="implicit_midpoint"):
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.013, 0.008, 0.1), side=0.4, count=15)
    solver = layered(mesh, integrator, {"floor": Plane()}, thickness=0.001)
    state, half = solver.initial_state(), mesh.vertex_count // 2
    place = state.position.copy()
    place[half:, 2] = 0.012 - 0.03 * np.exp(-((place[half:, :2] / 0.07) ** 2).sum(axis=1))
    place[:, 2] += 0.05
    state = replace(state, position=place)
    assert crosses(mesh, place) > 20
    state = play(solver, state, 100)
    assert crosses(mesh, state.position) == 0 == solver.report.crossings
    state = play(solver, state, 20)
    assert crosses(mesh, state.position) == 0


@BOTH
def test_a_cloth_without_folds_moves_as_if_it_could_not_touch_itself(integrator):
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=15, rows=15)
    ends = []
    for on in (False, True):
        config = SolverConfig(integrator=integrator, self_collision=on)
        solver = ClothSolver(mesh, Material(), config, obstacles={"floor": Plane()})
        solver.pin([0])
        state = solver.initial_state(Pose((0.0, 0.0, 0.3), (0.1, 0.0, 0.0, 1.0)))
        for _ in range(10):
            state = solver.step(state, Inputs())
            assert solver.report.self_contacts == 0
        ends.append(state)
    np.testing.assert_array_equal(ends[0].position, ends[1].position)
    np.testing.assert_array_equal(ends[0].velocity, ends[1].velocity)


@BOTH
def test_a_restored_cloth_goes_on_bit_equal_in_the_middle_of_its_contacts(integrator):
    solver, state = colliding(integrator)
    other, _ = colliding(integrator)
    touched = []
    for _ in range(8):
        saved = solver.snapshot(state)
        state = play(solver, state, 1)
        touched.append(solver.report.self_contacts > 0)
        assert play(other, other.restore(saved), 1).digest == state.digest
    assert any(touched)


def test_neighbours_in_a_mesh_finer_than_the_cloth_is_thick_feel_no_ghosts():
    mesh = ClothMesh.grid(width=0.1, height=0.1, columns=11, rows=11)
    solver = layered(mesh, thickness=0.03)
    state = play(solver, solver.initial_state(), 20, gravity=WEIGHTLESS)
    np.testing.assert_allclose(state.position, mesh.rest_position, atol=1e-9)


def test_held_sheets_push_each_other_nowhere():
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.011, 0.007, 0.5 * THICKNESS))
    solver = layered(mesh)
    solver.pin(np.arange(mesh.vertex_count))
    state = play(solver, solver.initial_state(), 5)
    np.testing.assert_array_equal(state.position, mesh.rest_position)


def test_what_starts_too_close_comes_apart_no_faster_than_allowed():
    mesh = twins.sheets((0.0, 0.0, 0.0), (0.011, 0.007, 0.001))
    speed = 0.05
    config = SolverConfig(self_collision=True, max_push_speed=speed, air_density=0.0)
    solver = ClothSolver(mesh, Material(thickness=0.01), config)
    state, half = solver.initial_state(), mesh.vertex_count // 2
    for number in range(1, 15):
        state = play(solver, state, 1, gravity=WEIGHTLESS)
        gap = state.position[half:, 2].mean() - state.position[:half, 2].mean()
        assert gap < 0.001 + 1.5 * speed * 0.02 * number
        assert np.abs(state.velocity).max() < 2.0 * speed
    assert gap > 0.009


def test_a_net_without_triangles_has_nothing_to_touch_with():
    grid = ClothMesh.grid(width=0.2, height=0.2, columns=5, rows=5)
    mesh = ClothMesh.from_springs(grid.rest_position, grid.spring_vertex, stiffness=100.0, mass=1e-3)
    solver = layered(mesh)
    state = play(solver, solver.initial_state(), 3)
    assert solver.report.self_contacts == 0 and np.isfinite(state.position).all()
