"""Readings of curvature: the same plate on any triangulation, nothing for what is flat, turned or moved."""

from __future__ import annotations

import math

import numpy as np
import pytest
import twins
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from cloth_core import ClothMesh, Material
from cloth_core.validation.geometry import irregular_sheet

PLATE = Material(bend=1.0)
CURVED = {
    "along x": (1.0, 0.0, 0.0),
    "along y": (0.0, 0.0, 1.0),
    "on the bias": (0.5, 0.5, 0.5),
    "twisted": (0.0, 1.0, 0.0),
    "a saddle": (1.0, 0.0, -1.0),
    "a bowl": (1.0, 0.0, 1.0),
}
"""Second derivatives xx, xy and yy of a height."""
BOUNDED = settings(max_examples=20, deadline=None)


def height(mesh: ClothMesh, xx: float, xy: float, yy: float) -> np.ndarray:
    x, y, _ = mesh.rest_position.T
    return 0.5 * xx * x * x + xy * x * y + 0.5 * yy * y * y


def energy_over_plate(mesh: ClothMesh, curved: str) -> float:
    """Energy of a constant curvature, over that of a plate of Poisson ratio 0: |H|^2 / 2 per area."""
    xx, xy, yy = CURVED[curved]
    w = height(mesh, xx, xy, yy)
    plate = 0.5 * (xx * xx + 2 * xy * xy + yy * yy) * mesh.vertex_area.sum()
    return float(0.5 * w @ twins.bending_of(mesh, PLATE) @ w / plate)


def hexagons(rings: int) -> ClothMesh:
    """Equilateral triangles around the origin, ``rings`` of them."""
    index = [(i, j) for i in range(-rings, rings + 1) for j in range(-rings, rings + 1) if abs(i + j) <= rings]
    number = {place: n for n, place in enumerate(index)}
    place = np.array([[0.1 * (i + 0.5 * j), 0.1 * math.sqrt(0.75) * j, 0.0] for i, j in index])
    corners = [((i, j), (i + 1, j), (i, j + 1)) for i, j in index] + [
        ((i, j), (i, j + 1), (i - 1, j + 1)) for i, j in index
    ]
    triangles = [[number[p] for p in corner] for corner in corners if all(p in number for p in corner)]
    return ClothMesh.from_triangles(place, np.array(triangles))


@pytest.mark.parametrize("curved", CURVED)
@pytest.mark.parametrize("shape", [(3, 3), (4, 9), (12, 7)])
def test_a_grid_is_the_plate(curved, shape):
    grid = ClothMesh.grid(width=0.5, height=0.7, columns=shape[0], rows=shape[1])
    assert energy_over_plate(grid, curved) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("curved", CURVED)
def test_equilateral_triangles_are_the_plate(curved):
    assert energy_over_plate(hexagons(5), curved) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("curved", CURVED)
@pytest.mark.parametrize("seed", [0, 1])
def test_irregular_triangles_are_nearly_the_plate(curved, seed):
    """Their readings scatter, and the square of what scatters adds to the energy, to that of twist above all."""
    most = 1.15 if curved == "twisted" else 1.09
    assert 0.99 < energy_over_plate(irregular_sheet(1.0, 0.6, 20, seed=seed), curved) < most


@pytest.mark.parametrize("curved", CURVED)
@pytest.mark.parametrize(
    "mesh", [ClothMesh.grid(width=1.0, height=0.8, columns=11, rows=9), hexagons(5)], ids=["grid", "hexagons"]
)
def test_constant_curvature_is_in_equilibrium_inside(curved, mesh):
    """No vertex that is more than two rings from the border feels a force."""
    force = twins.bending_of(mesh, PLATE) @ height(mesh, *CURVED[curved])
    x, y, _ = np.abs(mesh.rest_position).T
    inside = (x < 0.25) & (y < 0.15) if mesh.uv is not None else np.hypot(x, y) < 0.11
    assert inside.sum() >= 7
    assert np.abs(force[inside]).max() < 1e-9 * max(np.abs(force).max(), 1.0)


@BOUNDED
@given(st.integers(0, 1000), st.integers(2, 9), st.integers(2, 6))
def test_only_what_is_flat_costs_nothing(seed, cells, across):
    """The energy vanishes for heights that are affine, and for no others: three of them, ears and all."""
    mesh = irregular_sheet(0.1 * cells, 0.1 * across, cells, seed=seed)
    q = twins.bending_of(mesh, PLATE)
    values = np.linalg.eigvalsh(q)
    assert (np.abs(values[:3]) < 1e-9 * values[-1]).all() and values[3] > 1e-4 * values[-1]
    assert np.abs(q @ mesh.rest_position).max() < 1e-9 * values[-1]


@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (2, 7), (3, 3), (5, 2)])
def test_narrow_grids_and_their_triangles_bend_too(columns, rows):
    grid = ClothMesh.grid(width=0.1 * columns, height=0.1 * rows, columns=columns, rows=rows)
    for mesh in (grid, ClothMesh.from_triangles(grid.rest_position, grid.triangles)):
        values = np.linalg.eigvalsh(twins.bending_of(mesh, PLATE))
        assert (np.abs(values[:3]) < 1e-9 * values[-1]).all() and values[3] > 1e-3 * values[-1]


@BOUNDED
@given(st.integers(0, 1000))
def test_numbering_and_placing_do_not_matter(seed):
    mesh, random = irregular_sheet(0.6, 0.4, 6, seed=3), np.random.default_rng(seed)
    number = random.permutation(mesh.vertex_count)
    turned = np.linalg.qr(random.normal(size=(3, 3)))[0]
    place = np.empty_like(mesh.rest_position)
    place[number] = mesh.rest_position @ turned.T + random.normal(size=3)
    triangles = random.permutation(number[mesh.triangles])
    triangles = np.stack(
        [np.roll(t, k) for t, k in zip(triangles, random.integers(3, size=len(triangles)), strict=True)]
    )
    other = twins.bending_of(ClothMesh.from_triangles(place, triangles), PLATE)
    q = twins.bending_of(mesh, PLATE)
    np.testing.assert_allclose(other[np.ix_(number, number)], q, atol=1e-9 * np.abs(q).max())


def test_a_sheet_that_is_loaded_rolled_up_is_the_flat_one():
    """What counts is the shape within the surface: cloth has no curvature of its own."""
    flat, radius = irregular_sheet(0.6, 0.3, 24), 0.15
    x, y, _ = flat.rest_position.T
    rolled = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1)
    q = twins.bending_of(flat, PLATE)
    other = twins.bending_of(ClothMesh.from_triangles(rolled, flat.triangles), PLATE)
    np.testing.assert_allclose(other, q, atol=0.005 * np.abs(q).max())
    energy = 0.5 * float(np.sum(rolled * (other @ rolled)))
    assert energy == pytest.approx(0.5 / radius**2 * 0.6 * 0.3, rel=0.03)


def test_fans_that_touch_at_their_middle_are_read_by_hinges():
    """Two discs that share the vertex in their middle: it is no inner vertex of one surface."""
    angle = np.arange(6) * math.pi / 3
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    place = np.concatenate([[[0, 0, 0]], ring, ring[:, [0, 2, 1]] * [1, 1, -1]])
    triangles = [[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)] + [[0, 7 + k, 7 + (k + 1) % 6] for k in range(6)]
    mesh = ClothMesh.from_triangles(place, triangles)
    assert len(mesh.curvature_start) - 1 == 12
    assert np.isfinite(mesh.curvature_weight).all()


@pytest.mark.parametrize(
    "mesh",
    [
        ClothMesh.grid(width=0.6, height=0.15, columns=25, rows=7),
        ClothMesh.grid(width=0.6, height=0.15, columns=49, rows=13),
        irregular_sheet(0.6, 0.15, 24, seed=1),
        irregular_sheet(0.6, 0.15, 24, seed=2),
        irregular_sheet(0.6, 0.15, 40),
    ],
    ids=["coarse", "fine", "irregular 1", "irregular 2", "irregular, fine"],
)
def test_the_lowest_mode_of_a_free_strip_is_that_of_a_beam(mesh):
    """w = 22.373 sqrt(B / sigma) / L^2 for a Poisson ratio of 0."""
    material = Material(bend=1e-3)
    beam = 22.373 * math.sqrt(material.bend / material.areal_density) / 0.6**2
    mass, x = mesh.vertex_mass(material), mesh.rest_position[:, 0]
    square, shapes = eigh(twins.bending_of(mesh, material), np.diag(mass))
    rigid = np.column_stack([np.ones(len(x)), x])
    weight = np.sqrt(mass)
    parabola = x**2 - rigid @ np.linalg.lstsq(rigid * weight[:, None], x**2 * weight, rcond=None)[0]
    share = (mass * parabola @ shapes) ** 2 / (mass @ parabola**2)
    assert math.sqrt(square[np.flatnonzero(share > 0.8)[0]]) == pytest.approx(beam, rel=0.025)
