"""Poses agree with scipy's rotations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cloth_core import Pose

SEEDS = st.integers(0, 10**6)


def random_pose(random: np.random.Generator) -> Pose:
    return Pose(tuple(random.normal(size=3)), tuple(random.normal(size=4)))


@given(SEEDS)
def test_rotation_apply_and_compose_agree_with_scipy(seed):
    random = np.random.default_rng(seed)
    outer, inner, points = random_pose(random), random_pose(random), random.normal(size=(5, 3))
    turn = Rotation.from_quat(outer.orientation)
    np.testing.assert_allclose(outer.rotation, turn.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(outer.apply(points), turn.apply(points) + outer.position, atol=1e-13)
    np.testing.assert_allclose(outer.inverse_apply(outer.apply(points)), points, atol=1e-13)
    np.testing.assert_allclose(outer.compose(inner).apply(points), outer.apply(inner.apply(points)), atol=1e-13)


@given(SEEDS)
def test_rotation_vector_leads_from_one_pose_to_the_other(seed):
    random = np.random.default_rng(seed)
    start, end = random_pose(random), random_pose(random)
    vector = start.rotation_vector_to(end)
    expected = (Rotation.from_quat(end.orientation) * Rotation.from_quat(start.orientation).inv()).as_rotvec()
    np.testing.assert_allclose(vector, expected, atol=1e-7)
    assert np.linalg.norm(vector) <= math.pi + 1e-12
    np.testing.assert_allclose(Pose(orientation=start.turned(vector)).rotation, end.rotation, atol=1e-12)


def test_toward_is_exact_at_both_ends_and_halves_the_way():
    start, end = Pose((0, 0, 0)), Pose((2, 0, 0), (0, 0, math.sin(0.5), math.cos(0.5)))
    assert start.toward(end, 0.0) is start
    assert start.toward(end, 1.0) is end
    half = start.toward(end, 0.5)
    assert half.position == (1, 0, 0)
    assert np.linalg.norm(half.rotation_vector_to(end)) == pytest.approx(0.5)


def test_a_quaternion_and_its_negative_are_the_same_turn():
    pose = Pose(orientation=(0.1, 0.2, 0.3, 0.4))
    negative = Pose(orientation=(-0.1, -0.2, -0.3, -0.4))
    assert np.linalg.norm(pose.rotation_vector_to(negative)) < 1e-12
