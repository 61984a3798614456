"""Frames: messages in another frame than the cloth's arrive where they belong, or are refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import Pose, SettingError
from cloth_sim_ros.messages.conversions import RefusedError
from cloth_sim_ros.simulation.frames import FrameTree, inverse

QUARTER = "0 0 0.7071067811865476 0.7071067811865476"  # 90 degrees about z
TREE = [
    f"world table 1 2 0.7 {QUARTER}",
    "table camera 0 0 1 0 0 0 1",
    "map world 10 0 0 0 0 0 1",
    "mars rover 0 0 0 0 0 0 1",
]

number = st.floats(min_value=-5.0, max_value=5.0)
poses = st.builds(
    Pose,
    st.tuples(number, number, number),
    st.tuples(number, number, number, number).filter(lambda q: np.linalg.norm(q) > 0.1),
)


def place(tree, frame, point):
    return tree.to_cloth(frame).apply(np.array([point], dtype=float))[0]


def test_the_cloths_own_frame_and_the_empty_name_change_nothing():
    tree = FrameTree("world", TREE)
    for frame in ("world", "", "/world"):
        assert tree.to_cloth(frame) == Pose()


def test_a_point_is_carried_up_through_two_frames():
    # camera point (1, 0, 0) is (1, 0, 1) in the table, which the quarter turn takes to (0, 1, 1), then the shift
    assert place(FrameTree("world", TREE), "camera", (1, 0, 0)) == pytest.approx((1.0, 3.0, 1.7))


def test_a_point_of_a_frame_above_the_cloths_is_carried_down():
    assert place(FrameTree("world", TREE), "map", (10, 0, 0)) == pytest.approx((0.0, 0.0, 0.0))
    assert place(FrameTree("table", TREE), "world", (1, 2, 0.7)) == pytest.approx((0.0, 0.0, 0.0))


@given(poses, number, number, number)
def test_there_and_back_again_is_where_one_was(pose, x, y, z):
    point = np.array([[x, y, z]])
    assert inverse(pose).apply(pose.apply(point)) == pytest.approx(point, abs=1e-9)


def test_a_frame_that_nothing_connects_is_refused_naming_those_that_are_known():
    tree = FrameTree("world", TREE)
    for stranger in ("moon", "rover"):
        with pytest.raises(RefusedError, match="camera, map, table, world") as refused:
            tree.to_cloth(stranger)
        assert refused.value.field == "header.frame_id"
        assert f"'{stranger}'" in str(refused.value)
        assert "static_transforms" in str(refused.value)


def test_tf_goes_before_the_static_transforms_and_they_stand_in_where_it_is_silent():
    answers = {"table": Pose((9.0, 9.0, 9.0))}
    tree = FrameTree("world", TREE, lookup=lambda target, source: answers.get(source))
    assert tree.to_cloth("table").position == (9.0, 9.0, 9.0)
    assert place(tree, "camera", (0, 0, 0)) == pytest.approx((1.0, 2.0, 1.7))


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("world table 0 0 0", "5 words"),
        ("world table 0 0 0 0 0 0 zero", "form"),
        ("world table 0 0 0 0 0 0 0", "orientation"),
        ("world table nan 0 0 0 0 0 1", "position"),
        ("mars table 0 0 0 0 0 0 1", "already has the parent world"),
        ("camera map 0 0 0 0 0 0 1", "ring"),
        ("self self 0 0 0 0 0 0 1", "ring"),
    ],
)
def test_a_malformed_transform_is_refused_with_its_text(text, problem):
    with pytest.raises(SettingError, match=problem) as refused:
        FrameTree("world", [*TREE, text])
    assert refused.value.key == "static_transforms"
    assert text in str(refused.value)
