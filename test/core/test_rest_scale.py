"""Rest lengths that are scaled: a band gets as long as it is told, pulls as Hooke says, and gets there in time."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Grasp, InputError, Inputs, Material, MeshError, Pose
from cloth_core import SolverConfig as Config
from cloth_core.config import INTEGRATORS
from cloth_core.linear import stretch_matrix
from cloth_core.physics.rest_scale import FASTEST, RestScale
from cloth_core.physics.strain import vertex_strain

LENGTH, HEIGHT = 0.6, 0.1
GRID = ClothMesh.grid(width=LENGTH, height=HEIGHT, columns=19, rows=4)
BAND = dataclasses.replace(GRID, groups={**GRID.groups, "band": np.arange(GRID.vertex_count, dtype=np.int32)})
WOVEN = dataclasses.replace(BAND, spring_weight=np.zeros_like(BAND.spring_weight))
FABRIC = Material(stretch_warp=500.0, stretch_weft=800.0, shear=0.0, damping=8.0, stretch_limit=1.05)
NOWHERE = (0.0, 0.0, 0.0)
MESHES = pytest.mark.parametrize("mesh", [BAND, WOVEN], ids=["springs", "triangles"])


def settled(solver, inputs, steps, state=None):
    state = state or solver.initial_state()
    for _ in range(steps):
        state = solver.step(state, inputs)
    return state


@MESHES
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("scale", [0.5, 0.9, 1.4])
def test_a_band_at_rest_is_as_long_as_its_scale_says(mesh, integrator, scale):
    solver = ClothSolver(mesh, FABRIC, Config(integrator=integrator))
    state = settled(solver, Inputs(rest_scale={"band": scale}, gravity=NOWHERE), 150)
    np.testing.assert_allclose(np.ptp(state.position, axis=0), (scale * LENGTH, scale * HEIGHT, 0.0), atol=2e-4)
    assert np.abs(vertex_strain(mesh, state.position, solver.rest)).max() < 1e-3
    assert solver.report.max_stretch == pytest.approx(1.0, abs=1e-3)
    assert state.rest_scale == {"band": scale}


@MESHES
def test_between_a_pin_and_a_hand_it_pulls_as_hooke_says(mesh):
    scale, material = 0.97, dataclasses.replace(FABRIC, damping=20.0)
    solver = ClothSolver(mesh, material)
    solver.pin(mesh.group("left"))
    hand = Grasp(pose=Pose((0.5 * LENGTH + HEIGHT, 0.0, 0.0)), closure=1.0, radius=1.2 * HEIGHT)
    still = settled(solver, Inputs(grasps={"hand": hand}, gravity=NOWHERE), 2)
    np.testing.assert_array_equal(still.grips["hand"].vertex, np.sort(mesh.group("right")))
    settled(solver, Inputs(grasps={"hand": hand}, gravity=NOWHERE, rest_scale={"band": scale}), 200, still)
    pull = solver.report.grasp_wrenches["hand"].force[0]
    assert pull == pytest.approx(-material.stretch_weft * HEIGHT * (1.0 - scale), rel=0.01)


def test_it_changes_no_faster_than_documented_and_no_slower():
    solver, inputs = ClothSolver(BAND, FABRIC), Inputs(rest_scale={"band": 0.5}, gravity=NOWHERE)
    state, scales = solver.initial_state(), [1.0]
    while scales[-1] > 0.5:
        state = solver.step(state, inputs)
        scales.append(state.rest_scale["band"])
        assert solver.report.max_stretch < FABRIC.stretch_limit + 0.03
    np.testing.assert_allclose(-np.diff(np.log(scales))[:-1], FASTEST * 0.02, rtol=1e-9)
    assert len(scales) - 1 == math.ceil(math.log(2.0) / (FASTEST * 0.02)) and scales[-1] == 0.5


@MESHES
def test_what_is_no_longer_named_goes_back_to_the_mesh_to_the_last_bit(mesh):
    solver = ClothSolver(mesh, FABRIC)
    state = settled(solver, Inputs(rest_scale={"band": 0.8}, gravity=NOWHERE), 20)
    state = settled(solver, Inputs(gravity=NOWHERE), 100, state)
    assert state.rest_scale == {}
    np.testing.assert_array_equal(solver.rest.spring_rest, mesh.spring_rest)
    np.testing.assert_array_equal(solver.rest.triangle_slope, mesh.triangle_slope)
    assert np.ptp(state.position[:, 0]) == pytest.approx(LENGTH, abs=2e-4)


def test_a_waistband_gathers_and_leaves_the_rest_as_long_as_it_was():
    mesh = ClothMesh.grid(width=0.6, height=0.4, columns=25, rows=17)
    solver = ClothSolver(mesh, dataclasses.replace(FABRIC, damping=3.0))
    solver.pin(mesh.group("top_left"))
    state = settled(solver, Inputs(rest_scale={"top": 0.6}), 150)
    top, inner = mesh.group("top"), np.setdiff1d(np.arange(mesh.vertex_count), mesh.group("top"))
    along = np.linalg.norm(np.diff(state.position[top], axis=0), axis=1)
    assert along.sum() == pytest.approx(0.6 * 0.6, rel=0.06)
    untouched = np.isin(mesh.spring_vertex, inner).all(axis=1)
    np.testing.assert_array_equal(solver.rest.spring_rest[untouched], mesh.spring_rest[untouched])
    assert 0.97 < solver.report.max_stretch <= FABRIC.stretch_limit + 0.03


@MESHES
def test_the_matrix_of_a_scaled_band_is_that_of_the_band(mesh):
    """W is made once: a band cut smaller has the same stiffness as one whose rest lengths are scaled."""
    small = ClothMesh.grid(width=0.7 * LENGTH, height=0.7 * HEIGHT, columns=19, rows=4)
    if mesh is WOVEN:
        small = dataclasses.replace(small, spring_weight=np.zeros_like(small.spring_weight))
    matrices = [stretch_matrix(one, FABRIC).toarray() for one in (mesh, small)]
    np.testing.assert_allclose(*matrices, rtol=1e-9, atol=1e-9 * np.abs(matrices[0]).max())


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_it_goes_on_bit_equal_from_a_snapshot_whatever_the_solver_did_before(integrator):
    config, inputs = Config(integrator=integrator), Inputs(rest_scale={"band": 0.7, "left": 1.2})
    solver = ClothSolver(BAND, FABRIC, config)
    solver.pin(BAND.group("top"))
    middle = settled(solver, inputs, 7)
    kept = {name: array.copy() for name, array in solver.snapshot(middle).items()}
    end = settled(solver, inputs, 9, middle)
    other = ClothSolver(BAND, FABRIC, config)
    settled(other, Inputs(rest_scale={"bottom": 2.0}), 5)
    again = settled(other, Inputs.from_mapping(inputs.as_mapping()), 9, other.restore(kept))
    assert again.digest == end.digest and again.rest_scale == end.rest_scale


def test_a_change_of_the_material_and_of_pins_keeps_the_scale():
    solver, inputs = ClothSolver(BAND, FABRIC), Inputs(rest_scale={"band": 0.8}, gravity=NOWHERE)
    state = settled(solver, inputs, 60)
    other = solver.changed(material=dataclasses.replace(FABRIC, stretch_warp=600.0))
    state = settled(other, inputs, 10, state)
    other.pin([0])
    state = settled(other, inputs, 10, state)
    assert np.ptp(state.position[:, 0]) == pytest.approx(0.8 * LENGTH, rel=1e-3)
    np.testing.assert_allclose(other.rest.spring_rest, 0.8 * BAND.spring_rest)


def test_overlapping_groups_multiply_and_a_spring_that_leaves_a_group_stays():
    rest = RestScale(BAND, FABRIC)
    rest.begin_step({"band": 0.5, "top": 0.5}, {"band": 0.5, "top": 0.5}, 0.02)
    rest.begin_substep(1.0)
    i, j = BAND.spring_vertex.T
    both = np.isin(i, BAND.group("top")) & np.isin(j, BAND.group("top"))
    np.testing.assert_allclose(rest.rest.spring_rest / BAND.spring_rest, np.where(both, 0.25, 0.5))


def test_two_hands_open_a_band_as_wide_as_it_has_become():
    solver = ClothSolver(BAND, FABRIC)
    solver.pin(BAND.group("left"))
    state, reached = solver.initial_state(), 0.5 * LENGTH
    for _ in range(160):
        hand = Grasp(pose=Pose((reached, 0.0, 0.0)), closure=1.0, radius=0.52 * HEIGHT)
        state = solver.step(state, Inputs(grasps={"hand": hand}, rest_scale={"band": 1.5}, gravity=NOWHERE))
        reached = min(reached + 0.004, LENGTH)
    assert np.ptp(state.position[:, 0]) == pytest.approx(1.5 * LENGTH, rel=0.01)


def test_what_cannot_be_scaled_is_refused_with_name_value_and_range():
    solver, start = ClothSolver(BAND, FABRIC), ClothSolver(BAND, FABRIC).initial_state()
    with pytest.raises(InputError, match=r"rest_scale\.band: 4.0 is out of range: a number 0.3 .. 3 m/m"):
        Inputs(rest_scale={"band": 4.0})
    with pytest.raises(InputError, match=r"rest_scale\.band: nan is out of range"):
        Inputs(rest_scale={"band": math.nan})
    with pytest.raises(InputError, match="rest_scale: no vertex group waist; this cloth has band, "):
        solver.step(start, Inputs(rest_scale={"waist": 0.5}))
    with pytest.raises(InputError, match="no spring has both its ends in the group top_left"):
        solver.step(start, Inputs(rest_scale={"top_left": 0.5}))
    with pytest.raises(InputError, match="no triangle has all its corners in the group top:"):
        ClothSolver(WOVEN, FABRIC).check_rest_scale(["top"])
    with pytest.raises(MeshError, match="no vertex group 'waist'"):
        solver.check_rest_scale(["waist"])
    with pytest.raises(InputError, match=r"state\.rest_scale\.band: 9.0 is not a number 0.3 .. 3"):
        solver.step(dataclasses.replace(start, rest_scale={"band": 9.0}), Inputs())
