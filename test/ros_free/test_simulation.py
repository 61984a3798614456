"""The simulation as the node drives it: the newest inputs, one frame per tick."""

from __future__ import annotations

import numpy as np
import pytest
from small_scene import SMALL_SCENE

from cloth_core import InputError, Pose
from cloth_core.scene import Scene
from cloth_sim_ros.simulation.simulation import Simulation

MORE = """\
  other: {radius: 0.08}
wind: {velocity: [0.5, 0.0, 0.0], gust_intensity: 0.2}
"""
SCENE = SMALL_SCENE + MORE
CORNER = Pose((0.2, 0.2, 0.5))
ABOVE = Pose((0.2, 0.2, 0.9))


@pytest.fixture
def simulation():
    return Simulation(Scene.parse(SCENE))


def run(simulation, steps, start=0.0):
    for number in range(steps):
        frame = simulation.tick(start + 0.02 * number)
    return frame


def test_a_frame_holds_the_cloth_after_the_step(simulation):
    frame = run(simulation, 3)
    mesh = simulation.solver.mesh
    assert frame.step_index == 3
    assert frame.time == pytest.approx(0.06)
    assert frame.position.shape == frame.normal.shape == (mesh.vertex_count, 3)
    assert frame.report is simulation.solver.report
    assert frame.digest == simulation.state.digest
    # The cloth falls all but flat: every normal points up, and no thread is longer than the limit lets it be.
    assert np.linalg.norm(frame.normal, axis=1) == pytest.approx(1.0)
    assert (frame.normal[:, 2] > 0.9).all()
    lengths = np.linalg.norm(np.diff(frame.position[mesh.spring_vertex], axis=1)[:, 0], axis=1)
    worst = (lengths / mesh.spring_rest - 1.0)[mesh.spring_limited].max()
    assert frame.strain.max() == pytest.approx(worst)


def test_a_grasp_is_left_out_until_its_first_pose_and_its_closure_waits(simulation):
    simulation.set_closure("hand", 1.0)
    assert run(simulation, 1).inputs.grasps == {}
    simulation.set_grasp_pose("hand", Pose(tuple(simulation.state.position[-1])), 0.02)
    frame = simulation.tick(0.02)
    assert frame.inputs.grasps.keys() == {"hand"}
    assert frame.inputs.grasps["hand"].radius == 0.08
    assert frame.report.held > 0


def test_a_closed_hand_lifts_the_corner_and_lets_go_again(simulation):
    simulation.set_grasp_pose("hand", CORNER, 0.0)
    simulation.set_closure("hand", 1.0)
    simulation.tick(0.0)
    simulation.set_grasp_pose("hand", ABOVE, 0.0)
    lifted = run(simulation, 40)
    assert lifted.position[-1] == pytest.approx((0.2, 0.2, 0.9), abs=0.02)
    simulation.set_closure("hand", 0.0)
    assert run(simulation, 1).report.held == 0


def test_without_poses_a_grasp_is_held_where_it_is_and_reported_stale(simulation):
    simulation.set_grasp_pose("hand", CORNER, 10.0)
    assert simulation.tick(10.09).stale == ()
    frame = simulation.tick(10.11)
    assert frame.stale == ("hand",)
    assert frame.inputs.grasps["hand"].pose == CORNER
    simulation.set_grasp_pose("hand", CORNER, 10.12)
    assert simulation.tick(10.13).stale == ()


def test_wind_replaces_the_mean_and_keeps_the_gusts(simulation):
    simulation.set_wind((3.0, -1.0, 0.0))
    wind = simulation.tick(0.0).inputs.wind
    assert wind.velocity == (3.0, -1.0, 0.0)
    assert wind.gust_intensity == 0.2


def test_an_obstacle_goes_where_it_is_told(simulation):
    simulation.set_obstacle("ball", Pose((0.3, 0.0, 0.2)))
    assert simulation.tick(0.0).state.obstacles["ball"].position == (0.3, 0.0, 0.2)


def test_names_that_the_scene_does_not_have_are_refused_naming_those_that_it_has(simulation):
    with pytest.raises(InputError, match=r"claw.*hand, other"):
        simulation.set_grasp_pose("claw", CORNER, 0.0)
    with pytest.raises(InputError, match=r"cube.*ball, floor"):
        simulation.set_obstacle("cube", CORNER)


def test_a_reset_is_the_start_again_and_nothing_stays_held(simulation):
    first = run(simulation, 1)
    simulation.set_grasp_pose("hand", CORNER, 0.0)
    simulation.set_closure("hand", 1.0)
    simulation.set_wind((9.0, 0.0, 0.0))
    simulation.set_obstacle("ball", Pose((0.3, 0.0, 0.2)))
    assert run(simulation, 20).report.held > 0
    simulation.reset()
    assert simulation.state.step_index == 0
    again = run(simulation, 1)
    assert again.report.held == 0
    assert again.digest == first.digest


def test_a_hand_closed_before_a_reset_has_to_open_before_it_grasps_again(simulation):
    simulation.set_grasp_pose("hand", CORNER, 0.0)
    simulation.set_closure("hand", 1.0)
    run(simulation, 5)
    simulation.reset()
    simulation.set_grasp_pose("hand", CORNER, 0.0)
    simulation.set_closure("hand", 1.0)
    assert simulation.tick(0.0).report.held == 0
    simulation.set_closure("hand", 0.0)
    simulation.tick(0.0)
    simulation.set_closure("hand", 1.0)
    assert simulation.tick(0.0).report.held > 0


def test_a_step_that_raises_leaves_the_state_as_it_was(simulation):
    before = run(simulation, 2).state

    def broken_clock():
        raise RuntimeError("no time")

    with pytest.raises(RuntimeError, match="no time"):
        simulation.tick(0.0, broken_clock)
    assert simulation.state is before
    assert run(simulation, 1).step_index == 3


def test_the_same_inputs_at_the_same_ticks_give_the_same_cloth():
    def episode():
        simulation = Simulation(Scene.parse(SCENE))
        simulation.set_grasp_pose("hand", CORNER, 0.0)
        simulation.set_closure("hand", 1.0)
        run(simulation, 3)
        simulation.set_grasp_pose("hand", ABOVE, 0.06)
        return run(simulation, 10).digest

    assert episode() == episode()


def test_preparing_changes_nothing_that_follows():
    prepared, fresh = Simulation(Scene.parse(SCENE)), Simulation(Scene.parse(SCENE))
    report = prepared.solver.report
    prepared.prepare()
    assert prepared.state.step_index == 0
    assert prepared.solver.report is report
    assert run(prepared, 10).digest == run(fresh, 10).digest
