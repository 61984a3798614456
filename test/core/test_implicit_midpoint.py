"""The default integrator: a dense twin, the minimum that it iterates toward, and what a midpoint rule must keep."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.validation.scenes import NO_GRAVITY, UNLIMITED, states

GRAVITY = np.array([0.2, -0.3, -9.81])
FALLING = Inputs(gravity=tuple(GRAVITY))
H = 0.002


def crumpled(mesh: ClothMesh, seed: int) -> State:
    random = np.random.default_rng(seed)
    return State(
        mesh.rest_position + random.normal(0, 0.01, (mesh.vertex_count, 3)),
        random.normal(0, 0.5, (mesh.vertex_count, 3)),
    )


def solver_of(
    mesh: ClothMesh, iterations: int, held: np.ndarray | list[int] = (), substeps: int = 1, dt: float = H, **fabric
) -> ClothSolver:
    config = SolverConfig(dt=dt, substeps=substeps, iterations=iterations, air_density=0.0)
    solver = ClothSolver(mesh, Material(stretch_limit=UNLIMITED, **fabric), config)
    solver.pin(np.array(held, int))
    return solver


def rule_velocity(state: State) -> np.ndarray:
    """(V, 3) m/s at the end of the last substep; ``state.velocity`` is the mean over that substep."""
    return state.velocity + state.history.get("lag", 0.0)


def acceleration(solver: ClothSolver, x: np.ndarray, v: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """(V, 3) m/s^2 of springs that are viscous along themselves: what the rule is to integrate."""
    mesh, material = solver.mesh, solver.material
    i, j = mesh.spring_vertex.T
    way = x[j] - x[i]
    length = np.linalg.norm(way, axis=1)
    axis = way / length[:, None]
    rate = np.sum(axis * (v[j] - v[i]), axis=1)
    k = mesh.spring_stiffness(material)
    pull = (k * (length - mesh.spring_rest + material.stretch_damping * rate))[:, None] * axis
    force = np.zeros_like(x)
    np.add.at(force, i, pull)
    np.add.at(force, j, -pull)
    found = force / mesh.vertex_mass(material)[:, None] + gravity
    found[solver.pinned] = 0.0
    return found


@pytest.mark.parametrize("held", [[], [12], [12, 14], [0, 1, 2, 3, 4]], ids=str)
@pytest.mark.parametrize("iterations", [1, 3])
def test_twenty_substeps_are_those_of_the_dense_twin(held, iterations):
    mesh, held = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3), np.array(held, int)
    solver = solver_of(mesh, iterations, held, bend=1e-3, bend_damping=0.05, stretch_damping=1e-3)
    mass, material = mesh.vertex_mass(solver.material), solver.material
    bending = twins.bending_of(mesh, material)
    state = crumpled(mesh, 3)
    x, v, lag = state.position, state.velocity.copy(), np.zeros((mesh.vertex_count, 3))
    for _ in range(20):
        state = solver.step(state, FALLING)
        x, v, lag = twins.midpoint_step(
            x, v, lag, mass, mesh.spring_vertex, mesh.spring_rest, mesh.spring_stiffness(material),
            material.stretch_damping, bending, material.bend_damping, GRAVITY, H, held, iterations, 0.1,
        )  # fmt: skip
        np.testing.assert_allclose(state.position, x, atol=1e-10)
        np.testing.assert_allclose(state.velocity, v, atol=1e-7)
        np.testing.assert_allclose(state.history["lag"], lag, atol=1e-7)


@pytest.mark.parametrize(("bend", "parts"), [(0.0, 10), (1e-3, 2)])
def test_substeps_are_steps_to_the_last_bit(bend, parts):
    """Bending is solved every 10 ms at most, so that with it a step of 20 ms is two of 10 ms."""
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    whole = solver_of(mesh, 2, [12], substeps=10, dt=0.02, bend=bend)
    part = solver_of(mesh, 2, [12], substeps=10 // parts, dt=0.02 / parts, bend=bend)
    one = many = crumpled(mesh, 4)
    for _ in range(3):
        one = whole.step(one, FALLING)
        for _ in range(parts):
            many = part.step(many, FALLING)
    np.testing.assert_array_equal(one.position, many.position)
    np.testing.assert_array_equal(one.velocity, many.velocity)


def test_without_its_history_it_starts_afresh():
    """Then the velocity is taken for that of the rule: from free fall, the half step g h / 2 is lost once."""
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    solver = solver_of(mesh, 1)
    fallen = solver.initial_state()
    for _ in range(20):
        fallen = solver.step(fallen, FALLING)
    np.testing.assert_allclose(fallen.velocity, np.tile(GRAVITY * 19.5 * H, (15, 1)), atol=1e-12)
    kept, afresh = fallen, State(fallen.position, fallen.velocity)
    for n in range(1, 11):
        kept, afresh = solver.step(kept, FALLING), solver.step(afresh, FALLING)
        missing = np.tile(GRAVITY * H / 2 * n * H, (15, 1))
        np.testing.assert_allclose(kept.position - afresh.position, missing, atol=1e-13)


def test_iterations_converge_to_the_minimum_of_the_incremental_potential_of_the_middle():
    """2 |z - y|^2_M / h^2 + E(z) of the springs, minimised by scipy without any of our matrices."""
    mesh, held = ClothMesh.grid(width=0.4, height=0.3, columns=4, rows=3), np.array([8, 11])
    solver = solver_of(mesh, 200, held, bend=0.0, stretch_damping=0.0)
    material, mass = solver.material, mesh.vertex_mass(solver.material)
    k, (i, j) = mesh.spring_stiffness(material), mesh.spring_vertex.T
    start = crumpled(mesh, 5)
    inertial = start.position + 0.5 * H * start.velocity + 0.25 * H * H * GRAVITY
    free = np.setdiff1d(np.arange(12), held)

    def whole(flat):
        z = start.position.copy()
        z[free] = flat.reshape(-1, 3)
        return z

    def potential(flat):
        z = whole(flat)
        length = np.linalg.norm(z[i] - z[j], axis=1)
        elastic = 0.5 * k @ (length - mesh.spring_rest) ** 2
        return 2 / H**2 * np.sum(mass[:, None] * (z - inertial) ** 2) + elastic

    def slope(flat):
        z = whole(flat)
        force = twins.spring_forces(z, 0 * z, mesh.spring_vertex, mesh.spring_rest, k, 0.0)
        return (4 * mass[:, None] / H**2 * (z - inertial) - force)[free].ravel()

    best = minimize(
        potential, inertial[free].ravel(), jac=slope, method="BFGS", options={"gtol": 1e-9, "maxiter": 5000}
    )
    middle = 0.5 * (start.position + solver.step(start, FALLING).position)
    assert np.abs(slope(middle[free].ravel())).max() < 1e-6 * np.abs(slope(inertial[free].ravel())).max()
    np.testing.assert_allclose(middle, whole(best.x), atol=1e-7)


@pytest.mark.parametrize("lasting", [0.0, 0.005])
def test_halving_the_substep_quarters_the_error(lasting):
    """A net swings on two corners for 0.4 s: positions against scipy's of order eight, elastic and viscous."""
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=4, rows=3)
    fabric = dict(bend=0.0, stretch_warp=20.0, stretch_weft=20.0, shear=5.0, stretch_damping=lasting)
    coarse = solver_of(mesh, 60, [8, 11], **fabric)
    x = mesh.rest_position

    def motion(_, y):
        position, velocity = y.reshape(2, -1, 3)
        return np.concatenate([velocity, acceleration(coarse, position, velocity, GRAVITY)]).ravel()

    start = np.stack([x, np.zeros_like(x)]).ravel()
    exact = solve_ivp(motion, (0.0, 0.4), start, "DOP853", rtol=1e-11, atol=1e-13).y[:36, -1].reshape(-1, 3)
    error = []
    for h in (0.004, 0.002, 0.001):
        solver = solver_of(mesh, 60, [8, 11], substeps=round(0.02 / h), dt=0.02, **fabric)
        *_, end = states(solver, solver.initial_state(), FALLING, 0.4)
        error.append(np.abs(end.position - exact).max())
    assert np.abs(exact - x).max() > 0.2
    assert 3.6 < error[0] / error[1] < 4.4 and 3.6 < error[1] / error[2] < 4.4
    assert error[1] < 1e-3


def test_an_undamped_swing_keeps_its_energy():
    """Ten periods at 45 degrees, iterated to convergence: the energy of the rule errs by the square of the substep."""
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=3, rows=3)
    x = mesh.rest_position - [0.0, 0.1, 0.0]
    tilted = np.stack([x[:, 0], np.sqrt(0.5) * x[:, 1], np.sqrt(0.5) * x[:, 1]], axis=1)
    worst = []
    for substeps in (5, 10):
        solver = solver_of(
            mesh, 15, mesh.group("top"), substeps=substeps, dt=0.02, bend=0.0, stretch_damping=0.0,
            stretch_warp=50.0, stretch_weft=50.0, shear=10.0,
        )  # fmt: skip
        mass, k = mesh.vertex_mass(solver.material), mesh.spring_stiffness(solver.material)
        i, j = mesh.spring_vertex.T
        kinetic, total = [], []
        for state in states(solver, State(tilted, 0 * tilted), Inputs(), 8.0):
            length = np.linalg.norm(state.position[j] - state.position[i], axis=1)
            kinetic.append(0.5 * mass @ np.sum(rule_velocity(state) ** 2, axis=1))
            potential = 9.81 * mass @ (state.position[:, 2] - tilted[:, 2])
            total.append(kinetic[-1] + potential + 0.5 * k @ (length - mesh.spring_rest) ** 2)
        swing = mass.sum() * 9.81 * 0.1 * (1 - np.sqrt(0.5))
        worst.append(np.abs(total).max() / swing)
        assert max(kinetic[-40:]) > 0.5 * swing and min(kinetic[-40:]) < 0.5 * swing  # it still swings
    assert worst[1] < 0.006 and worst[1] < 0.5 * worst[0]


def test_stretch_damping_leaves_a_turn_alone_and_ends_what_stretches():
    """Two masses on a spring: in steady rotation nothing is lost in ten turns; a pulse along the spring dies away."""
    k, m, rest, turn = 50.0, 0.1, 0.5, 6.0
    length = rest * k / (k - 0.5 * m * turn**2)  # the pull k (length - rest) turns m at length / 2
    pair = ClothMesh.from_springs(
        np.array([[-0.5 * rest, 0, 0], [0.5 * rest, 0, 0]]), [[0, 1]], stiffness=k, mass=m, limited=False
    )
    solver = solver_of(pair, 20, substeps=10, dt=0.02, stretch_damping=0.05)
    x = np.array([[-0.5 * length, 0, 0], [0.5 * length, 0, 0]])
    turning, pulse = np.cross([0, 0, turn], x), np.array([[-0.3, 0, 0], [0.3, 0, 0]])
    steady = list(states(solver, State(x, turning), NO_GRAVITY, 10 * 2 * np.pi / turn))
    speeds = np.array([np.linalg.norm(s.velocity[1]) for s in steady])
    lengths = np.array([np.linalg.norm(s.position[1] - s.position[0]) for s in steady])
    np.testing.assert_allclose(speeds, 0.5 * turn * length, rtol=1e-4)
    np.testing.assert_allclose(lengths, length, rtol=1e-4)
    assert speeds[-1] == pytest.approx(speeds[10], rel=1e-7)

    # In its own frame the spring has the rate w^2 = 2 k / m and the damping w^2 stretch_damping / 2: overdamped.
    *_, ended = states(solver, State(x, pulse), NO_GRAVITY, 1.0)
    assert np.abs(ended.velocity).max() < 1e-3 * 0.3


def test_damping_slows_motion_at_its_rate():
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    solver = ClothSolver(mesh, Material(damping=3.0), SolverConfig(air_density=0.0))
    state = State(mesh.rest_position.copy(), np.tile([1.0, 0.0, 0.0], (15, 1)))
    for _ in range(50):
        state = solver.step(state, NO_GRAVITY)
    np.testing.assert_allclose(state.velocity, np.tile([np.exp(-3.0), 0.0, 0.0], (15, 1)), atol=1e-9)
