"""Another material or configuration while the cloth moves: made aside, taken up without a jolt."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest
from busy import OBSTACLES, assert_same, busy_solver, played

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, MeshError, Pose, SolverConfig, State
from cloth_core.integrators.implicit_midpoint import LONGEST_SUBSTEP
from cloth_core.validation.geometry import irregular_sheet

BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])
STILL_AIR = dict(air_density=0.0)
G = 9.81


@BOTH
@pytest.mark.parametrize("dense_limit", [0, 5000])
@pytest.mark.parametrize("at", [2, 10, 20])
def test_no_change_changes_no_bit(integrator, dense_limit, at):
    solver = busy_solver(integrator, dense_limit=dense_limit)
    state = played(solver, solver.initial_state(), 0, at)
    straight = played(solver, state, at, 30)
    same = solver.changed()
    assert same is not solver
    np.testing.assert_array_equal(same.pinned, solver.pinned)
    assert_same(played(same, state, at, 30), straight)


@BOTH
@pytest.mark.parametrize("material", [Material(stretch_warp=300.0, shear=0.0), Material(bend=0.0, areal_density=0.5)])
def test_what_is_taken_over_from_the_old_solver_is_as_good_as_new(integrator, material):
    """Shear of zero leaves out entries of the matrix, so that another plan of elimination is needed."""
    old = busy_solver("implicit_midpoint", dense_limit=0)
    config = replace(old.config, dt=0.01, integrator=integrator)
    state = played(old, old.initial_state(), 0, 8)
    fresh = ClothSolver(old.mesh, material, config, obstacles=OBSTACLES)
    fresh.pin(old.pinned)
    assert_same(played(old.changed(material=material, config=config), state, 8, 20), played(fresh, state, 8, 20))


@pytest.mark.parametrize("there", [True, False])
def test_a_sheet_may_pass_from_springs_to_triangles_and_back(there):
    """They remember tensions of threads in other shapes; those of the other kind are left behind."""
    mesh = ClothMesh.grid(width=0.6, height=0.6, columns=8, rows=8)
    kinds = [Material(areal_density=2.0, stretch_limit=1.005, shear=shear) for shear in (400.0, 2e5)]
    before, after = kinds if there else kinds[::-1]
    assert mesh.is_membrane(before) != mesh.is_membrane(after)
    solver = ClothSolver(mesh, before)
    solver.pin([0])
    state = solver.initial_state()
    for _ in range(40):
        state = solver.step(state, Inputs())
    assert state.history["tension"].any()
    other = solver.changed(material=after)
    for _ in range(20):
        state = other.step(state, Inputs())
        assert not other.report.recovered and other.report.max_stretch < 1.15
    assert state.history["tension"].any()


def test_the_old_solver_steps_on_as_if_nothing_had_happened():
    solver, alone = busy_solver("implicit_midpoint"), busy_solver("implicit_midpoint")
    state = played(solver, solver.initial_state(), 0, 10)
    report = solver.report
    other = solver.changed(material=Material(areal_density=1.0), config=SolverConfig(dt=0.005))
    assert solver.report is report and solver.material != other.material and other.config.dt == 0.005
    played(other, state, 10, 13)
    other.unpin()
    assert len(solver.pinned) == 1
    assert_same(played(solver, state, 10, 25), played(alone, played(alone, alone.initial_state(), 0, 10), 10, 25))


def test_pins_of_the_new_solver_are_planned_for_anew():
    solver, fresh = busy_solver("implicit_midpoint", dense_limit=0), busy_solver("implicit_midpoint", dense_limit=0)
    solver.prepare()
    other = solver.changed()
    for one in (other, fresh):
        one.pin(solver.mesh.group("corners"))
    assert_same(played(other, other.initial_state(), 0, 5), played(fresh, fresh.initial_state(), 0, 5))


def test_another_thread_makes_it_while_this_one_steps_and_neither_notices():
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=40, rows=40)
    solvers = [ClothSolver(mesh, Material()) for _ in range(2)]
    for solver in solvers:
        solver.pin(mesh.group("corners")[:2])
    alone, watched = solvers
    expected = watched.changed(material=Material.preset("denim"))
    begin = state = alone.step(alone.initial_state(), Inputs())
    made: list[ClothSolver] = []
    worker = threading.Thread(target=lambda: made.append(watched.changed(material=Material.preset("denim"))))
    meanwhile = watched.step(watched.initial_state(), Inputs())
    worker.start()
    steps = 0
    while worker.is_alive() or steps < 5:
        meanwhile, state, steps = watched.step(meanwhile, Inputs()), alone.step(state, Inputs()), steps + 1
    worker.join()
    assert_same(meanwhile, state)
    assert_same(made[0].step(begin, Inputs()), expected.step(begin, Inputs()))


def test_what_cannot_be_computed_is_refused_and_the_old_solver_stays():
    solver = ClothSolver(ClothMesh.grid(width=0.006, height=0.005, columns=11, rows=9))
    state = solver.step(solver.initial_state(), Inputs())
    expected = solver.step(state, Inputs())
    with pytest.raises(MeshError, match="vertices too light"):
        solver.changed(material=Material(bend=1e3, areal_density=1e-3), config=SolverConfig(dt=0.1, substeps=1))
    assert_same(solver.step(state, Inputs()), expected)


def fallen(solver: ClothSolver, state: State, seconds: float) -> State:
    for _ in range(round(seconds / solver.config.dt)):
        state = solver.step(state, Inputs())
    return state


CHANGES = {"dt": dict(dt=0.005), "coarser": dict(substeps=2), "finer": dict(substeps=40)}


@pytest.mark.parametrize("change", CHANGES)
def test_a_falling_cloth_stays_on_its_parabola_whatever_the_substep_becomes(change):
    mesh = irregular_sheet(0.5, 0.4, 6, seed=1)
    solver = ClothSolver(mesh, Material(), SolverConfig(**STILL_AIR))
    other = solver.changed(config=SolverConfig(**STILL_AIR, **CHANGES[change]), material=Material(areal_density=0.7))
    half = fallen(solver, solver.initial_state(), 0.2)
    drop = lambda state: (state.position - mesh.rest_position)[:, 2]  # noqa: E731
    np.testing.assert_allclose(drop(fallen(other, half, 0.2)), -0.5 * G * 0.4**2, atol=1e-9)
    # Without what the state remembers it would be late by half a substep's acceleration.
    late = drop(fallen(other, replace(half, history={}), 0.2)) + 0.5 * G * 0.4**2
    np.testing.assert_allclose(late, 0.5 * G * LONGEST_SUBSTEP * 0.2, rtol=1e-6)


def test_the_papers_step_takes_over_the_whole_velocity():
    mesh, config = irregular_sheet(0.5, 0.4, 6, seed=1), SolverConfig(**STILL_AIR)
    solver = ClothSolver(mesh, Material(), config)
    paper = solver.changed(config=replace(config, integrator="meyer2000"))
    state = fallen(solver, solver.initial_state(), 0.2)
    before, after = state, paper.step(state, Inputs())
    way = (after.position - before.position)[:, 2]
    np.testing.assert_allclose(way, -0.02 * G * (0.2 + 0.02), rtol=1e-9)
    np.testing.assert_allclose(after.velocity[:, 2], -G * 0.22, rtol=1e-9)
    again = paper.step(after, Inputs())
    np.testing.assert_allclose((again.position - after.position)[:, 2], -0.02 * G * 0.24, rtol=1e-9)


def tumbling(mesh: ClothMesh) -> State:
    spin = np.array([1.0, 2.0, 3.0])
    velocity = np.cross(spin, mesh.rest_position) + np.array([0.3, -0.2, 0.1])
    return State(mesh.rest_position.copy(), velocity)


@pytest.mark.parametrize("change", CHANGES)
def test_both_momenta_pass_over(change):
    """Half as dense again or stiffer by ten: what moves goes on to move as it did."""
    mesh = irregular_sheet(0.5, 0.4, 9, seed=1)
    solver = ClothSolver(mesh, Material(), SolverConfig(**STILL_AIR))
    soft = Material(stretch_warp=150.0, stretch_weft=300.0, bend=1e-3)
    other = solver.changed(material=soft, config=SolverConfig(**STILL_AIR, **CHANGES[change]))
    weightless = Inputs(gravity=(0.0, 0.0, 0.0))
    state = tumbling(mesh)
    for _ in range(20):
        state = solver.step(state, weightless)
    mass = mesh.vertex_mass(Material())

    def momenta(state: State) -> np.ndarray:
        velocity = state.velocity + state.history["lag"]
        arm = state.position - mass @ state.position / mass.sum()
        return np.array([mass @ velocity, mass @ np.cross(arm, velocity)])

    before = momenta(state)
    for _ in range(10):
        state = other.step(state, weightless)
        np.testing.assert_allclose(momenta(state)[0], before[0], atol=1e-12)
        np.testing.assert_allclose(momenta(state)[1], before[1], atol=2e-3 * np.linalg.norm(before[1]))


@pytest.mark.parametrize(("substeps", "most"), [(5, 1e-3), (8, 5e-5), (20, 5e-4)])
def test_a_strip_that_hangs_at_its_limit_stays_where_it_hangs(substeps, most):
    mesh = ClothMesh.grid(width=0.2, height=0.8, columns=5, rows=17)
    heavy = Material(areal_density=1.0, stretch_warp=100.0, stretch_weft=100.0, shear=30.0, damping=5.0)
    solver = ClothSolver(mesh, heavy)
    solver.pin(mesh.group("top"))
    upright = Pose(orientation=(np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)))
    state = fallen(solver, solver.initial_state(upright), 3.0)
    assert (state.history["tension"] > 0.0).sum() > 20
    other = solver.changed(config=SolverConfig(substeps=substeps))
    kept, dropped = (
        np.abs(fallen(other, begin, 0.2).position - state.position).max()
        for begin in (state, replace(state, history={}))
    )
    assert kept < most
    assert dropped > 1.5 * kept or substeps != 8  # what a new substep changes itself is as much as what is forgotten
