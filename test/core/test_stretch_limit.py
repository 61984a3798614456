"""The stretch limit: neutral to momentum, held ends stay, it limits, and what lasts is carried by tensions."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.physics import stretch_limit
from cloth_core.physics.stretch_limit import StretchLimit
from cloth_core.validation.scenes import NO_GRAVITY, last

MATERIAL = Material(stretch_limit=1.05)
MESH = ClothMesh.grid(width=0.5, height=0.4, columns=6, rows=5)
MASS = MESH.vertex_mass(MATERIAL)


def pulled(seed: int = 0) -> np.ndarray:
    return 1.2 * MESH.rest_position + np.random.default_rng(seed).normal(0, 0.02, MESH.rest_position.shape)


def test_sweeps_keep_the_centre_of_mass():
    limit, x = StretchLimit(MESH, MATERIAL, MASS), pulled()
    before = x.copy()
    for number in range(20):
        assert limit.sweep(x, number) > 0
    assert np.abs(x - before).max() > 0.01
    np.testing.assert_allclose(MASS @ x, MASS @ before, atol=1e-15)


def test_one_spring_keeps_its_axis_and_its_centre_of_gravity():
    chain = ClothMesh.from_springs(
        np.array([[0, 0, 0], [1, 2, 2.0]]), [[0, 1]], stiffness=1.0, mass=[1.0, 3.0], rest_length=[2.0]
    )
    x = chain.rest_position.copy()
    assert StretchLimit(chain, MATERIAL, chain.explicit_mass).sweep(x, 0) == pytest.approx(3.0 / 2.1 - 1)
    np.testing.assert_allclose(x[1] - x[0], np.array([1, 2, 2.0]) / 3 * 2.1, atol=1e-14)
    np.testing.assert_allclose(0.25 * x[0] + 0.75 * x[1], 0.75 * np.array([1, 2, 2.0]), atol=1e-14)


def test_sweeps_converge_to_the_limit():
    limit, x = StretchLimit(MESH, MATERIAL, MASS), pulled()
    for number in range(400):
        excess = limit.sweep(x, number)
    i, j = MESH.spring_vertex[MESH.spring_limited].T
    stretch = np.linalg.norm(x[i] - x[j], axis=1) / MESH.spring_rest[MESH.spring_limited]
    assert excess < 1e-4
    assert stretch.max() < 1.05 * (1 + 1e-4)


def test_held_ends_stay_and_short_springs_are_left_alone():
    limit, x = StretchLimit(MESH, MATERIAL, MASS), pulled()
    held = np.array([0, 7, 29])
    limit.hold(held)
    before = x.copy()
    for number in range(20):
        limit.sweep(x, number)
    np.testing.assert_array_equal(x[held], before[held])
    limit.hold(np.array([], int))
    at_rest = MESH.rest_position.copy()
    assert limit.sweep(at_rest, 0) == 0.0
    np.testing.assert_array_equal(at_rest, MESH.rest_position)


@pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
def test_a_hanging_cloth_keeps_to_its_limit(integrator):
    mesh = ClothMesh.grid(width=0.8, height=0.8, columns=17, rows=17)
    solver = ClothSolver(
        mesh, Material(stretch_limit=1.05, stretch_warp=50.0, stretch_weft=50.0), SolverConfig(integrator=integrator)
    )
    solver.pin(mesh.group("corners")[:2])
    state, worst = solver.initial_state(), 0.0
    for _ in range(100):
        state = solver.step(state, Inputs())
        worst = max(worst, solver.report.max_stretch)
    assert 1.04 < solver.report.max_stretch < 1.10
    assert worst < 1.25


LINKS, LINK, STIFFNESS, WEIGHT = 20, 0.05, 500.0, 0.05 * 9.81
HEAVY = Material(stretch_limit=1.03, damping=4.0)


def heavy_chain() -> ClothSolver:
    """A chain that would hang at twice the limit by its stiffness alone; only its lowest link stays short of it."""
    down = np.stack([np.zeros(LINKS + 1), np.zeros(LINKS + 1), -LINK * np.arange(LINKS + 1.0)], axis=1)
    pairs = [[n, n + 1] for n in range(LINKS)]
    chain = ClothMesh.from_springs(down, pairs, stiffness=STIFFNESS, mass=WEIGHT / 9.81)
    solver = ClothSolver(chain, HEAVY, SolverConfig(air_density=0.0))
    solver.pin([0])
    return solver


def hung(solver: ClothSolver) -> tuple[State, np.ndarray]:
    """After ten seconds, and the lengths of the links over their rest length."""
    state = last(solver, solver.initial_state(), Inputs(), 10.0)
    assert np.abs(state.velocity).max() < 5e-3
    return state, -np.diff(state.position[:, 2]) / LINK


def test_what_a_chain_carries_at_its_limit_is_its_load(monkeypatch):
    """With tensions that do not fade, in newtons: each link carries what hangs below and its stiffness does not."""
    monkeypatch.setattr(stretch_limit, "FADE", 1.0)
    solver = heavy_chain()
    state, stretch = hung(solver)
    load = WEIGHT * np.arange(LINKS, 0, -1)
    np.testing.assert_allclose(STIFFNESS * LINK * (stretch - 1) + state.history["tension"], load, rtol=5e-3)
    np.testing.assert_allclose(stretch[:-1], 1.03, rtol=2e-4)
    assert stretch[-1] == pytest.approx(1 + WEIGHT / STIFFNESS / LINK, rel=2e-4)
    assert state.history["tension"][-1] == 0.0


def test_a_chain_hangs_at_its_limit(monkeypatch):
    """Without tensions, sweeps alone have to lift it anew in every substep, and fall farther behind."""
    state, stretch = hung(heavy_chain())
    assert 1.03 - 1e-9 < stretch[:-1].min() and stretch.max() < 1.005 * 1.03
    load = WEIGHT * np.arange(LINKS, 0, -1)
    assert (state.history["tension"] >= 0).all() and (state.history["tension"] < load).all()
    monkeypatch.setattr(StretchLimit, "carry", lambda *_: None)
    assert hung(heavy_chain())[1].max() > stretch.max()


def test_tensions_vanish_with_what_they_carry():
    solver = heavy_chain()
    state = last(solver, solver.initial_state(), Inputs(), 2.0)
    assert state.history["tension"].max() > WEIGHT
    assert last(solver, state, NO_GRAVITY, 2.0).history["tension"].max() == 0.0


def hauled(share: float, frequency: float, excess: float, monkeypatch: pytest.MonkeyPatch) -> float:
    """J that the tension of a thread of 1 N/m gives a period of a motion of 1 cm, ``excess`` m over its limit."""
    monkeypatch.setattr(stretch_limit, "YIELDING", share)
    mesh = ClothMesh.from_springs(
        np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.array([[0, 1]]), stiffness=1.0, mass=1.0
    )
    limit, tension = StretchLimit(mesh, Material(stretch_limit=1.1), np.ones(2)), np.zeros(1)
    period = round(1.0 / (frequency * 0.0025))
    length = 1.1 + excess + 0.01 * np.sin(2.0 * np.pi * np.arange(20 * period) / period)
    place = np.zeros((len(length), 2, 3))
    place[:, 1, 0] = length
    work = []
    for start, end, shortened in zip(place[:-1], place[1:], -np.diff(length), strict=True):
        work.append(tension[0] * shortened)
        limit.find(end, tension)
        limit.carry(start, end, tension)
    return sum(work[-period:])


@pytest.mark.parametrize("frequency", [5.0, 10.0, 20.0])
def test_a_tension_that_lets_go_feeds_a_motion_less(frequency, monkeypatch):
    share = stretch_limit.YIELDING
    # What only adds up is the filter 1 / (1 - FADE z^-1), and acts upon the way of the substep that follows.
    period = round(1.0 / (frequency * 0.0025))
    z = np.exp(2j * np.pi / period)
    lagging = -0.5 * period * 0.01**2 * np.real(np.conj(1.0 / (1.0 - stretch_limit.FADE / z)) * (z - 1.0))
    assert hauled(0.0, frequency, 0.02, monkeypatch) == pytest.approx(lagging, rel=1e-3)
    alone = hauled(0.0, frequency, 0.0, monkeypatch)
    assert 0.0 < hauled(share, frequency, 0.0, monkeypatch) < 0.9 * alone


def test_tensions_are_those_of_limited_springs_and_no_stronger_than_their_stiffness():
    limit, tension = StretchLimit(MESH, MATERIAL, MASS), np.zeros(len(MESH.spring_rest))
    for _ in range(200):
        limit.carry(MESH.rest_position, 3.0 * MESH.rest_position, tension)
    limited = MESH.spring_limited
    assert (tension[~limited] == 0).all() and (~limited).any()
    # 5 x 4 cells of 0.1 m x 0.1 m: a thread is as stiff as the sheet, half as stiff at the border.
    i, j = np.abs(MESH.rest_position[MESH.spring_vertex[limited], :2]).transpose(1, 0, 2)
    border = ((i > [0.2499, 0.1999]) & (j > [0.2499, 0.1999])).any(axis=1)
    sheet = MATERIAL.sheet_stiffness()[0]
    strongest = stretch_limit.SHARE * sheet * np.where(border, 0.5, 1.0) * 0.1
    np.testing.assert_allclose(tension[limited], strongest)
