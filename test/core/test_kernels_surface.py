"""Area vectors, drag and gusts against their slow twins."""

from __future__ import annotations

import numpy as np
import twins
from hypothesis import given
from hypothesis import strategies as st

from cloth_core.kernels import surface

SEEDS = st.integers(0, 10**6)


def random_surface(seed: int):
    """Random vertices, the last one in no triangle; triangles, one of them without area."""
    random = np.random.default_rng(seed)
    count = random.integers(4, 10)
    x = random.normal(size=(count, 3))
    triangles = np.array([random.choice(count - 1, 3, replace=False) for _ in range(8)], np.int32)
    x[triangles[0, 2]] = 2 * x[triangles[0, 1]] - x[triangles[0, 0]]
    return random, x, triangles


@given(SEEDS)
def test_area_vectors_share_each_triangle_in_thirds(seed):
    _, x, triangles = random_surface(seed)
    vectors = np.full_like(x, np.nan)
    surface.area_vectors(x, triangles, vectors)
    np.testing.assert_allclose(vectors, twins.area_vectors(x, triangles), atol=1e-13)


@given(SEEDS)
def test_normals_have_length_one_or_zero_without_surface(seed):
    _, x, triangles = random_surface(seed)
    vectors, normals = twins.area_vectors(x, triangles), np.full_like(x, np.nan)
    surface.normals(vectors, normals)
    length = np.linalg.norm(vectors, axis=1)
    np.testing.assert_allclose(normals * length[:, None], vectors, atol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), length > 0, atol=1e-13)
    assert not normals[-1].any()


@given(SEEDS)
def test_drag_of_flow_is_equation_5_per_area(seed):
    random, x, triangles = random_surface(seed)
    flow, before = random.normal(0, 5, size=(2, *x.shape))
    vectors, force = twins.area_vectors(x, triangles), before.copy()
    rest = random.uniform(0.0, 2.0, len(x))
    surface.add_drag_of_flow(flow, vectors, rest, 0.72, force)
    np.testing.assert_allclose(force - before, twins.drag(flow, vectors, rest, 0.72), atol=1e-11)


@given(SEEDS, st.sampled_from([1e-4, 2e-3, 0.1]))
def test_relative_drag_is_equation_5_up_to_the_bound(seed, h):
    random, x, triangles = random_surface(seed)
    flow, velocity, before = random.normal(0, 20, size=(3, *x.shape))
    mass = random.uniform(0.001, 0.1, len(x))
    vectors, force = twins.area_vectors(x, triangles), before.copy()
    rest = random.uniform(0.0, 2.0, len(x))
    surface.add_relative_drag(velocity, flow, vectors, rest, 0.72, mass, h, force)
    expected = twins.relative_drag(velocity, flow, vectors, rest, 0.72, mass, h)
    np.testing.assert_allclose(force - before, expected, atol=1e-9)


@given(SEEDS, st.floats(0.0, 1e6))
def test_relative_drag_never_overshoots_the_flow(seed, speed):
    random, x, triangles = random_surface(seed)
    vectors = twins.area_vectors(x, triangles)
    flow, mass = np.tile([speed, 0.0, 0.0], (len(x), 1)), random.uniform(0.001, 0.1, len(x))
    force = np.zeros_like(x)
    surface.add_relative_drag(np.zeros_like(x), flow, vectors, np.full(len(x), 9.0), 0.72, mass, 0.02, force)
    after = 0.02 * force / mass[:, None]
    area = np.linalg.norm(vectors, axis=1)
    along = np.einsum("va,va->v", vectors, flow) / np.where(area > 0, area, 1.0)
    gained = np.einsum("va,va->v", vectors, after) / np.where(area > 0, area, 1.0)
    assert (gained * np.sign(along) >= -1e-12).all()
    assert (np.abs(gained) <= np.abs(along) * (1 + 1e-12)).all()


@given(SEEDS, st.floats(0.0, 1e4))
def test_gusts_are_travelling_waves(seed, time):
    random, x, _ = random_surface(seed)
    mean, phase, frequency = random.normal(size=3), random.uniform(0, 6, 5), random.uniform(0, 9, 5)
    wave, amplitude = random.normal(size=(2, 5, 3))
    flow = np.full_like(x, np.nan)
    surface.gust_flow(x, time, mean, wave, frequency, phase, amplitude, flow)
    np.testing.assert_allclose(flow, twins.gusts(x, time, mean, wave, frequency, phase, amplitude), atol=1e-10)
