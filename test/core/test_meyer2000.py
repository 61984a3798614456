"""The paper's integrator against a plain transcription of Fig. 4 with the rulings, dense and per coordinate."""

from __future__ import annotations

import numpy as np
import pytest
import twins

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State, Wind
from cloth_core.linear import stretch_matrix

DT = 0.02


def crumpled(mesh: ClothMesh, seed: int) -> State:
    random = np.random.default_rng(seed)
    return State(
        mesh.rest_position + random.normal(0, 0.03, (mesh.vertex_count, 3)),
        random.normal(0, 0.5, (mesh.vertex_count, 3)),
    )


def transcribed(mesh: ClothMesh, material: Material, state: State, held: np.ndarray, gravity, wind, sweeps: int):
    """One step of :func:`twins.meyer_step` with everything that it needs, read off the mesh."""
    mass = mesh.vertex_mass(material)
    vectors = twins.area_vectors(state.position, mesh.triangles)
    flow = np.tile(np.asarray(wind, float), (mesh.vertex_count, 1))
    outer = mass[:, None] * gravity + twins.drag(flow, vectors, mesh.vertex_area, 0.5 * 1.2 * material.drag)
    limited = mesh.spring_limited
    longest = np.where(limited, mesh.spring_rest * material.stretch_limit, np.inf)
    bending = twins.bending_of(mesh, material)
    return twins.meyer_step(
        state.position, state.velocity, mass, mesh.spring_vertex, mesh.spring_rest, mesh.spring_stiffness(material),
        bending, material.bend_damping, outer, DT, held, state.position[held], longest, sweeps,
    )  # fmt: skip


@pytest.mark.parametrize("held", [[], [12, 14], [0, 1, 2, 3, 4]])
@pytest.mark.parametrize("seed", range(3))
def test_ten_steps_are_those_of_figure_4(held, seed):
    mesh, held = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3), np.array(held, int)
    material = Material(bend=1e-3, stretch_warp=300.0, shear=100.0, stretch_limit=1.05)
    config = SolverConfig(dt=DT, integrator="meyer2000", stretch_sweeps=20)
    solver = ClothSolver(mesh, material, config)
    solver.pin(held)
    state = crumpled(mesh, seed)
    expected = state
    gravity, wind = np.array([0.3, -0.2, -9.81]), (2.0, 1.0, 0.5)
    for _ in range(10):
        state = solver.step(state, Inputs(gravity=tuple(gravity), wind=Wind(velocity=wind)))
        x, v = transcribed(mesh, material, expected, held, gravity, wind, sweeps=20)
        expected = State(x, v)
        np.testing.assert_allclose(state.position, expected.position, atol=1e-9)
        np.testing.assert_allclose(state.velocity, expected.velocity, atol=1e-7)


def test_velocity_is_the_displacement_of_the_step():
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3)
    solver = ClothSolver(mesh, Material(), SolverConfig(dt=DT, integrator="meyer2000"))
    before = crumpled(mesh, 1)
    after = solver.step(before, Inputs())
    np.testing.assert_allclose(after.velocity, (after.position - before.position) / DT, atol=1e-12)


def test_the_matrix_in_the_filter_is_the_hessian_at_zero_rest_length():
    """The viscous force k dt (v_j - v_i) of Fig. 4 is (dt H v)_i of eq. (3)."""
    mesh, material = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=3), Material(bend=0.0)
    v = np.random.default_rng(0).normal(size=(15, 3))
    at_rest = mesh.rest_position
    k = mesh.spring_stiffness(material)
    viscous = twins.spring_forces(at_rest, v, mesh.spring_vertex, mesh.spring_rest, k, DT)
    np.testing.assert_allclose(viscous, -DT * stretch_matrix(mesh, material) @ v, atol=1e-9)
