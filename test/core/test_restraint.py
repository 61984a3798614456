"""The last resort of the stretch limit: nothing gets longer than it may, and momentum stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import ClothMesh, Material
from cloth_core.kernels.springs import largest_stretch
from cloth_core.physics.restraint import MARGIN, Restraint
from cloth_core.validation.geometry import irregular_sheet

H = 0.002
NOBODY = np.zeros(0, np.int32)
MESHES = {
    "grid": ClothMesh.grid(width=0.3, height=0.3, columns=7, rows=7),
    "irregular": irregular_sheet(0.3, 0.3, 7, seed=2),
}


def restrained(mesh, way, hands=(), pinned=NOBODY, lying=NOBODY, strongest=100.0, start=None):
    """Where a way (V, 3) m ends that begins at rest, and the velocity told."""
    restraint = Restraint(mesh, Material(), strongest)
    restraint.hold(hands, pinned)
    start = mesh.rest_position if start is None else start
    end, velocity = start + way, way / H
    changed = restraint.apply(start, end, velocity, H, lambda: lying)
    np.testing.assert_allclose(velocity, (end - start) / H, atol=1e-9)
    assert set(np.flatnonzero((end != start + way).any(axis=1))) <= set(changed)
    return end


def stretch(mesh, position):
    return largest_stretch(position, mesh.spring_vertex, mesh.limit_rest, mesh.spring_limited)


def test_what_is_within_its_margin_stays_bit_equal():
    mesh = MESHES["grid"]
    way = (1.03 + MARGIN - 1.0 - 1e-9) * mesh.rest_position
    np.testing.assert_array_equal(restrained(mesh, way), mesh.rest_position + way)


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(sorted(MESHES)), st.integers(0, 10_000), st.floats(1e-3, 10.0))
def test_no_thread_is_torn_and_momentum_stays(name, seed, size):
    mesh, random = MESHES[name], np.random.default_rng(seed)
    way = size * random.normal(size=(mesh.vertex_count, 3))
    end = restrained(mesh, way)
    assert stretch(mesh, end) <= 1.03 + MARGIN + 1e-6
    mass = mesh.vertex_mass(Material())
    before, after = mass @ way, mass @ (end - mesh.rest_position)
    np.testing.assert_allclose(after, before, atol=1e-9 * (1.0 + size))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(1e-3, 10.0), st.booleans())
def test_pins_stay_and_a_hand_stays_one_body(seed, size, pin):
    mesh, random = MESHES["grid"], np.random.default_rng(seed)
    hand, pinned = np.array([0, 1, 7]), np.array([48]) if pin else NOBODY
    way = 0.1 * size * random.normal(size=(mesh.vertex_count, 3))
    way[hand] = size * random.normal(size=3)
    way[pinned] = 0.0
    end = restrained(mesh, way, hands=[hand], pinned=pinned)
    assert stretch(mesh, end) <= 1.03 + MARGIN + 1e-6
    np.testing.assert_array_equal(end[pinned], mesh.rest_position[pinned])
    moved = (end - mesh.rest_position)[hand]
    np.testing.assert_allclose(moved, np.broadcast_to(moved[0], moved.shape), atol=1e-12)


@pytest.mark.parametrize(("strongest", "share"), [(1e4, 1.0), (10.0, None)])
def test_a_hand_pulls_with_no_more_than_its_force(strongest, share):
    mesh, hand = MESHES["grid"], np.array([0])
    way = np.zeros((mesh.vertex_count, 3))
    way[0] = [-0.3, 0.0, 0.0]  # six cells in a substep, away from the cloth
    end = restrained(mesh, way, hands=[hand], strongest=strongest)
    moved = end - mesh.rest_position
    mass = mesh.vertex_mass(Material())
    if share is not None:
        np.testing.assert_allclose(moved[0], way[0], atol=1e-15)
        return
    assert 0.0 < -moved[0, 0] < 0.3
    # The sweeps came first; what was welded then got the impulse of the force at most.
    assert np.isfinite(moved).all() and -(mass[1:] @ moved[1:, 0]) < 0.3 * mass.sum()


def test_a_hand_does_not_pull_what_lies_through_what_it_lies_on():
    mesh, hand = MESHES["grid"], np.array([24])
    way = np.zeros((mesh.vertex_count, 3))
    way[24] = [0.0, 0.0, -0.1]
    lying = np.setdiff1d(np.arange(49), hand)
    end = restrained(mesh, way, hands=[hand], lying=lying)
    assert stretch(mesh, end) <= 1.03 + MARGIN + 1e-6
    assert abs(end[:, 2]).max() < 0.02
    assert abs(end[lying, 2]).max() < 1e-5
