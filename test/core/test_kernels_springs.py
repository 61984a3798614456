"""The spring kernels against their slow twins."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from hypothesis import given
from hypothesis import strategies as st

from cloth_core.kernels import curvature, springs

SEEDS = st.integers(0, 10**6)


def random_net(seed: int):
    """Vertices, velocities, springs with rest lengths and stiffnesses; two vertices coincide."""
    random = np.random.default_rng(seed)
    count, links = random.integers(3, 9), random.integers(2, 20)
    x, v = random.normal(size=(2, count, 3))
    x[1] = x[0]
    pairs = np.array([random.choice(count, 2, replace=False) for _ in range(links - 1)] + [[0, 1]], np.int32)
    return random, x, v, pairs, random.uniform(0.1, 2.0, links), random.uniform(0.0, 500.0, links)


@given(SEEDS, st.sampled_from([0.0, 0.02]))
def test_spring_forces_are_those_of_figure_4(seed, dt):
    random, x, v, pairs, rest, k = random_net(seed)
    before = random.normal(size=x.shape)
    force = before.copy()
    springs.add_spring_forces(x, v, pairs, rest, k, dt, force)
    np.testing.assert_allclose(force - before, twins.spring_forces(x, v, pairs, rest, k, dt), atol=1e-11)


def test_spring_forces_are_the_slope_of_the_energy():
    _, x, v, pairs, rest, k = random_net(4)
    pairs, rest, k = pairs[:-1], rest[:-1], k[:-1]
    x[1] += 0.5
    energy = lambda y: 0.5 * np.sum(k * (np.linalg.norm(y[pairs[:, 0]] - y[pairs[:, 1]], axis=1) - rest) ** 2)  # noqa: E731
    force = np.zeros_like(x)
    springs.add_spring_forces(x, v, pairs, rest, k, 0.0, force)
    for i, a in np.ndindex(*x.shape):
        step = np.zeros_like(x)
        step[i, a] = 1e-6
        slope = (energy(x + step) - energy(x - step)) / 2e-6
        assert force[i, a] == pytest.approx(-slope, abs=1e-5)


@given(SEEDS, st.sampled_from([0.0, 0.7]), st.sampled_from([0, 1, 4]))
def test_local_step_pulls_each_spring_along_itself(seed, viscosity, more_shares):
    random, x, start, pairs, rest, k = random_net(seed)
    tension = random.uniform(0.0, 50.0, len(pairs)) * (random.random(len(pairs)) < 0.5)
    before = random.normal(size=x.shape)
    right_side, apart = before.copy(), np.full((more_shares, *x.shape), np.nan)
    springs.add_elastic_impulses(x, start, pairs, rest, k, tension, viscosity, 0.37, right_side, apart)
    expected = 0.37 * twins.elastic_forces(x, start, pairs, rest, k, tension, viscosity)
    np.testing.assert_allclose(right_side - before, expected, atol=1e-11)


@given(SEEDS)
def test_the_local_step_carries_no_momentum_and_no_torque(seed):
    _, x, start, pairs, rest, k = random_net(seed)
    impulse = np.zeros_like(x)
    springs.add_elastic_impulses(x, start, pairs, rest, k, rest, 0.7, 1.0, impulse, np.empty((1, *x.shape)))
    size = np.abs(impulse).max()
    np.testing.assert_allclose(impulse.sum(axis=0), 0.0, atol=1e-13 * (1 + size))
    np.testing.assert_allclose(np.cross(x, impulse).sum(axis=0), 0.0, atol=1e-12 * (1 + size))


@given(SEEDS)
def test_tensions_fade_and_grow_with_the_excess_between_none_and_the_strongest(seed):
    random, x, start, pairs, rest, k = random_net(seed)
    taut = np.flatnonzero(random.random(len(pairs)) < 0.7)
    longest, strongest = 1.05 * rest, 2.0 * k * rest
    tension = random.uniform(0.0, 300.0, len(pairs)) * (random.random(len(pairs)) < 0.5)
    expected = twins.carried(start, x, taut, pairs, longest, k, strongest, 0.9, 3.0, 0.1, tension)
    springs.carry_limit(start, x, taut, pairs, longest, k, strongest, 0.9, 3.0, 0.1, tension)
    np.testing.assert_allclose(tension, expected, atol=1e-11)


@given(SEEDS)
def test_taut_are_the_limited_springs_that_are_long_or_under_tension(seed):
    random, x, _, pairs, rest, _ = random_net(seed)
    limited = np.flatnonzero(random.random(len(pairs)) < 0.7)
    tension = 1.0 * (random.random(len(pairs)) < 0.2)
    taut = np.full(len(limited), -1)
    count = springs.find_taut(x, limited, pairs, rest, tension, taut)
    stretch = twins.stretches(x, pairs, rest)
    assert taut[:count].tolist() == [s for s in limited if stretch[s] > 1.0 or tension[s] > 0.0]
    assert springs.any_longer(x, limited, pairs, rest) == any(stretch[s] > 1.0 for s in limited)


@given(SEEDS, st.booleans())
def test_shortening_follows_section_3_3_2(seed, backward):
    random, x, _, pairs, rest, _ = random_net(seed)
    inverse_mass = random.uniform(0.5, 5.0, len(x)) * (random.random(len(x)) > 0.3)
    taut = np.flatnonzero(random.random(len(pairs)) < 0.7)
    expected, worst = twins.shorten(x, pairs[taut], rest[taut], inverse_mass, backward)
    assert springs.shorten_springs(x, taut, pairs, rest, inverse_mass, backward) == pytest.approx(worst, abs=1e-12)
    np.testing.assert_allclose(x, expected, atol=1e-12)


@given(SEEDS)
def test_overlong_springs_are_calmed_one_after_the_other(seed):
    random, x, v, pairs, rest, _ = random_net(seed)
    inverse_mass = random.uniform(0.5, 5.0, len(x)) * (random.random(len(x)) > 0.3)
    taut = np.flatnonzero(random.random(len(pairs)) < 0.7)
    lag = random.normal(size=x.shape)
    expected, left = twins.calmed(x, v, lag, taut, pairs, rest, inverse_mass, 0.2)
    springs.calm_overlong(x, v, lag, taut, pairs, rest, inverse_mass, 0.2)
    np.testing.assert_allclose(v, expected, atol=1e-12)
    np.testing.assert_array_equal(lag, left)


@given(SEEDS)
def test_stretch_and_strain_are_read_off_the_chosen_springs(seed):
    random, x, _, pairs, rest, _ = random_net(seed)
    rest[0] = 0.0
    chosen = random.random(len(rest)) < 0.6
    used = chosen & (rest > 0)
    expected = twins.stretches(x, pairs[used], rest[used]).max() if used.any() else 1.0
    assert springs.largest_stretch(x, pairs, rest, chosen) == pytest.approx(expected, rel=1e-13)
    strain = np.full(len(x), np.nan)
    springs.vertex_strain(x, pairs, rest, chosen, strain)
    np.testing.assert_allclose(strain, twins.strain_at_vertices(x, pairs, rest, chosen), atol=1e-13)


@given(SEEDS, st.sampled_from([0.0, 0.02]))
def test_bending_forces_are_minus_q_times_x(seed, dt):
    random, x, v, *_ = random_net(seed)
    start = np.array([0, 3, 3, 7, 12], np.int32)
    vertex = random.integers(len(x), size=12).astype(np.int32)
    weight = random.normal(size=12)
    force = np.ones_like(x)
    curvature.add_bending_forces(x, v, start, vertex, weight, 0.7, dt, force)
    expected = -twins.bending_matrix(len(x), start, vertex, weight, 0.7) @ (x + dt * v)
    np.testing.assert_allclose(force - 1.0, expected, atol=1e-12)
