"""Bending: a dense twin, modes whose motion is known, momenta, and what viscosity may and may not do."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from scipy.linalg import eigh

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.integrators.model import Model
from cloth_core.physics.bending import SLOWEST, Bending
from cloth_core.physics.momentum import MomentumBalance
from cloth_core.validation.scenes import NO_GRAVITY, UNLIMITED, last, states

MESH = ClothMesh.grid(width=0.4, height=0.3, columns=7, rows=5)
FABRIC = Material(bend=2e-3, bend_damping=0.05)
MASS = MESH.vertex_mass(FABRIC)
Q = twins.bending_of(MESH, FABRIC)
NOBODY = np.array([], int)
NO_LAG, GRAVITY, WEIGHTLESS = np.zeros_like(MESH.rest_position), np.array([0.3, -0.5, -9.8]), np.zeros(3)


def bending_of(mesh: ClothMesh, material: Material, time: float, held: np.ndarray = NOBODY) -> Bending:
    """As the default integrator makes it, for solves ``time`` s apart."""
    model = Model(mesh, material, SolverConfig(), {}, h=time, pinned=held)
    elastic, viscous = (model.filter_by(model.bending, time * lasting) for lasting in (time, material.bend_damping))
    return Bending(model.bending, model.mass, model.balance, elastic, viscous, time)


def update(bending: Bending, x, v, lag, gravity, held) -> np.ndarray:
    """Viscosity first, then the elastic part; returns the velocity left."""
    damped = bending.damp(x, v, held)
    bending.bend(x, damped, lag, gravity, held)
    return damped


def crumpled(seed: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return MESH.rest_position + random.normal(0, 0.02, (35, 3)), random.normal(0, 0.5, (35, 3))


def modes(mesh: ClothMesh, material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Squared frequencies s^-2 of free vibration, rising, and their shapes (V, V) as columns."""
    hessian = twins.bending_of(mesh, material)
    return eigh(hessian, np.diag(mesh.vertex_mass(material)))


@pytest.mark.parametrize("held", [[], [3], [0, 6], [0, 1, 2, 3, 4, 5, 6], [0, 6, 30]], ids=str)
@pytest.mark.parametrize("time", [0.002, 0.01])
def test_it_is_the_dense_twin(held, time):
    held, (x, v), lag = np.array(held, int), crumpled(1), 0.1 * crumpled(4)[1]
    bending = bending_of(MESH, FABRIC, time, held)
    damped, acceleration = twins.bent(x, v, MASS, Q, FABRIC.bend_damping, time, held, lag, GRAVITY)
    np.testing.assert_allclose(update(bending, x, v, lag, GRAVITY, held), damped, atol=1e-11)
    np.testing.assert_allclose(bending.acceleration, acceleration, atol=1e-9)
    np.testing.assert_array_equal(bending.acceleration[held], 0.0)


@pytest.mark.parametrize("number", [4, 9, 25])
def test_a_mode_swings_and_dies_away_as_implicit_integration_has_it(number):
    """Shape s of frequency w: speed is divided by 1 + w^2 t lasting, then w^2 t pulls implicitly, over 1 + w^2 t^2."""
    square, shapes = modes(MESH, FABRIC)
    w2, shape = square[number], np.outer(shapes[:, number], [0.0, 0.0, 1.0])
    assert w2 > 1.0
    time, bending = 0.005, bending_of(MESH, FABRIC, 0.005)
    damped = update(bending, MESH.rest_position + 0.3 * shape, 0.7 * shape, NO_LAG, GRAVITY, NOBODY)
    speed = 0.7 / (1 + w2 * time * FABRIC.bend_damping)
    np.testing.assert_allclose(damped, speed * shape, atol=1e-10)
    pull = -w2 * (0.3 + time * speed) / (1 + w2 * time**2)
    np.testing.assert_allclose(bending.acceleration, pull * shape, rtol=1e-6, atol=1e-7)


def test_within_little_time_it_is_the_force_of_the_energy():
    x, v = crumpled(2)
    bending = bending_of(MESH, Material(bend=2e-3, bend_damping=0.0), 1e-6)
    np.testing.assert_allclose(update(bending, x, v, NO_LAG, WEIGHTLESS, NOBODY), v, atol=1e-13)
    force = -Q @ x
    np.testing.assert_allclose(MASS[:, None] * bending.acceleration, force, atol=1e-4 * np.abs(force).max())


@pytest.mark.parametrize("seed", range(5))
def test_a_free_part_keeps_both_momenta(seed):
    x, v = crumpled(seed)
    bending = bending_of(MESH, FABRIC, 0.01)
    damped = update(bending, x, v, NO_LAG, WEIGHTLESS, NOBODY)
    for change in (damped - v, bending.acceleration):
        size = MASS @ np.linalg.norm(change, axis=1)
        assert size > 1e-3
        assert np.linalg.norm(MASS @ change) < 1e-12 * size
        assert np.linalg.norm(MASS @ np.cross(x, change)) < 1e-12 * size


def test_without_the_balance_bending_would_turn_a_folded_part(monkeypatch):
    """W filters the force, and a filtered force is no longer free of torque where it acts."""
    monkeypatch.setattr(MomentumBalance, "correct", lambda *_, **__: None)
    x, v = crumpled(0)
    bending = bending_of(MESH, FABRIC, 0.01)
    update(bending, x, v, NO_LAG, WEIGHTLESS, NOBODY)
    torque = MASS @ np.cross(x, bending.acceleration)
    assert np.linalg.norm(torque) > 1e-6 * (MASS @ np.linalg.norm(bending.acceleration, axis=1))


def test_viscosity_feels_curvature_that_changes_and_nothing_at_rest():
    x, v = crumpled(3)
    viscous, elastic = bending_of(MESH, FABRIC, 0.01), bending_of(MESH, Material(bend=2e-3, bend_damping=0.0), 0.01)
    np.testing.assert_array_equal(update(viscous, x, 0 * v, NO_LAG, WEIGHTLESS, NOBODY), 0 * v)
    update(elastic, x, 0 * v, NO_LAG, WEIGHTLESS, NOBODY)
    np.testing.assert_allclose(viscous.acceleration, elastic.acceleration, atol=1e-12)
    flat = MESH.rest_position
    flying = np.array([1.0, 2.0, 3.0]) + np.cross([0.5, -1.0, 2.0], flat)
    np.testing.assert_allclose(update(viscous, flat, flying, NO_LAG, WEIGHTLESS, NOBODY), flying, atol=1e-11)
    np.testing.assert_allclose(viscous.acceleration, 0.0, atol=1e-8)
    damped = update(viscous, x, v, NO_LAG, WEIGHTLESS, NOBODY)
    assert np.sum(damped * (Q @ damped)) < 0.2 * np.sum(v * (Q @ v))
    assert MASS @ np.sum(damped**2, axis=1) < MASS @ np.sum(v**2, axis=1)


def test_a_clamped_strip_sags_alike_whatever_its_viscosity():
    mesh = ClothMesh.grid(width=0.2, height=0.05, columns=13, rows=4)
    clamped = np.flatnonzero(mesh.rest_position[:, 0] < -0.08)
    sagging = []
    for lasting in (0.0, 0.3):
        material = Material(bend=1e-2, bend_damping=lasting, damping=5.0, stretch_limit=UNLIMITED)
        solver = ClothSolver(mesh, material, SolverConfig(air_density=0.0))
        solver.pin(clamped)
        state = last(solver, solver.initial_state(), Inputs(), 8.0)
        assert np.abs(state.velocity).max() < 1e-4
        sagging.append(state.position)
    assert -0.05 < sagging[0][:, 2].min() < -0.01
    np.testing.assert_allclose(sagging[1], sagging[0], atol=1e-5)


@pytest.mark.parametrize(("substeps", "solves"), [(10, 2), (40, 2), (7, 7), (1, 1)])
def test_one_solve_serves_ten_milliseconds_at_most(substeps, solves, monkeypatch):
    called = []
    bend = Bending.bend
    monkeypatch.setattr(Bending, "bend", lambda self, *given: called.append(1) or bend(self, *given))
    solver = ClothSolver(MESH, FABRIC, SolverConfig(dt=0.02, substeps=substeps))
    solver.step(solver.initial_state(), NO_GRAVITY)
    assert len(called) == solves
    assert solves == substeps or 0.02 / solves <= SLOWEST + 1e-12


def test_viscosity_leaves_flight_and_spin_alone_and_stops_wrinkling():
    """A sheet that flies and spins keeps both momenta; a wrinkling one loses its wrinkles, sooner the more viscous."""
    mesh = ClothMesh.grid(width=0.4, height=0.4, columns=9, rows=9)
    x, mass = mesh.rest_position, mesh.vertex_mass(Material())
    wrinkling = np.zeros_like(x)
    wrinkling[:, 2] = 0.01 * np.sin(40 * x[:, 0])
    flying = np.array([1.0, 2.0, 3.0]) + np.cross([0.0, 0.0, 2.0], x)
    left = []
    for damping in (0.0, 0.05, 0.5):
        material = Material(bend=1e-4, bend_damping=damping, stretch_limit=UNLIMITED)
        solver = ClothSolver(mesh, material, SolverConfig(air_density=0.0))
        *_, state = states(solver, State(x.copy(), flying + wrinkling), NO_GRAVITY, 0.1)
        speed = mass @ state.velocity / mass.sum()
        np.testing.assert_allclose(speed, mass @ (flying + wrinkling) / mass.sum(), atol=1e-9)
        r = state.position - mass @ state.position / mass.sum()
        expected = 2.0 * (mass * (x[:, 0] ** 2 + x[:, 1] ** 2)).sum()
        assert (mass @ np.cross(r, state.velocity))[2] == pytest.approx(expected, rel=1e-4)
        rigid = np.column_stack([np.ones(len(x)), x[:, :2]])
        upward = state.velocity[:, 2]
        left.append(float(np.std(upward - rigid @ np.linalg.lstsq(rigid, upward, rcond=None)[0])))
    assert left[0] > 1.5 * left[1] > 6 * left[2]
