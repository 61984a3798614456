"""Kernels of the membrane against their twins, and against the energy that the forces follow from."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from sheets import with_warp

from cloth_core import Material
from cloth_core.kernels import membrane as kernels
from cloth_core.linear import stretch_matrix
from cloth_core.linear.gauges import gauges
from cloth_core.physics.membrane import Membrane
from cloth_core.physics.strain import vertex_strain
from cloth_core.validation.geometry import irregular_sheet

FABRIC = Material(stretch_warp=900.0, stretch_weft=300.0, shear=50.0)


def cloud(seed: int) -> tuple[np.ndarray, ...]:
    """A crumpled sheet: triangles, slopes, areas, gauges, positions, where they came from."""
    mesh = with_warp(irregular_sheet(0.5, 0.4, 4, seed=seed), 30.0)
    random = np.random.default_rng(seed)
    x = mesh.rest_position + random.normal(0, 0.05, mesh.rest_position.shape)
    direction, modulus = gauges(FABRIC)
    before = x + random.normal(0, 0.01, x.shape)
    return mesh.triangles, mesh.triangle_slope, mesh.triangle_area, direction, modulus, x, before


@pytest.mark.parametrize("seed", range(3))
def test_forces_are_minus_the_slope_of_the_energy(seed):
    triangles, slope, area, direction, modulus, x, _ = cloud(seed)
    found = np.zeros_like(x)
    kernels.add_membrane_forces(x, 0 * x, triangles, slope, area, direction, modulus, 0.0, found)
    for v, a in ((0, 0), (7, 1), (13, 2), (17, 2)):
        nudged = [x.copy(), x.copy()]
        nudged[0][v, a] -= 1e-6
        nudged[1][v, a] += 1e-6
        low, high = (twins.membrane_energy(n, triangles, slope, area, direction, modulus) for n in nudged)
        assert found[v, a] == pytest.approx(-(high - low) / 2e-6, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("viscosity", [0.0, 0.7])
@pytest.mark.parametrize("more_shares", [0, 1, 4])
def test_the_local_step_is_the_twin(seed, viscosity, more_shares):
    triangles, slope, area, direction, modulus, x, start = cloud(seed)
    tension = np.random.default_rng(seed).uniform(0, 2, (len(triangles), 2))
    before = np.random.default_rng(9).normal(size=x.shape)
    found, apart = before.copy(), np.full((more_shares, *x.shape), np.nan)
    kernels.add_membrane_impulses(
        x, start, triangles, slope, area, direction, modulus, tension, viscosity, 0.37, found, apart
    )
    expected = twins.membrane_forces(x, start, triangles, slope, area, direction, modulus, tension, viscosity)
    np.testing.assert_allclose(found - before, 0.37 * expected, atol=1e-10)


def test_viscous_forces_are_the_matrix_times_velocity():
    """dt H v of Fig. 4, H being what W is made of."""
    mesh = irregular_sheet(0.5, 0.4, 4)
    x, v = mesh.rest_position, np.random.default_rng(1).normal(size=mesh.rest_position.shape)
    found = np.zeros_like(x)
    Membrane(mesh, FABRIC).add_forces(x, v, 0.03, found)
    np.testing.assert_allclose(found, -0.03 * stretch_matrix(mesh, FABRIC) @ v, atol=1e-10)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("backward", [False, True])
def test_threads_shorten_as_the_twin_and_keep_the_centre(seed, backward):
    triangles, slope, _, _, _, x, _ = cloud(seed)
    inverse_mass = np.random.default_rng(seed).uniform(0.5, 2.0, len(x))
    before, taut = x.copy(), np.flatnonzero(np.random.default_rng(seed + 7).random(2 * len(triangles)) < 0.7)
    expected, worst = twins.shorten_threads(x, taut, triangles, slope, 1.02, inverse_mass, backward)
    found = kernels.shorten_threads(x, taut, triangles, slope, 1.02, inverse_mass, backward)
    assert found == pytest.approx(worst, abs=1e-12)
    np.testing.assert_allclose(x, expected, atol=1e-13)
    np.testing.assert_allclose((x - before).T @ (1 / inverse_mass), 0.0, atol=1e-13)
    assert worst > 0.1


@pytest.mark.parametrize("seed", range(3))
def test_strain_is_that_of_the_longest_thread_at_a_vertex(seed):
    triangles, _, _, _, _, x, _ = cloud(seed)
    mesh = with_warp(irregular_sheet(0.5, 0.4, 4, seed=seed), 30.0)
    longest = twins.thread_lengths(x, triangles, mesh.triangle_slope).max(axis=1) - 1.0
    expected = [longest[(triangles == v).any(axis=1)].max() for v in range(len(x))]
    np.testing.assert_allclose(vertex_strain(mesh, x), expected, atol=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_taut_are_the_threads_that_are_long_or_under_tension(seed):
    triangles, slope, _, _, _, x, _ = cloud(seed)
    tension = 1.0 * (np.random.default_rng(seed).random((len(triangles), 2)) < 0.2)
    taut = np.full(tension.size, -1)
    count = kernels.find_taut_threads(x, triangles, slope, 1.02, tension, taut)
    expected = np.flatnonzero((twins.thread_lengths(x, triangles, slope) > 1.02) | (tension > 0.0))
    np.testing.assert_array_equal(taut[:count], expected)
    assert 0 < count < tension.size


@pytest.mark.parametrize("seed", range(3))
def test_overlong_threads_are_calmed_and_the_momentum_stays(seed):
    triangles, slope, _, _, _, x, _ = cloud(seed)
    random = np.random.default_rng(seed)
    inverse_mass, taut = random.uniform(0.5, 2.0, len(x)), np.array([2 * (len(triangles) // 2)])
    v, lag = random.normal(size=(2, *x.shape))
    corners, weight = triangles[taut[0] // 2], slope[taut[0] // 2, :, 0]
    axis = weight @ x[corners]
    longest = 0.9 * np.linalg.norm(axis)
    v[corners] -= np.outer(weight, axis) * (1.0 + weight @ v[corners] @ axis) / (weight @ weight)  # it shortens
    before, lag_before = v.copy(), lag.copy()
    kernels.calm_overlong_threads(x, v, lag, taut, triangles, slope, longest, inverse_mass, 0.2)
    assert -(weight @ v[corners] @ axis) / (axis @ axis) == pytest.approx(0.2)
    np.testing.assert_allclose((v - before).T @ (1 / inverse_mass), 0.0, atol=1e-12)
    rest = np.setdiff1d(np.arange(len(x)), corners)
    np.testing.assert_array_equal(v[rest], before[rest])
    np.testing.assert_array_equal(lag[rest], lag_before[rest])
    assert not lag[corners].any()
