"""The correction of angular momentum: as printed it explodes, with the inverse inertia it is exact, hinges included."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.physics.momentum import MomentumBalance
from cloth_core.validation.scenes import UNLIMITED, angular_momentum, states

WEIGHTLESS = Inputs(gravity=(0.0, 0.0, 0.0))
DT, COUNT, STIFFNESS, MASS = 0.02, 21, 10.0, 0.2 / 21


def spun_chain(stiffness: float = STIFFNESS) -> tuple[ClothMesh, np.ndarray, np.ndarray]:
    """21 equal masses in a bent line, turning about their middle while they stretch."""
    s = np.linspace(-0.5, 0.5, COUNT)
    x = np.stack([s, 0.2 * np.sin(3 * s), 0.1 * s**2], axis=1)
    pairs = np.stack([np.arange(COUNT - 1), np.arange(1, COUNT)], axis=1)
    mesh = ClothMesh.from_springs(x, pairs, stiffness=stiffness, mass=MASS, limited=False)
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


def spin(state: State, mass: np.ndarray) -> np.ndarray:
    """(3,) kg m^2/s about the centre of mass, of the velocity that the rule has at the end of a step."""
    ahead = state.velocity + state.history.get("lag", 0.0)
    return angular_momentum(State(state.position, ahead), mass)


# In substeps of 2 ms it takes stiffer springs to lose any; and the midpoint rule takes the torque at a middle that
# the correction itself then turns by a little.
BOTH = pytest.mark.parametrize(
    ("integrator", "stiffness", "bound"), [("meyer2000", STIFFNESS, 1e-9), ("implicit_midpoint", 1000.0, 2e-6)]
)


@BOTH
def test_the_inertia_correction_conserves_angular_momentum(integrator, stiffness, bound):
    mesh, x, v = spun_chain(stiffness)
    solver = ClothSolver(mesh, Material(), SolverConfig(dt=DT, integrator=integrator))
    state, mass = State(x, v), np.full(COUNT, MASS)
    before = angular_momentum(state, mass)
    start_energy = 0.5 * MASS * np.sum(v**2)
    for _ in range(150):
        state = solver.step(state, WEIGHTLESS)
        np.testing.assert_allclose(spin(state, mass), before, atol=bound * np.linalg.norm(before))
        assert 0.5 * MASS * np.sum(state.velocity**2) < 2 * start_energy
    assert np.ptp(state.position, axis=0).max() > 0.3


@BOTH
def test_without_the_correction_angular_momentum_is_lost(integrator, stiffness, bound, monkeypatch):
    """So that the tests above speak of the correction and not of the scheme."""
    monkeypatch.setattr(MomentumBalance, "correct", lambda *_, **__: None)
    mesh, x, v = spun_chain(stiffness)
    solver = ClothSolver(mesh, Material(), SolverConfig(dt=DT, integrator=integrator))
    state, mass = State(x, v), np.full(COUNT, MASS)
    before = np.linalg.norm(angular_momentum(state, mass))
    for _ in range(50):
        state = solver.step(state, WEIGHTLESS)
    assert abs(np.linalg.norm(spin(state, mass)) - before) > 50 * bound * before


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
    stretched = np.array([0, 1, 2, 3])  # in random places, these are on no line
    for held, balanced in ((np.array([], int), [first, second]), (stretched, [second]), (stretched + 20, [first])):
        corrected, expected = moved.copy(), moved.copy()
        MomentumBalance(mesh, mass).correct(x, inertial, corrected, held)
        for members in balanced:
            expected += twins.rigid_correction(x, inertial, moved, mass, members)
        np.testing.assert_allclose(corrected, expected, atol=1e-12)


def turned(seed: int) -> np.ndarray:
    """A random proper rotation, (3, 3)."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def moment(about: np.ndarray, x: np.ndarray, way: np.ndarray, mass: np.ndarray) -> np.ndarray:
    return mass @ np.cross(x - about, way)


@given(st.integers(0, 10**6), st.sampled_from([[7], [0, 4], [0, 2, 4], [0, 1, 2, 3, 4]]))
def test_what_hangs_on_a_point_or_a_line_keeps_the_angular_momentum_about_it(seed, held):
    """Whatever way the sheet is turned and folded; the other sheet of the mesh is free, and balanced as such."""
    mesh, random, held = two_sheets(), np.random.default_rng(seed), np.array(held)
    mass = mesh.vertex_mass(Material())
    folded = mesh.rest_position + random.normal(0, 0.05, (40, 3))
    folded[:5] = mesh.rest_position[:5]  # the edge that is held stays straight
    x = folded @ turned(seed).T + random.normal(size=3)
    inertial, moved = x + random.normal(0, 0.01, (2, 40, 3))
    moved[held] = x[held]
    corrected, first = moved.copy(), np.arange(20)
    MomentumBalance(mesh, mass).correct(x, inertial, corrected, held)

    expected = moved + twins.hanging_correction(x, inertial, moved, mass, first, held)
    expected += twins.rigid_correction(x, inertial, moved, mass, np.arange(20, 40))
    np.testing.assert_allclose(corrected, expected, atol=1e-12)
    np.testing.assert_array_equal(corrected[held], moved[held])

    # Held vertices lie on the axis, so that whatever a turn does, it does to the others. At a pivot, too.
    left = moment(x[held[0]], x[first], (inertial - corrected)[first], mass[first])
    left -= moment(x[held[0]], x[held], (inertial - corrected)[held], mass[held])
    spurious = moment(x[held[0]], x[first], (inertial - moved)[first], mass[first])
    along = np.eye(3) if len(held) == 1 else (x[held[-1]] - x[held[0]])[None] / np.linalg.norm(x[held[-1]] - x[held[0]])
    assert np.linalg.norm(along @ left) < 1e-12 < 1e-6 * np.linalg.norm(spurious)


def test_what_hangs_may_be_left_to_the_paper():
    """Which corrects free parts alone: what its viscosity takes from a swing is then lost."""
    mesh, random = two_sheets(), np.random.default_rng(2)
    x, inertial, moved = random.normal(size=(3, 40, 3))
    mass, corrected = mesh.vertex_mass(Material()), moved.copy()
    MomentumBalance(mesh, mass).correct(x, inertial, corrected, np.array([3]), hanging=False)
    expected = moved + twins.rigid_correction(x, inertial, moved, mass, np.arange(20, 40))
    np.testing.assert_allclose(corrected, expected, atol=1e-12)
    np.testing.assert_array_equal(corrected[:20], moved[:20])


@given(st.integers(0, 10**6))
def test_what_is_held_off_a_line_is_left_alone(seed):
    mesh, random = two_sheets(), np.random.default_rng(seed)
    x = mesh.rest_position @ turned(seed).T
    moved = random.normal(size=(40, 3))
    corrected = moved.copy()
    MomentumBalance(mesh, mesh.vertex_mass(Material())).correct(
        x, random.normal(size=(40, 3)), corrected, np.array([0, 4, 15, 20, 24, 35])
    )
    np.testing.assert_array_equal(corrected, moved)


@pytest.mark.parametrize("pins", [[0], [0, 4]], ids=["point", "hinge"])
def test_a_sheet_turns_on_about_what_it_hangs_on(pins, monkeypatch):
    """Weightless, three turns: W alone takes springs that turn for springs that stretch, and changes their spin."""
    mesh = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=4)
    mass, pivot, axis = mesh.vertex_mass(Material()), mesh.rest_position[0], np.array([1.0, 0.0, 0.0])
    start = State(mesh.rest_position.copy(), np.cross(6.0 * axis, mesh.rest_position - pivot))
    before = moment(pivot, start.position, start.velocity, mass) @ axis

    def worst_change() -> float:
        solver = ClothSolver(mesh, Material(stretch_limit=UNLIMITED, bend=0.0), SolverConfig(air_density=0.0))
        solver.pin(pins)
        spins = [
            moment(pivot, s.position, s.velocity + s.history["lag"], mass) @ axis
            for s in states(solver, start, WEIGHTLESS, 3.0)
        ]
        return np.abs(np.array(spins) / before - 1.0).max()

    assert worst_change() < 2e-5
    monkeypatch.setattr(MomentumBalance, "correct", lambda *_, **__: None)
    assert worst_change() > 0.01


@BOTH
def test_a_straight_line_of_masses_is_no_trouble(integrator, stiffness, bound):
    """Collinear masses have no inertia about their line: the pseudo-inverse must leave that turn out."""
    x = np.stack([np.linspace(0, 1, 6), np.zeros(6), np.zeros(6)], axis=1)
    mesh = ClothMesh.from_springs(x, [[i, i + 1] for i in range(5)], stiffness=5 * stiffness, mass=0.1, limited=False)
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator))
    state = State(x.copy(), np.cross([0, 0, 2.0], x - [0.5, 0, 0]))
    for _ in range(100):
        state = solver.step(state, WEIGHTLESS)
    expected = 2.0 * 0.1 * np.sum((x[:, 0] - 0.5) ** 2)
    assert spin(state, np.full(6, 0.1))[2] == pytest.approx(expected, rel=bound)
    np.testing.assert_allclose(state.position[:, 2], 0, atol=1e-12)
