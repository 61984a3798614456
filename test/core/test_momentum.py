"""The correction of angular momentum: as printed it explodes, with the inverse inertia it is exact."""

from __future__ import annotations

import numpy as np
import pytest
import twins

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.physics.momentum import MomentumBalance
from cloth_core.validation.scenes import UNLIMITED, angular_momentum

WEIGHTLESS = Inputs(gravity=(0.0, 0.0, 0.0))
DT, COUNT, STIFFNESS, MASS = 0.02, 21, 10.0, 0.2 / 21


def spun_chain() -> tuple[ClothMesh, np.ndarray, np.ndarray]:
    """21 equal masses in a bent line, k = 10 N/m, turning about their middle while they stretch."""
    s = np.linspace(-0.5, 0.5, COUNT)
    x = np.stack([s, 0.2 * np.sin(3 * s), 0.1 * s**2], axis=1)
    pairs = np.stack([np.arange(COUNT - 1), np.arange(1, COUNT)], axis=1)
    mesh = ClothMesh.from_springs(x, pairs, stiffness=STIFFNESS, mass=MASS, limited=False)
    return mesh, x, np.cross([0.5, 1.0, 4.0], x) + 0.5 * s[:, None] * [1.0, 0.0, 0.0]


def printed_step(mesh: ClothMesh, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fig. 4 to the letter for a free chain: dT = sum F ^ x_i, then x_i += ((x_G - x_i) ^ dT) dt^2 / m.

    The correction is in m^3: it lacks the inverse of the inertia I' = sum(|r|^2 1 - r r^T).
    """
    h = -(np.diag(np.full(COUNT, 2.0)) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)) * STIFFNESS
    h[0, 0] = h[-1, -1] = -STIFFNESS
    w = np.linalg.inv(np.eye(COUNT) - DT**2 / MASS * h)
    force = w @ twins.spring_forces(x, v, mesh.spring_vertex, mesh.spring_rest, np.full(COUNT - 1, STIFFNESS), DT)
    torque = np.cross(force, x).sum(axis=0)
    moved = x + DT * (v + force * DT / MASS)
    moved = moved + np.cross(x.mean(axis=0) - x, torque) * DT**2 / MASS
    return moved, (moved - x) / DT


def test_the_printed_correction_explodes():
    mesh, x, v = spun_chain()
    energy = [0.5 * MASS * np.sum(v**2)]
    with np.errstate(all="ignore"):
        for _ in range(100):
            x, v = printed_step(mesh, x, v)
            energy.append(0.5 * MASS * np.sum(v**2))
    assert not energy[-1] < 1e6 * energy[0]


@pytest.mark.parametrize("integrator", ["meyer2000", "implicit_euler"])
def test_the_inertia_correction_conserves_angular_momentum(integrator):
    mesh, x, v = spun_chain()
    solver = ClothSolver(mesh, Material(), SolverConfig(dt=DT, integrator=integrator))
    state, mass = State(x, v), np.full(COUNT, MASS)
    before = angular_momentum(state, mass)
    start_energy = 0.5 * MASS * np.sum(v**2)
    for _ in range(150):
        state = solver.step(state, WEIGHTLESS)
        np.testing.assert_allclose(angular_momentum(state, mass), before, atol=1e-9 * np.linalg.norm(before))
        assert 0.5 * MASS * np.sum(state.velocity**2) < 2 * start_energy
    assert np.ptp(state.position, axis=0).max() > 0.3


@pytest.mark.parametrize("integrator", ["meyer2000", "implicit_euler"])
def test_without_the_correction_angular_momentum_is_lost(integrator, monkeypatch):
    """So that the tests above speak of the correction and not of the scheme."""
    monkeypatch.setattr(MomentumBalance, "correct", lambda *_: None)
    mesh, x, v = spun_chain()
    solver = ClothSolver(mesh, Material(), SolverConfig(dt=DT, integrator=integrator))
    state, mass = State(x, v), np.full(COUNT, MASS)
    before = np.linalg.norm(angular_momentum(state, mass))
    for _ in range(50):
        state = solver.step(state, WEIGHTLESS)
    assert abs(np.linalg.norm(angular_momentum(state, mass)) - before) > 1e-4 * before


def two_sheets() -> ClothMesh:
    sheet = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=4)
    x = np.concatenate([sheet.rest_position, sheet.rest_position + np.array([1.0, 0.0, 0.2])])
    return ClothMesh.from_triangles(x, np.concatenate([sheet.triangles, sheet.triangles + 20]))


def test_each_free_piece_is_balanced_by_itself_and_held_ones_are_left_alone():
    mesh, material = two_sheets(), Material(stretch_limit=UNLIMITED)
    mass = mesh.vertex_mass(material)
    random = np.random.default_rng(5)
    x, inertial, moved = random.normal(size=(3, 40, 3))
    first, second = np.arange(20), np.arange(20, 40)
    for held, balanced in ((np.array([], int), [first, second]), (np.array([3]), [second]), (np.array([3, 30]), [])):
        corrected, expected = moved.copy(), moved.copy()
        MomentumBalance(mesh, mass).correct(x, inertial, corrected, held)
        for members in balanced:
            expected += twins.rigid_correction(x, inertial, moved, mass, members)
        np.testing.assert_allclose(corrected, expected, atol=1e-12)


@pytest.mark.parametrize("integrator", ["meyer2000", "implicit_euler"])
def test_a_straight_line_of_masses_is_no_trouble(integrator):
    """Collinear masses have no inertia about their line: the pseudo-inverse must leave that turn out."""
    x = np.stack([np.linspace(0, 1, 6), np.zeros(6), np.zeros(6)], axis=1)
    mesh = ClothMesh.from_springs(x, [[i, i + 1] for i in range(5)], stiffness=50.0, mass=0.1, limited=False)
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator))
    state = State(x.copy(), np.cross([0, 0, 2.0], x - [0.5, 0, 0]))
    for _ in range(100):
        state = solver.step(state, WEIGHTLESS)
    assert angular_momentum(state, np.full(6, 0.1))[2] == pytest.approx(
        2.0 * 0.1 * np.sum((x[:, 0] - 0.5) ** 2), rel=1e-9
    )
    np.testing.assert_allclose(state.position[:, 2], 0, atol=1e-12)
