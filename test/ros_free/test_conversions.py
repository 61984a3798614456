"""Messages in, numbers out: what is accepted, and how what is damaged is refused."""

from __future__ import annotations

import math
from types import SimpleNamespace as Message

import pytest

from cloth_sim_ros.messages.conversions import RefusedError, read_closure, read_pose, read_wind, stamp_ns


def pose_message(position=(0.0, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0)):
    x, y, z = position
    qx, qy, qz, qw = orientation
    return Message(pose=Message(position=Message(x=x, y=y, z=z), orientation=Message(x=qx, y=qy, z=qz, w=qw)))


def vector_message(x, y, z):
    return Message(vector=Message(x=x, y=y, z=z))


def test_a_pose_keeps_its_numbers_and_gets_a_unit_quaternion():
    pose = read_pose(pose_message((1.0, -2.0, 3.0), (0.0, 0.0, 2.0, 2.0)))
    assert pose.position == (1.0, -2.0, 3.0)
    assert pose.orientation == pytest.approx((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e6, -1e300])
@pytest.mark.parametrize("axis", range(3))
def test_a_damaged_position_is_refused_with_its_value_range_and_unit(bad, axis):
    position = [0.5, 0.5, 0.5]
    position[axis] = bad
    with pytest.raises(RefusedError) as refused:
        read_pose(pose_message(position))
    assert refused.value.field == "pose.position"
    for part in ("pose.position", f"{bad:g}", "+-1e+06 m", "finite"):
        assert part in str(refused.value)


@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (0, math.inf, 0, 1), (1e-9, 0, 0, 0)])
def test_a_quaternion_without_direction_is_refused(bad):
    with pytest.raises(RefusedError, match=r"pose.orientation = .*not zero") as refused:
        read_pose(pose_message(orientation=bad))
    assert refused.value.field == "pose.orientation"


@pytest.mark.parametrize("closure", [0.0, 0.25, 1.0])
def test_a_closure_within_its_range_is_taken(closure):
    assert read_closure(Message(data=closure)) == closure


@pytest.mark.parametrize("closure", [-1e-9, 1.0000001, 17.0, math.nan, math.inf])
def test_a_closure_out_of_range_is_refused(closure):
    with pytest.raises(RefusedError, match=r"data = .* 0 \(open\) .. 1 \(closed\)"):
        read_closure(Message(data=closure))


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_wind_that_is_not_finite_is_refused(bad):
    with pytest.raises(RefusedError, match=r"vector = .* m/s"):
        read_wind(vector_message(1.0, bad, 0.0))


def test_a_stamp_is_read_to_the_nanosecond():
    header = Message(stamp=Message(sec=1_700_000_000, nanosec=999_999_999))
    assert stamp_ns(Message(header=header)) == 1_700_000_000_999_999_999
