"""Wind: force by area, gusts by seed, speed by cap."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import ClothMesh, Wind
from cloth_core.kernels import surface
from cloth_core.physics.drag import capped, flow_at
from cloth_core.validation.geometry import irregular_sheet

CAP = 40.0
finite = st.floats(allow_nan=False, allow_infinity=False)


def flow(wind: Wind, position: np.ndarray, time: float = 0.0) -> np.ndarray:
    field = np.full_like(position, np.nan)
    flow_at(position, wind, time, CAP, field)
    return field


def total_force(mesh: ClothMesh, wind: np.ndarray) -> np.ndarray:
    vectors, force = np.empty((mesh.vertex_count, 3)), np.zeros((mesh.vertex_count, 3))
    surface.area_vectors(mesh.rest_position, mesh.triangles, vectors)
    surface.add_drag_of_flow(np.tile(wind, (mesh.vertex_count, 1)), vectors, mesh.vertex_area, 0.72, force)
    return force.sum(axis=0)


@pytest.mark.parametrize(
    "mesh",
    [
        ClothMesh.grid(width=0.9, height=0.5, columns=3, rows=3),
        ClothMesh.grid(width=0.9, height=0.5, columns=31, rows=19),
        irregular_sheet(0.9, 0.5, 7),
        irregular_sheet(0.9, 0.5, 25),
    ],
)
def test_total_force_is_that_of_the_sheet_however_fine(mesh):
    """Eq. (5) per area: C A |w| w_n along the normal."""
    wind = np.array([3.0, -1.0, 2.0])
    expected = 0.72 * 0.9 * 0.5 * np.linalg.norm(wind) * 2.0
    np.testing.assert_allclose(total_force(mesh, wind), [0.0, 0.0, expected], rtol=1e-12, atol=1e-12)


def test_a_stretched_sheet_catches_no_more_wind_than_at_rest():
    """Else wind would stretch it, and the larger it got the more it would be stretched."""
    mesh, wind = ClothMesh.grid(width=1.0, height=1.0, columns=4, rows=4), np.tile([0.0, 0.0, 3.0], (16, 1))
    forces = []
    for scale in (1.0, 5.0, 0.5):
        vectors, force = np.empty((16, 3)), np.zeros((16, 3))
        surface.area_vectors(scale * mesh.rest_position, mesh.triangles, vectors)
        surface.add_drag_of_flow(wind, vectors, mesh.vertex_area, 0.72, force)
        forces.append(force.sum(axis=0)[2])
    np.testing.assert_allclose(np.array(forces) / forces[0], [1.0, 1.0, 0.25], rtol=1e-12)


def test_wind_along_the_sheet_does_nothing():
    np.testing.assert_allclose(
        total_force(ClothMesh.grid(width=1, height=1, columns=4, rows=4), [5.0, 2.0, 0.0]), 0, atol=1e-15
    )


POINTS = np.random.default_rng(0).uniform(-3, 3, (300, 3))


def test_without_gusts_the_flow_is_the_wind():
    np.testing.assert_array_equal(flow(Wind(velocity=(1.0, 2.0, 3.0)), POINTS), np.tile([1.0, 2.0, 3.0], (300, 1)))


def test_gusts_follow_from_the_seed():
    gusty = dict(velocity=(5.0, 0.0, 0.0), gust_intensity=0.4)
    same = [flow(Wind(**gusty, gust_seed=3), POINTS, 1.7) for _ in range(2)]
    np.testing.assert_array_equal(*same)
    assert np.abs(same[0] - flow(Wind(**gusty, gust_seed=4), POINTS, 1.7)).max() > 0.5


@pytest.mark.parametrize("seed", range(1, 6))
def test_rms_of_the_gusts_is_the_intensity(seed):
    """All three directions together, over many places and times."""
    wind = Wind(velocity=(3.0, 4.0, 0.0), gust_intensity=0.3, gust_seed=seed)
    gusts = np.concatenate([flow(wind, 20 * POINTS, 7.3 * n) - wind.velocity for n in range(60)])
    assert np.sqrt((gusts**2).sum(axis=1).mean()) == pytest.approx(0.3 * 5.0, rel=0.02)
    np.testing.assert_allclose(gusts.mean(axis=0), 0, atol=0.05)


def test_gusts_are_smooth_in_time_and_place():
    wind = Wind(velocity=(5.0, 0.0, 0.0), gust_intensity=0.5, gust_time=2.0, gust_length=3.0)
    base = flow(wind, POINTS, 1.0)
    later, aside = flow(wind, POINTS, 1.002), flow(wind, POINTS + np.array([0.0, 0.01, 0.0]), 1.0)
    for near in (later, aside):
        assert 1e-5 < np.abs(near - base).max() < 0.25


def test_gusts_drift_with_the_mean_wind():
    """Taylor: with slow gusts, what is here now is downwind a moment later."""
    wind = Wind(velocity=(5.0, 0.0, 0.0), gust_intensity=0.5, gust_time=60.0)
    here, downwind = flow(wind, POINTS, 0.0), flow(wind, POINTS + np.array([0.5, 0.0, 0.0]), 0.1)
    np.testing.assert_allclose(downwind, here, atol=0.1)
    assert np.abs(flow(wind, POINTS, 0.1) - here).max() > 0.5


def test_wind_above_the_cap_is_capped_and_says_so():
    field = np.empty_like(POINTS)
    assert flow_at(POINTS, Wind(velocity=(1e6, 0.0, 0.0)), 0.0, CAP, field)
    np.testing.assert_allclose(field, np.tile([CAP, 0.0, 0.0], (300, 1)))
    assert flow_at(POINTS, Wind(velocity=(0.0, 30.0, -40.0)), 0.0, CAP, field)
    np.testing.assert_allclose(field, np.tile([0.0, 24.0, -32.0], (300, 1)))
    assert not flow_at(POINTS, Wind(velocity=(CAP, 0.0, 0.0)), 0.0, CAP, field)
    assert flow_at(POINTS, Wind(velocity=(1e308, -1e308, 1e308)), 0.0, CAP, field)
    np.testing.assert_allclose(field, np.tile(np.array([CAP, -CAP, CAP]) / 3**0.5, (300, 1)))


@given(st.tuples(finite, finite, finite), st.floats(min_value=0.1, max_value=200.0))
def test_a_capped_wind_keeps_its_direction_and_is_never_faster_than_the_cap(velocity, limit):
    slow, was_capped = capped(velocity, limit)
    speed = math.hypot(*(c / 4 for c in velocity)) * 4
    if speed <= limit * (1 - 1e-12):
        assert (slow, was_capped) == (velocity, False)
    if was_capped:
        assert math.hypot(*slow) == pytest.approx(limit, rel=1e-12)
        assert all(math.copysign(1.0, a) == math.copysign(1.0, b) for a, b in zip(velocity, slow, strict=True))
        largest = max(abs(c) for c in velocity)
        assert [c / largest for c in velocity] == pytest.approx([c / max(map(abs, slow)) for c in slow])
    assert capped(slow, limit) == (slow, False)
