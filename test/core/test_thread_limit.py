"""The stretch limit of triangles: warp and weft keep to it, shearing is free, what lasts is carried by tensions."""

from __future__ import annotations

import math

import numpy as np
import pytest
import twins

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.physics import stretch_limit
from cloth_core.physics.strain import vertex_strain
from cloth_core.physics.thread_limit import ThreadLimit
from cloth_core.validation.geometry import irregular_sheet
from cloth_core.validation.scenes import NO_GRAVITY, last


def test_sweeps_converge_to_the_limit_and_held_corners_stay():
    mesh = irregular_sheet(0.5, 0.4, 5)
    limit = ThreadLimit(mesh, Material(stretch_limit=1.05), mesh.vertex_mass(Material()))
    limit.hold(np.array([3, 8]))
    x = 1.2 * mesh.rest_position
    x[[3, 8]] = mesh.rest_position[[3, 8]]
    for number in range(600):
        excess = limit.sweep(x, number)
    np.testing.assert_array_equal(x[[3, 8]], mesh.rest_position[[3, 8]])
    length = twins.thread_lengths(x, mesh.triangles, mesh.triangle_slope)
    assert excess < 1e-3 and 1.04 < length.max() < 1.05 * 1.001


def test_tensions_grow_with_the_excess_fade_and_stay_below_the_strongest():
    mesh = irregular_sheet(0.5, 0.4, 5)
    limit = ThreadLimit(mesh, Material(stretch_limit=1.05), mesh.vertex_mass(Material()))
    tension, stiffness = limit.slack(), mesh.triangle_area[:, None] * np.array(Material().sheet_stiffness()[:2])
    stiffness *= stretch_limit.SHARE
    limit.carry(mesh.rest_position, 1.06 * mesh.rest_position, tension)
    np.testing.assert_allclose(tension, 0.01 * stiffness, rtol=1e-9)
    limit.carry(1.05 * mesh.rest_position, 1.05 * mesh.rest_position, tension)
    np.testing.assert_allclose(tension, stretch_limit.FADE * 0.01 * stiffness, rtol=1e-9)
    limit.carry(1.0502 * mesh.rest_position, 1.05 * mesh.rest_position, tension)
    left = stretch_limit.FADE**2 * 0.01 - stretch_limit.YIELDING * (0.0002 - stretch_limit.STEADY * 1.05)
    np.testing.assert_allclose(tension, left * stiffness, rtol=1e-9)
    for _ in range(300):
        limit.carry(mesh.rest_position, 3.0 * mesh.rest_position, tension)
    np.testing.assert_allclose(tension, stiffness)
    limit.carry(mesh.rest_position, 0.5 * mesh.rest_position, tension)
    np.testing.assert_array_equal(tension, np.maximum(tension, 0.0))


def heavy_strip(mesher) -> ClothSolver:
    """Soft fabric that would hang half as long again by its stiffness alone, and is limited to 1.08."""
    mesh = mesher()
    soft = Material(stretch_warp=10.0, stretch_weft=10.0, shear=1.0, stretch_limit=1.08, damping=3.0, bend=0.0)
    solver = ClothSolver(mesh, soft, SolverConfig(air_density=0.0))
    y = mesh.rest_position[:, 1]
    solver.pin(np.flatnonzero(y > y.max() - 1e-9))
    return solver


@pytest.mark.parametrize(
    "mesher",
    [lambda: ClothMesh.grid(width=0.3, height=0.9, columns=7, rows=19), lambda: irregular_sheet(0.3, 0.9, 6)],
    ids=["grid", "irregular"],
)
def test_a_soft_cloth_hangs_at_its_limit_on_any_mesh(mesher):
    """Tension at the top 0.2 g 0.9 = 1.77 N/m: strain 0.18. It lengthens by 0.08, less where little hangs on it."""
    solver = heavy_strip(mesher)
    start = solver.initial_state()
    down = start.position[:, [0, 2, 1]] - [0.0, 0.0, start.position[:, 1].max()]
    state = last(solver, State(np.ascontiguousarray(down), np.zeros_like(down)), Inputs(), 6.0)
    slack = 10.0 * 0.08 / (0.2 * 9.81)  # m of cloth, from below, that is short of the limit
    expected = 0.08 * (0.9 - slack) + 0.08 * slack / 2
    assert -state.position[:, 2].min() - 0.9 == pytest.approx(expected, rel=0.03)


def test_a_trellis_shears_without_limit():
    """Threads turned against each other by 40 degrees keep their length; edges across them get longer, unlimited."""
    mesh = irregular_sheet(0.5, 0.4, 6)
    turn = math.radians(20.0)
    sheared = mesh.rest_position @ np.array(
        [[math.cos(turn), math.sin(turn), 0], [math.sin(turn), math.cos(turn), 0], [0, 0, 1]]
    )
    i, j = mesh.spring_vertex.T
    stretch = np.linalg.norm(sheared[i] - sheared[j], axis=1) / mesh.spring_rest
    assert stretch.max() > 1.2
    assert (stretch / mesh.spring_bias).max() < 1.0 + 1e-12
    np.testing.assert_allclose(vertex_strain(mesh, sheared), 0.0, atol=1e-12)
    limit = ThreadLimit(mesh, Material(stretch_limit=1.001), mesh.vertex_mass(Material()))
    assert limit.sweep(sheared.copy(), 0) == 0.0
    solver = ClothSolver(mesh, Material(shear=0.0), SolverConfig())
    after = solver.step(State(np.ascontiguousarray(sheared), np.zeros_like(sheared)), NO_GRAVITY)
    assert np.abs(after.position - sheared).max() < 1e-6
    assert solver.report.restrained == 0 and solver.report.max_stretch <= 1.0 + 1e-9
