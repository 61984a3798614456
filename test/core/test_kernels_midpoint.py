"""The kernels of the midpoint rule against numpy, and the rule that they make together."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from cloth_core.kernels import midpoint

SEEDS = st.integers(0, 10**6)


def drawn(seed: int):
    """Positions, velocities, lags, accelerations, forces and bending (V, 3); masses (V,); a substep."""
    random = np.random.default_rng(seed)
    arrays = random.normal(size=(6, random.integers(1, 9), 3))
    return *arrays, random.uniform(0.1, 2.0, arrays.shape[1]), random.uniform(1e-3, 0.1)


@given(SEEDS)
def test_each_kernel_is_its_formula(seed):
    x, v, lag, a, force, bending, mass, h = drawn(seed)
    out, gravity = np.full_like(x, np.nan), np.array([0.3, -0.2, -9.81])
    midpoint.predict(x, v, lag, force, mass, bending, gravity, h, out)
    acceleration = force / mass[:, None] + gravity + bending
    np.testing.assert_allclose(out, x + 0.5 * h * (v + lag) + 0.25 * h * h * acceleration, atol=1e-14)
    midpoint.displacement_velocity(x, v, 0.9 / h, out)
    np.testing.assert_allclose(out, 0.9 * (v - x) / h, rtol=1e-12, atol=1e-12)
    before = force.copy()
    midpoint.add_inertia(mass, v, x, force)
    np.testing.assert_allclose(force - before, mass[:, None] * (v - x), atol=1e-13)
    start, middle, before = x.copy(), v.copy(), lag.copy()
    midpoint.extrapolate(start, middle, out)
    np.testing.assert_allclose(out, 2 * v - x, atol=1e-13)
    met = np.random.default_rng(seed + 1).normal(size=x.shape)
    midpoint.renew_lag(start, a, middle, met, h, lag)
    np.testing.assert_allclose(lag, (2 * (v - x) - met) / h - a - before, rtol=1e-12, atol=1e-10)
    np.testing.assert_array_equal(start, x)


@given(SEEDS)
def test_a_lag_is_bounded_but_for_what_gravity_has_in_it(seed):
    _, _, lag, _, _, _, most, h = drawn(seed)
    gravity = np.array([0.3, -0.2, -9.81])
    inner = lag - 0.5 * h * gravity
    speed = np.linalg.norm(inner, axis=1)
    expected = 0.5 * h * gravity + inner * np.minimum(1.0, most / speed)[:, None]
    midpoint.bound_lag(gravity, h, most, lag)
    np.testing.assert_allclose(lag, expected, atol=1e-12)


@given(SEEDS)
def test_constant_acceleration_is_followed_exactly(seed):
    """Twenty substeps of inertia alone: positions on the parabola, the mean velocity and the lag as they must be."""
    x, v, lag, a, force, _, mass, h = drawn(seed)
    start, begun, gravity = x.copy(), v + lag, np.zeros(3)
    force[:] = 0.0
    for _ in range(20):
        middle, end = np.empty_like(x), np.empty_like(x)
        midpoint.predict(x, v, lag, force, mass, a, gravity, h, middle)
        midpoint.extrapolate(x, middle, end)
        midpoint.renew_lag(x, v, middle, np.zeros_like(x), h, lag)
        midpoint.displacement_velocity(x, end, 1.0 / h, v)
        x = end
    time = 20 * h
    np.testing.assert_allclose(x, start + time * begun + 0.5 * time**2 * a, atol=1e-11)
    np.testing.assert_allclose(v, begun + (time - 0.5 * h) * a, atol=1e-9)
    np.testing.assert_allclose(lag, 0.5 * h * a, atol=1e-9)
