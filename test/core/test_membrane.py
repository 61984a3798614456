"""The sheet of triangles: what its material says in every mesh and direction."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import twins
from hypothesis import given, settings
from hypothesis import strategies as st
from sheets import forces, plane_hessian, with_warp

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig
from cloth_core.linear.gauges import gauges
from cloth_core.validation.geometry import irregular_sheet
from cloth_core.validation.scenes import last

FABRIC = Material(stretch_warp=900.0, stretch_weft=300.0, shear=50.0)
moduli = st.builds(
    Material,
    stretch_warp=st.floats(1.0, 1e4),
    stretch_weft=st.floats(1.0, 1e4),
    shear=st.floats(0.0, 1e4),
)


def of_triangles(mesh: ClothMesh) -> ClothMesh:
    """A grid whose triangles carry what its springs did."""
    return dataclasses.replace(mesh, spring_weight=np.zeros_like(mesh.spring_weight))


def tensions(mesh: ClothMesh, material: Material, gradient: np.ndarray) -> np.ndarray:
    """(2, 2) N/m in x and y, per strain, of a sheet under the small displacement ``gradient`` (2, 2): the virial."""
    x = mesh.rest_position
    moved = x.copy()
    moved[:, :2] += 1e-6 * x[:, :2] @ gradient.T
    return -forces(mesh, material, moved)[:, :2].T @ x[:, :2] / mesh.vertex_area.sum() / 1e-6


def compliance_along(degrees: float, material: Material) -> float:
    """m/N: strain per tension of a strip cut at an angle to the warp (textbook: an orthotropic lamina)."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    warp, weft, shear = material.sheet_stiffness()
    stiffness = np.array([[warp, shear, 0.0], [shear, weft, 0.0], [0.0, 0.0, shear]])
    along = np.array([c * c, s * s, c * s])
    return float(along @ np.linalg.solve(stiffness, along))


@given(moduli)
def test_strips_of_the_sheet_are_as_stiff_as_measured(material):
    warp, weft, cross = material.sheet_stiffness()
    assert warp - cross**2 / weft == pytest.approx(material.stretch_warp, rel=1e-9)
    assert weft - cross**2 / warp == pytest.approx(material.stretch_weft, rel=1e-9)


@given(moduli)
def test_gauges_make_the_sheet_and_none_pushes(material):
    direction, modulus = gauges(material)
    assert (modulus >= 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-14)
    p, q = direction.T
    warp, weft, shear = material.sheet_stiffness()
    # On the strains of warp, weft and the angle between them.
    reading = np.stack([p * p, q * q, p * q], axis=1)
    expected = [[warp, shear, 0.0], [shear, weft, 0.0], [0.0, 0.0, shear]]
    np.testing.assert_allclose(reading.T @ (modulus[:, None] * reading), expected, atol=1e-9 * max(warp, weft))


@settings(max_examples=30)
@given(material=moduli, degrees=st.floats(0.0, 180.0), seed=st.integers(0, 50))
def test_affine_strain_makes_one_stress_and_no_force_inside(material, degrees, seed):
    """The patch test, whatever the mesh, the angle of the warp and the strain."""
    mesh = with_warp(irregular_sheet(0.7, 0.5, 5, seed=seed), degrees)
    gradient = np.random.default_rng(seed).normal(size=(2, 2))
    moved = mesh.rest_position.copy()
    moved[:, :2] += 1e-5 * moved[:, :2] @ gradient.T
    found = forces(mesh, material, moved)
    inside = ((mesh.rest_position[:, :2] > 1e-9) & (mesh.rest_position[:, :2] < np.array([0.7, 0.5]) - 1e-9)).all(
        axis=1
    )
    assert inside.sum() >= 8
    assert np.abs(found[inside]).max() < 1e-13 * sum(material.sheet_stiffness())
    assert np.abs(found).max() > 1e-8 * material.stretch_warp
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    threads = np.array([[c, -s], [s, c]])
    strain = threads.T @ (gradient + gradient.T) @ threads / 2
    warp, weft, shear = material.sheet_stiffness()
    stress = np.diag([warp * strain[0, 0] + shear * strain[1, 1], shear * strain[0, 0] + weft * strain[1, 1]])
    stress[0, 1] = stress[1, 0] = 2 * shear * strain[0, 1]
    size = np.abs(stress).max() + 1e-2 * (warp + weft)
    np.testing.assert_allclose(tensions(mesh, material, gradient), threads @ stress @ threads.T, atol=1e-3 * size)


@pytest.mark.parametrize("gradient", [[[1, 0], [0, 0]], [[0, 0], [0, 1]], [[0, 1], [0, 0]], [[1, 2], [-1, 3]]], ids=str)
@pytest.mark.parametrize("cells", [(5, 5), (9, 6)])
def test_springs_of_a_grid_are_the_same_sheet(gradient, cells):
    """Stress against that of triangles; warp along y."""
    grid = ClothMesh.grid(width=0.6, height=0.5, columns=cells[0], rows=cells[1])
    assert not grid.is_membrane(FABRIC) and of_triangles(grid).is_membrane(FABRIC)
    gradient = np.array(gradient, float)
    expected = tensions(of_triangles(grid), FABRIC, gradient)
    np.testing.assert_allclose(tensions(grid, FABRIC, gradient), expected, atol=0.02)


def pulled(mesh: ClothMesh, material: Material) -> float:
    """Tension per width and strain, N/m, of a strip pulled along x by its ends, free to get narrower."""
    x, hessian = mesh.rest_position, plane_hessian(mesh, material)
    low, high = (np.flatnonzero(np.abs(x[:, 0] - end) < 1e-9) for end in (x[:, 0].min(), x[:, 0].max()))
    fixed = np.concatenate([2 * low, 2 * high, 2 * low[:1] + 1])
    free = np.setdiff1d(np.arange(2 * len(x)), fixed)
    moved = np.zeros(2 * len(x))
    moved[2 * high] = 1.0
    moved[free] = np.linalg.solve(hessian[np.ix_(free, free)], -hessian[np.ix_(free, fixed)] @ moved[fixed])
    return float((hessian @ moved)[2 * high].sum() * np.ptp(x[:, 0]) / np.ptp(x[:, 1]))


@pytest.mark.parametrize("degrees", [0.0, 90.0, 180.0])
def test_a_strip_pulls_as_measured(degrees):
    mesh = with_warp(irregular_sheet(0.6, 0.3, 6), degrees)
    expected = FABRIC.stretch_weft if degrees == 90.0 else FABRIC.stretch_warp
    assert pulled(mesh, FABRIC) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("shape", [(7, 5), (11, 4)])
def test_a_strip_of_a_grid_pulls_as_measured(shape):
    grid = ClothMesh.grid(width=0.6, height=0.4, columns=shape[0], rows=shape[1])
    assert not grid.is_membrane(FABRIC)
    assert pulled(grid, FABRIC) == pytest.approx(FABRIC.stretch_weft, rel=1e-4)
    turned = dataclasses.replace(grid, rest_position=grid.rest_position[:, [1, 0, 2]])
    assert pulled(turned, FABRIC) == pytest.approx(FABRIC.stretch_warp, rel=1e-4)


@pytest.mark.parametrize("degrees", [20.0, 45.0, -60.0])
def test_a_strip_on_the_bias_is_that_of_a_lamina(degrees):
    """With the ends free to slip sideways but held straight, long strips come near it; the stress is even inside."""
    compliance = compliance_along(degrees, FABRIC)
    mesh = with_warp(irregular_sheet(1.2, 0.2, 24), degrees)
    assert pulled(mesh, FABRIC) == pytest.approx(1.0 / compliance, rel=0.02)


def test_long_cells_fall_back_on_triangles():
    """Diagonals of long cells run so close to the weft that they alone would be stiffer than it is."""
    grid = ClothMesh.grid(width=0.9, height=0.3, columns=7, rows=7)
    assert (FABRIC.stretch_weft - 9.0 * FABRIC.shear) < 0.0 and grid.is_membrane(FABRIC)
    assert (grid.spring_stiffness(FABRIC) == 0.0).all()
    assert pulled(grid, FABRIC) == pytest.approx(FABRIC.stretch_weft, rel=1e-4)
    assert not grid.is_membrane(Material(stretch_warp=900.0, stretch_weft=300.0, shear=20.0))


def test_threads_follow_the_surface():
    """Rolled up about the warp the cloth is the same; where the warp stands upright, threads have some direction."""
    flat = irregular_sheet(0.6, 0.4, 6)
    x, y, _ = flat.rest_position.T
    radius = 0.2
    rolled = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1)
    mesh = ClothMesh.from_triangles(rolled, flat.triangles)
    np.testing.assert_allclose(mesh.triangle_slope, flat.triangle_slope, atol=0.05 * np.abs(flat.triangle_slope).max())
    upright = ClothMesh.from_triangles(flat.rest_position, flat.triangles, warp=(0, 0, 1))
    length = twins.thread_lengths(upright.rest_position, upright.triangles, upright.triangle_slope)
    np.testing.assert_allclose(length, 1.0, rtol=1e-12)


def test_a_statically_loaded_membrane_is_a_linear_solve_away():
    """Small forces in the plane: where the cloth comes to rest is where scipy's solve of the small strains has it."""
    mesh = irregular_sheet(0.5, 0.4, 5)
    solver = ClothSolver(
        mesh,
        Material(stretch_warp=90.0, stretch_weft=30.0, shear=10.0, damping=5.0, bend=0.0),
        SolverConfig(air_density=0.0),
    )
    edge = np.flatnonzero(mesh.rest_position[:, 0] < 1e-9)
    solver.pin(edge)
    load = (0.3, 0.4, 0.0)
    state = last(solver, solver.initial_state(), Inputs(gravity=load), 6.0)
    moved = (state.position - mesh.rest_position)[:, :2]
    material = solver.material
    hessian = plane_hessian(mesh, material)
    count = len(hessian)
    free = np.setdiff1d(np.arange(count), np.concatenate([2 * edge, 2 * edge + 1]))
    force = (mesh.vertex_mass(material)[:, None] * np.array(load[:2])).ravel()
    expected = np.zeros(count)
    expected[free] = np.linalg.solve(hessian[np.ix_(free, free)], force[free])
    assert np.abs(expected).max() > 1e-4
    np.testing.assert_allclose(moved.ravel(), expected, atol=0.02 * np.abs(expected).max())
