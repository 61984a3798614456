"""Levels of /diagnostics mean something: fine, look at it, broken."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import pytest

from cloth_core import Pose
from cloth_core.scene import Scene
from cloth_sim_ros.session import Health
from cloth_sim_ros.simulation import diagnostics
from cloth_sim_ros.simulation.clock import Rhythm, Slot
from cloth_sim_ros.simulation.diagnostics import Level
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation

SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 5, rows: 5}, position: [0.0, 0.0, 0.5]}
obstacles: {ball: {sphere: {radius: 0.1}}}
grasps: {hand: {radius: 0.1}}
"""
PINNED = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 9, rows: 9}, position: [0.0, 0.0, 0.5]}
pins: [left]
grasps: {hand: {radius: 0.06, slip_distance: 10.0}}
"""


class SteadyRhythm(Rhythm):
    """Frames that were published at an exact rate."""

    def __init__(self, rate):
        super().__init__()
        now = time.monotonic_ns()
        for number in range(101):
            self.note(Slot(stamp_ns=0, begin_ns=None, duration_ns=0), 0.004)
            self._published[-1] = now - round((100 - number) * 1e9 / rate)


def timing(rate, **changes):
    usual = dict(nominal=50.0, skipped=0, missed_lately=0, paused=False, waiting=False)
    return diagnostics.timing(SteadyRhythm(rate), **{**usual, **changes})


@pytest.mark.parametrize(("rate", "level"), [(50.0, Level.OK), (45.0, Level.WARN), (20.0, Level.ERROR)])
def test_the_level_follows_the_rate(rate, level):
    status = timing(rate)
    assert status.level == level
    assert float(status.values["rate_hz"]) == pytest.approx(rate, rel=0.01)
    assert f"{rate:.1f}" in status.message


def test_lag_is_the_time_of_the_skipped_slots_and_a_missed_one_is_a_warning():
    status = timing(50.0, skipped=25, missed_lately=2)
    assert status.level == Level.WARN
    assert "2 slots missed" in status.message
    assert float(status.values["lag_s"]) == 0.5
    assert float(status.values["step_p50_ms"]) == pytest.approx(4.0)


def test_nobody_expects_a_rate_while_paused_or_without_a_clock():
    assert timing(1.0, paused=True).level == Level.OK
    waiting = timing(1.0, nominal=0.0, waiting=True)
    assert waiting.level == Level.WARN
    assert "/clock" in waiting.message


def test_the_cloth_tells_what_is_held_and_what_went_wrong():
    simulation = Simulation(Scene.parse(SCENE))
    simulation.set_grasp_pose("hand", Pose((0.2, 0.2, 0.5)), 0.0)
    simulation.set_closure("hand", 1.0)
    failures = Notices(lambda _line: None)
    fine = diagnostics.cloth(simulation.tick(0.0), "dense", failures)
    assert fine.level == Level.OK
    assert fine.values["held_by"].startswith("hand (")
    assert int(fine.values["held_vertices"]) > 0
    simulation.set_obstacle("ball", Pose((5.0, 0.0, 0.0)))
    far = diagnostics.cloth(simulation.tick(0.0), "dense", failures)
    assert far.level == Level.WARN
    assert "teleported" in far.message
    assert "ball" in far.message
    failures.say("not finite", "step 3")
    assert diagnostics.cloth(simulation.tick(0.0), "dense", failures).level == Level.ERROR
    assert diagnostics.cloth(None, "dense", Notices(lambda _line: None)).message == "no step yet"


def pulled(where):
    """What is said after a hand that holds the edge across from a pinned one was asked to go to ``where``."""
    simulation = Simulation(Scene.parse(PINNED))
    simulation.set_closure("hand", 1.0)
    simulation.set_grasp_pose("hand", Pose((0.2, 0.0, 0.5)), 0.0)
    still = simulation.tick(0.0)
    assert not still.report.slowed + still.report.taut
    simulation.set_grasp_pose("hand", Pose(where), 0.0)
    return diagnostics.cloth(simulation.tick(0.0), "dense", Notices(lambda _line: None))


@pytest.mark.parametrize(
    ("where", "said", "not_said"),
    [
        ((0.19, 0.0, 0.5), [], ["held back", "followed late"]),
        ((0.4, 0.0, 0.5), ["held back, for the cloth reaches no farther: hand"], ["followed late"]),
        ((-0.4, 0.0, 0.6), ["followed late, for it was too fast: hand"], ["held back"]),
        ((2.0, 0.0, 0.5), ["held back", "followed late"], []),
    ],
)
def test_a_hand_that_is_too_fast_or_asks_for_too_much_cloth_is_named(where, said, not_said):
    status = pulled(where)
    assert status.level == (Level.WARN if said else Level.OK)
    for text in said:
        assert text in status.message
    for text in not_said:
        assert text not in status.message


def test_vertices_that_were_kept_from_tearing_are_counted():
    simulation = Simulation(Scene.parse(PINNED))
    calm = diagnostics.cloth(simulation.tick(0.0), "dense", Notices(lambda _line: None))
    assert calm.values["restrained_vertices"] == "0"
    torn = simulation.state.position.copy()
    torn[:, 1] *= 1.5
    simulation.state = replace(simulation.state, position=torn)
    frame = simulation.tick(0.0)
    status = diagnostics.cloth(frame, "dense", Notices(lambda _line: None))
    assert int(status.values["restrained_vertices"]) == frame.report.restrained > 10


def test_inputs_name_what_is_stale_refused_undeclared_and_incompatible():
    refused, hints = Notices(lambda _line: None), Notices(lambda _line: None)
    nothing = dict(stale=(), undeclared=(), incompatible=())
    assert diagnostics.inputs(refused, hints, **nothing).level == Level.OK
    refused.say("/wind vector", "/wind: vector = (nan, 0, 0) m/s: ignored")
    hints.say("grasp hand slipped", "grasp hand lost the cloth")
    hints.say("grasp hand slipped", "grasp hand lost the cloth again")
    status = diagnostics.inputs(refused, hints, stale=["hand"], undeclared=["/cube"], incompatible=["/c (DEPTH)"])
    assert status.level == Level.WARN
    assert status.message == (
        "no pose comes, so the hand stays where it was: hand; /wind: vector = (nan, 0, 0) m/s: ignored; "
        "grasp hand lost the cloth again (2 times so far); the scene has no input /cube; incompatible QoS: /c (DEPTH)"
    )
    assert (status.values["refused"], status.values["refused_by_cause"]) == ("1", "/wind vector: 1")
    assert status.values["grasps_without_cloth"] == "grasp hand slipped: 2"


def test_what_went_wrong_long_ago_is_counted_but_no_longer_in_the_message():
    now = [0.0]
    refused = Notices(lambda _line: None, clock=lambda: now[0])
    refused.say("/wind vector", "/wind: ignored")
    now[0] = diagnostics.RECENT + 1.0
    refused.say("/ball pose", "/ball: ignored")
    nothing = dict(stale=(), undeclared=(), incompatible=())
    status = diagnostics.inputs(refused, Notices(lambda _line: None), **nothing)
    assert (status.message, status.values["refused"]) == ("/ball: ignored", "2")


def test_the_session_is_fine_dropping_broken_absent_or_impossible():
    def health(**changes):
        return Health(**{**dict(folder=Path("/s"), messages=1, bytes=2, dropped=0, error=None), **changes})

    assert diagnostics.session(health(), "").level == Level.OK
    assert diagnostics.session(health(dropped=3), "").level == Level.WARN
    assert diagnostics.session(health(error="disk full"), "").level == Level.ERROR
    assert diagnostics.session(None, "").level == Level.OK
    impossible = diagnostics.session(None, "/nowhere: no permission")
    assert impossible.level == Level.ERROR
    assert "/nowhere: no permission" in impossible.message
