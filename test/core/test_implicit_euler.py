"""The default integrator against a dense twin, and against the implicit Euler step that it iterates toward."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from scipy.optimize import minimize

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.validation.scenes import UNLIMITED

GRAVITY = np.array([0.2, -0.3, -9.81])
H = 0.002


def crumpled(mesh: ClothMesh, seed: int) -> State:
    random = np.random.default_rng(seed)
    return State(
        mesh.rest_position + random.normal(0, 0.01, (mesh.vertex_count, 3)),
        random.normal(0, 0.5, (mesh.vertex_count, 3)),
    )


def solver_of(
    mesh: ClothMesh, iterations: int, held: np.ndarray, substeps: int = 1, dt: float = H, bend: float = 1e-3
) -> ClothSolver:
    config = SolverConfig(dt=dt, substeps=substeps, iterations=iterations, air_density=0.0)
    solver = ClothSolver(mesh, Material(bend=bend, bend_damping=0.05, stretch_limit=UNLIMITED), config)
    solver.pin(held)
    return solver


@pytest.mark.parametrize("held", [[], [12, 14], [0, 1, 2, 3, 4]])
@pytest.mark.parametrize("iterations", [1, 3])
def test_twenty_substeps_are_those_of_the_dense_twin(held, iterations):
    mesh, held = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3), np.array(held, int)
    solver = solver_of(mesh, iterations, held)
    mass, material = mesh.vertex_mass(solver.material), solver.material
    bending = twins.bending_matrix(mesh.vertex_count, mesh.hinge_vertex, mesh.hinge_weight, material.bend)
    state = crumpled(mesh, 3)
    x, v = state.position, state.velocity
    for _ in range(20):
        state = solver.step(state, Inputs(gravity=tuple(GRAVITY)))
        x, v = twins.local_global_step(
            x, v, mass, mesh.spring_vertex, mesh.spring_rest, mesh.spring_stiffness(material),
            bending, material.bend_damping, mass[:, None] * GRAVITY, H, held, x[held], iterations,
        )  # fmt: skip
        np.testing.assert_allclose(state.position, x, atol=1e-9)
        np.testing.assert_allclose(state.velocity, v, atol=1e-6)


def test_substeps_are_steps():
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    one, ten = solver_of(mesh, 2, [12], substeps=10, dt=0.02), solver_of(mesh, 2, [12])
    start = crumpled(mesh, 4)
    whole, small = one.step(start, Inputs()), start
    for _ in range(10):
        small = ten.step(small, Inputs())
    np.testing.assert_allclose(whole.position, small.position, atol=1e-13)


def test_iterations_converge_to_the_minimum_of_the_incremental_potential():
    """|x - y|^2_M / (2 h^2) + E(x) of the springs, minimised by scipy without any of our matrices."""
    mesh, held = ClothMesh.grid(width=0.4, height=0.3, columns=4, rows=3), np.array([8, 11])
    solver = solver_of(mesh, 200, held, bend=0.0)
    material, mass = solver.material, mesh.vertex_mass(solver.material)
    k, (i, j) = mesh.spring_stiffness(material), mesh.spring_vertex.T
    start = crumpled(mesh, 5)
    inertial = start.position + H * start.velocity + H * H * GRAVITY
    free = np.setdiff1d(np.arange(12), held)

    def whole(flat):
        x = start.position.copy()
        x[free] = flat.reshape(-1, 3)
        return x

    def potential(flat):
        x = whole(flat)
        length = np.linalg.norm(x[i] - x[j], axis=1)
        elastic = 0.5 * k @ (length - mesh.spring_rest) ** 2
        return 0.5 / H**2 * np.sum(mass[:, None] * (x - inertial) ** 2) + elastic

    def slope(flat):
        x = whole(flat)
        force = twins.spring_forces(x, 0 * x, mesh.spring_vertex, mesh.spring_rest, k, 0.0)
        return (mass[:, None] / H**2 * (x - inertial) - force)[free].ravel()

    best = minimize(
        potential, inertial[free].ravel(), jac=slope, method="BFGS", options={"gtol": 1e-9, "maxiter": 5000}
    )
    after = solver.step(start, Inputs(gravity=tuple(GRAVITY)))
    assert np.abs(slope(after.position[free].ravel())).max() < 1e-5 * np.abs(slope(inertial[free].ravel())).max()
    np.testing.assert_allclose(after.position, whole(best.x), atol=1e-6)


def test_bending_viscosity_leaves_rigid_motion_alone_and_stops_wrinkling():
    """A sheet that flies and spins keeps both momenta; a wrinkling one loses its wrinkles, sooner the more viscous."""
    mesh = ClothMesh.grid(width=0.4, height=0.4, columns=9, rows=9)
    x, mass = mesh.rest_position, mesh.vertex_mass(Material())
    wrinkling = np.zeros_like(x)
    wrinkling[:, 2] = 0.01 * np.sin(40 * x[:, 0])
    left = []
    for damping in (0.0, 0.05, 0.5):
        material = Material(bend=1e-4, bend_damping=damping, stretch_limit=UNLIMITED)
        solver = ClothSolver(mesh, material, SolverConfig(air_density=0.0))
        flying = np.array([1.0, 2.0, 3.0]) + np.cross([0.0, 0.0, 2.0], x)
        state = State(x.copy(), flying + wrinkling)
        for _ in range(5):
            state = solver.step(state, Inputs(gravity=(0.0, 0.0, 0.0)))
        momentum = (mass[:, None] * state.velocity).sum(axis=0) / mass.sum()
        np.testing.assert_allclose(momentum, (flying + wrinkling).mean(axis=0), atol=0.02)
        r = state.position - state.position.mean(axis=0)
        spin = (mass[:, None] * np.cross(r, state.velocity)).sum(axis=0)[2]
        assert spin == pytest.approx(2.0 * (mass * (x[:, 0] ** 2 + x[:, 1] ** 2)).sum(), rel=0.02)
        rigid = np.column_stack([np.ones(len(x)), x[:, :2]])
        upward = state.velocity[:, 2]
        left.append(float(np.std(upward - rigid @ np.linalg.lstsq(rigid, upward, rcond=None)[0])))
    assert left[0] > 1.5 * left[1] > 6 * left[2]


def test_damping_slows_motion_at_its_rate():
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    solver = ClothSolver(mesh, Material(damping=3.0), SolverConfig(air_density=0.0))
    state = State(mesh.rest_position.copy(), np.tile([1.0, 0.0, 0.0], (15, 1)))
    for _ in range(50):
        state = solver.step(state, Inputs(gravity=(0.0, 0.0, 0.0)))
    np.testing.assert_allclose(state.velocity, np.tile([np.exp(-3.0), 0.0, 0.0], (15, 1)), atol=1e-9)
