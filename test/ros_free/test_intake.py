"""What comes in: accepted in the cloth's frame, or refused without changing anything."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace as Message

import pytest

from cloth_core import SettingError
from cloth_core.scene import Scene
from cloth_sim_ros import interfaces
from cloth_sim_ros.simulation.closures import ClosureMapping, mappings
from cloth_sim_ros.simulation.frames import FrameTree
from cloth_sim_ros.simulation.intake import NEW_EPOCH_AFTER, Intake, Source, sources
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation
from cloth_sim_ros.vision.camera import Lens

SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 3, rows: 3}, position: [0.0, 0.0, 0.5]}
obstacles: {ball: {sphere: {radius: 0.1}}}
grasps: {hand: {}}
"""
HAND = Source("/grasp", interfaces.GRASP_POSE, "hand")
CLOSURE = Source("/closure", interfaces.GRASP_CLOSURE, "hand")
BALL = Source("/ball", interfaces.OBSTACLE_POSE, "ball")
WIND = Source("/wind", interfaces.WIND)
TURNED = "world turned 1 0 0 0 0 0.7071067811865476 0.7071067811865476"  # 90 degrees about z


class Kit:
    def __init__(self, scene=SCENE):
        self.said = []
        self.simulation = Simulation(Scene.parse(scene))
        self.notices = Notices(self.said.append, clock=lambda: 0.0)
        self.intake = Intake(self.simulation, FrameTree("world", [TURNED]), self.notices)

    def inputs(self):
        return self.simulation.tick(0.0).inputs


@pytest.fixture
def kit():
    return Kit()


def header(frame="world", stamp=0.0):
    nanoseconds = round(stamp * 1e9)
    return Message(frame_id=frame, stamp=Message(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9))


def pose(x=0.0, y=0.0, z=0.0, **where):
    at, turn = Message(x=x, y=y, z=z), Message(x=0.0, y=0.0, z=0.0, w=1.0)
    return Message(header=header(**where), pose=Message(position=at, orientation=turn))


def wind(x=0.0, y=0.0, z=0.0, **where):
    return Message(header=header(**where), vector=Message(x=x, y=y, z=z))


def test_good_messages_reach_the_simulation_and_nothing_is_said(kit):
    assert kit.intake.receive(HAND, pose(1.0, 2.0, 3.0), 5.0)
    assert kit.intake.receive(CLOSURE, Message(data=0.5), 5.0)
    assert kit.intake.receive(BALL, pose(0.0, 0.0, -1.0), 5.0)
    assert kit.intake.receive(WIND, wind(2.0), 5.0)
    inputs = kit.inputs()
    assert inputs.grasps["hand"].pose.position == (1.0, 2.0, 3.0)
    assert inputs.grasps["hand"].closure == 0.5
    assert inputs.obstacles["ball"].position == (0.0, 0.0, -1.0)
    assert inputs.wind.velocity == (2.0, 0.0, 0.0)
    assert kit.said == []


def test_poses_are_moved_and_turned_into_the_cloths_frame_and_wind_is_only_turned(kit):
    kit.intake.receive(BALL, pose(1.0, 0.0, 0.0, frame="turned"), 0.0)
    kit.intake.receive(WIND, wind(3.0, frame="turned"), 0.0)
    inputs = kit.inputs()
    assert inputs.obstacles["ball"].position == pytest.approx((1.0, 1.0, 0.0))
    assert inputs.obstacles["ball"].orientation == pytest.approx((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))
    assert inputs.wind.velocity == pytest.approx((0.0, 3.0, 0.0))


@pytest.mark.parametrize(
    ("source", "bad", "cause"),
    [
        (BALL, pose(math.nan), "/ball pose.position"),
        (BALL, pose(frame="moon"), "/ball header.frame_id"),
        (WIND, wind(math.inf), "/wind vector"),
        (CLOSURE, Message(data=2.0), "/closure data"),
    ],
)
def test_a_bad_message_is_counted_and_the_last_good_value_stays(kit, source, bad, cause):
    kit.intake.receive(HAND, pose(0.1), 0.0)
    kit.intake.receive(CLOSURE, Message(data=0.5), 0.0)
    kit.intake.receive(BALL, pose(0.2), 0.0)
    kit.intake.receive(WIND, wind(1.0), 0.0)
    before = kit.inputs()
    assert not kit.intake.receive(source, bad, 0.0)
    assert kit.inputs() == before
    assert kit.notices.counts == {cause: 1}
    assert kit.said[0].startswith(f"{source.topic}: ")
    assert kit.said[0].endswith("ignored, the last good value stays")


def test_wind_above_the_cap_is_used_at_the_cap_and_said(kit):
    assert kit.intake.receive(WIND, wind(0.0, 80.0, 60.0), 0.0)
    assert kit.inputs().wind.velocity == pytest.approx((0.0, 32.0, 24.0))
    assert kit.notices.counts == {"/wind capped": 1}
    for part in ("(0, 80, 60) m/s", "0 .. 40 m/s", "solver.max_wind_speed"):
        assert part in kit.said[0]


def test_a_stamp_before_the_last_accepted_one_of_its_topic_is_ignored(kit):
    assert kit.intake.receive(BALL, pose(0.1, stamp=100.0), 0.0)
    assert not kit.intake.receive(BALL, pose(0.2, stamp=99.5), 0.1)
    assert kit.inputs().obstacles["ball"].position[0] == 0.1
    assert "header.stamp = 99.500 s is 0.500 s before the last one" in kit.said[0]
    assert kit.intake.receive(BALL, pose(0.3, stamp=100.0), 0.2)  # equal is fine
    assert kit.intake.receive(HAND, pose(0.3, stamp=1.0), 0.2)  # every topic has its own time


def test_a_stamp_of_zero_is_always_accepted_and_does_not_reset_the_order(kit):
    kit.intake.receive(BALL, pose(0.1, stamp=100.0), 0.0)
    assert kit.intake.receive(BALL, pose(0.2), 0.1)
    assert not kit.intake.receive(BALL, pose(0.3, stamp=50.0), 0.2)
    assert kit.inputs().obstacles["ball"].position[0] == 0.2


def test_a_message_refused_for_another_reason_does_not_set_the_time(kit):
    assert not kit.intake.receive(BALL, pose(math.nan, stamp=500.0), 0.0)
    assert kit.intake.receive(BALL, pose(0.1, stamp=100.0), 0.1)


def test_a_clock_that_was_set_back_is_followed_after_a_silence_and_that_is_said(kit):
    kit.intake.receive(BALL, pose(0.1, stamp=100.0), 0.0)
    assert kit.intake.receive(BALL, pose(0.2, stamp=3.0), NEW_EPOCH_AFTER)
    assert kit.intake.receive(BALL, pose(0.3, stamp=3.1), NEW_EPOCH_AFTER + 0.01)
    assert kit.inputs().obstacles["ball"].position[0] == 0.3
    assert ["went back by 97.000 s" in line for line in kit.said] == [True]


def test_after_a_reset_any_stamp_counts(kit):
    kit.intake.receive(BALL, pose(0.1, stamp=100.0), 0.0)
    kit.intake.forget_stamps()
    assert kit.intake.receive(BALL, pose(0.2, stamp=1.0), 0.0)


def test_closures_come_from_axes_buttons_and_joints_and_what_is_not_there_is_named(kit):
    axis, joint = ClosureMapping.parse("hand ~/joy axis 1 1 -1"), ClosureMapping.parse("hand /arm joint finger 0.04 0")
    joy, arm = Source("/joy", interfaces.JOY, closures=(axis,)), Source("/arm", interfaces.JOINTS, closures=(joint,))
    kit.intake.receive(HAND, pose(), 0.0)
    assert kit.intake.receive(joy, Message(axes=[0.0, -0.5], buttons=[]), 0.0)
    assert kit.inputs().grasps["hand"].closure == 0.75
    assert kit.intake.receive(arm, Message(name=["wrist", "finger"], position=[1.0, 0.01]), 0.0)
    assert kit.inputs().grasps["hand"].closure == pytest.approx(0.75)
    assert kit.intake.receive(arm, Message(name=["wrist"], position=[1.0]), 0.0)  # of another part of the robot
    assert kit.said == []
    assert not kit.intake.receive(joy, Message(axes=[0.0], buttons=[]), 0.0)
    assert not kit.intake.receive(joy, Message(axes=[0.0, math.nan], buttons=[]), 0.0)
    assert set(kit.notices.counts) == {"/joy axis 1"}
    assert "there are 0 .. 0" in kit.said[0]
    assert kit.inputs().grasps["hand"].closure == pytest.approx(0.75)


def test_a_camera_stands_where_its_topic_says_or_else_where_its_frame_is(kit):
    info, where = Source("/info", interfaces.CAMERA_INFO), Source("/camera", interfaces.CAMERA_POSE)
    k = [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0]
    assert kit.intake.receive(info, Message(header=header("turned"), width=640, height=480, k=k), 0.0)
    view = kit.intake.viewpoint
    assert view.lens == Lens(640, 480, 500.0, 510.0, 320.0, 240.0)
    assert view.pose.position == (1.0, 0.0, 0.0)
    assert kit.intake.receive(where, pose(0.0, 0.0, 2.0), 0.0)
    assert kit.intake.receive(info, Message(header=header("turned"), width=64, height=48, k=k), 0.0)
    assert (view.pose.position, view.lens.width) == ((0.0, 0.0, 2.0), 64)
    assert not kit.intake.receive(info, Message(header=header(), width=640, height=480, k=[0.0] * 9), 0.0)
    assert not kit.intake.receive(info, Message(header=header(), width=0, height=480, k=k), 0.0)
    assert set(kit.notices.counts) == {"/info k", "/info width, height"}
    assert view.lens.width == 64


def test_a_pointer_directs_the_wind_along_its_x_axis(kit):
    kit.intake.pointer_speed = 2.5
    assert kit.intake.receive(Source("/pointer", interfaces.WIND_POSE), pose(9.0, 9.0, 9.0, frame="turned"), 0.0)
    assert kit.inputs().wind.velocity == pytest.approx((0.0, 2.5, 0.0))  # the frame is turned about z


def test_a_fluid_flows_as_it_is_told_and_too_fast_a_stream_is_refused():
    kit = Kit(SCENE + "fluids: {river: {plane: {}, velocity: [0.5, 0.0, 0.0]}}\n")
    river = Source("/river", interfaces.FLUID_VELOCITY, "river")
    assert kit.inputs().fluids["river"].velocity == (0.5, 0.0, 0.0)
    assert kit.intake.receive(river, wind(2.0, frame="turned"), 0.0)
    assert kit.inputs().fluids["river"].velocity == pytest.approx((0.0, 2.0, 0.0))
    assert not kit.intake.receive(river, wind(500.0), 0.0)
    assert "-100 .. 100" in kit.said[0]
    assert kit.inputs().fluids["river"].velocity == pytest.approx((0.0, 2.0, 0.0))
    kit.simulation.reset()
    assert kit.inputs().fluids["river"].velocity == (0.5, 0.0, 0.0)


def test_a_group_is_pinned_and_let_go(kit):
    pin = Source("/pin", interfaces.GROUP_PIN, "left")
    members = kit.simulation.solver.mesh.group("left").tolist()
    assert kit.intake.receive(pin, Message(data=True), 0.0)
    assert kit.simulation.tick(0.0).pins.tolist() == members
    assert kit.simulation.tick(0.0).pins is None  # as before
    assert kit.intake.receive(pin, Message(data=False), 0.0)
    assert kit.simulation.tick(0.0).pins.tolist() == []


def test_a_pinned_group_is_moved_and_no_other(kit):
    pin, move = Source("/pin", interfaces.GROUP_PIN, "left"), Source("/move", interfaces.GROUP_POSE, "left")
    assert not kit.intake.receive(move, pose(0.1), 0.0)
    assert "/move: nothing of the group left is pinned: send true to ~/group/left/pin before" in kit.said[0]
    assert kit.inputs().groups == {}
    assert kit.intake.receive(pin, Message(data=True), 0.0)
    assert kit.intake.receive(move, pose(1.0, 0.0, 0.0, frame="turned"), 0.0)  # pinned by the time the step begins
    assert kit.inputs().groups["left"].position == pytest.approx((1.0, 1.0, 0.0))
    assert not kit.intake.receive(move, pose(math.nan), 0.0)
    assert kit.inputs().groups["left"].position == pytest.approx((1.0, 1.0, 0.0))
    assert kit.intake.receive(pin, Message(data=False), 0.0)
    assert kit.inputs().groups == {}


def test_rest_lengths_of_a_group_are_scaled_until_reset(kit):
    scale = Source("/scale", interfaces.GROUP_REST_SCALE, "left")
    assert kit.intake.receive(scale, Message(data=0.5), 0.0)
    assert kit.inputs().rest_scale == {"left": 0.5}
    assert not kit.intake.receive(scale, Message(data=5.0), 0.0)
    assert "/scale: data = 5 (rest scale): allowed is a number 0.3 .. 3 m/m" in kit.said[0]
    one = Source("/one", interfaces.GROUP_REST_SCALE, "top_left")
    assert not kit.intake.receive(one, Message(data=0.5), 0.0)
    assert "no spring has both its ends in the group top_left" in kit.said[1]
    kept = kit.simulation.keep()
    kit.simulation.reset()
    assert kit.inputs().rest_scale == {}
    kit.simulation.restore(kept)
    assert kit.inputs().rest_scale == {"left": 0.5}


def test_sources_are_those_of_the_scene_and_of_the_mapped_closures():
    closures = mappings(["hand ~/joy axis 1", "hand ~/joy button 0", "hand /arm joint finger"], ["hand"])
    scene = Scene.parse(SCENE)
    found = {source.topic: source for _, source in sources(scene, closures, lambda name: f"/n{name[1:]}")}
    assert set(found) == {
        "/n/grasp/hand/pose",
        "/n/grasp/hand/closure",
        "/n/wind",
        "/n/obstacle/ball/pose",
        "/n/wind/pose",
        *(f"/n/group/{name}/{what}" for name in scene.mesh.groups for what in ("pin", "pose", "rest_scale")),
        "/n/camera/pose",
        "/n/camera/info",
        "/n/joy",
        "/narm",
    }
    assert found["/n/joy"].closures == closures[:2]
    assert found["/narm"].interface is interfaces.JOINTS


@pytest.mark.parametrize(
    ("texts", "part"),
    [
        (["hand ~/joy axis"], "is not of the form"),
        (["hand ~/joy axis one"], "is not of the form"),
        (["hand ~/joy axis -1"], "is not of the form"),
        (["hand ~/joy axis 1 0.5 0.5"], "different numbers"),
        (["hand ~/joy stick 1"], "axis|button|joint"),
        (["left ~/joy axis 1"], "no grasp left; this scene has hand"),
        (["hand ~/joy axis 1", "hand ~/joy joint a"], "both joints and axes"),
    ],
)
def test_a_mapping_that_means_nothing_is_refused(texts, part):
    with pytest.raises(SettingError, match=re.escape(part)):
        mappings(texts, ["hand"])


def test_an_empty_frame_is_the_cloths_and_no_fault(kit):
    assert kit.intake.receive(BALL, pose(0.1, frame=""), 0.0)
    assert kit.intake.receive(WIND, wind(1.0, frame=""), 0.0)
    inputs = kit.inputs()
    assert (inputs.obstacles["ball"].position[0], inputs.wind.velocity[0]) == (0.1, 1.0)
    assert (kit.said, kit.notices.counts) == ([], {})
    assert not kit.intake.receive(BALL, pose(0.2, frame="wrld"), 0.0)
    assert "header.frame_id = 'wrld' is not connected with the cloth's frame 'world'" in kit.said[0]


def test_a_notice_comes_once_in_a_period_per_cause_and_tells_how_often_it_was():
    said, now = [], [0.0]
    notices = Notices(said.append, period=5.0, clock=lambda: now[0])
    for moment in range(11):
        now[0] = float(moment)
        notices.say("a", "first")
    notices.say("b", "second")
    assert said == ["first", "first (6 times so far)", "first (11 times so far)", "second"]
    assert notices.as_text() == "a: 11; b: 1"
    assert notices.within(1.0) == ["first (11 times so far)", "second"]
    now[0] = 30.0
    assert notices.within(10.0) == []
