"""The filter of hand poses: quiet where a hand holds still, and no lag that one could feel where it moves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cloth_core import Pose
from cloth_sim_ros.simulation.jitter import LEASH, Tracked

RATE = 72.0  # Hz, a common rate of headsets
CUTOFF = 3.0


def filtered(path, cutoff=CUTOFF):
    """What becomes of (N, 3) positions that come at ``RATE``."""
    hand = None
    result = []
    for number, position in enumerate(path):
        pose, at = Pose(tuple(position)), number / RATE
        hand = hand.next(pose, at, cutoff) if hand else Tracked(pose, pose, at)
        result.append(hand.pose.position)
    return np.array(result)


def test_of_the_jitter_of_a_hand_that_holds_still_less_than_half_is_left():
    jitter = np.random.default_rng(1).normal(0.0, 3e-4, (2000, 3))
    left = filtered(jitter)[100:].std()
    assert left == pytest.approx(1.2e-4, rel=0.25)  # 0.4 of it; without the filter all
    assert filtered(jitter, 0.0)[100:].std() == pytest.approx(3e-4, rel=0.05)


@pytest.mark.parametrize(("speed", "most_ms"), [(0.25, 8.1), (0.5, 4.1), (2.0, 1.1)])
def test_a_moving_hand_is_followed_within_milliseconds(speed, most_ms):
    time = np.arange(200) / RATE
    path = np.outer(time * speed, [0.6, 0.0, 0.8])
    lag = np.linalg.norm(path - filtered(path), axis=1)[-1] / speed
    assert 0.0 < 1e3 * lag < most_ms


def test_a_hand_that_starts_or_jumps_is_never_farther_than_the_leash():
    time = np.arange(100) / RATE
    start = np.where(time < 0.3, 0.0, 2.5 * (time - 0.3) ** 2)  # 5 m/s^2
    start[80:] += 0.7
    path = np.outer(start, [0.0, 1.0, 0.0])
    off = np.linalg.norm(path - filtered(path), axis=1)
    assert off.max() <= LEASH[0] + 1e-12
    assert off[25:75].max() > 0.5 * LEASH[0]  # the leash is what holds it there


def test_a_turn_is_followed_as_well_and_jitter_of_the_turn_is_taken_away():
    generator = np.random.default_rng(2)
    hand, still, turning = None, [], []
    for number in range(600):
        angle = generator.normal(0.0, 2e-3) + (0.0 if number < 300 else (number - 300) / RATE)
        pose = Pose(orientation=(0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2)))
        hand = hand.next(pose, number / RATE, CUTOFF) if hand else Tracked(pose, pose, 0.0)
        off = np.linalg.norm(hand.pose.rotation_vector_to(pose))
        assert off <= LEASH[1] + 1e-12
        (still if number < 300 else turning).append(2 * math.asin(hand.pose.orientation[2]) if number < 300 else off)
    assert np.std(still[50:]) < 1.3e-3


def test_after_a_gap_and_at_the_same_instant_the_pose_is_taken_as_it_is():
    hand = Tracked(Pose(), Pose(), 0.0)
    there = Pose((0.001, 0.0, 0.0))
    for at in (0.5, 0.0, -1.0):
        assert hand.next(there, at, CUTOFF).pose == there
    assert hand.next(there, 0.01, CUTOFF).pose != there
