"""The shipped scenes do what their comments say, from any start of the script and in every round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cloth_core import State
from cloth_core.scene import Scene
from cloth_sim_ros.share import find_scene, scene_names

ROUNDS = 2
ONCE = 20.0  # s that a script without a period is watched
REACH = 3.0  # m
MOST_STRETCH = 1.25
LATE = 2.3  # s that an operator may need to appear


@dataclass(frozen=True)
class Round:
    """What one period of a scene's script did."""

    held: dict[str, int]
    max_stretch: float
    reach: float
    finite: bool
    recovered: bool
    end: State


def play_rounds(name: str, *, delay: float = 0.0) -> list[Round]:
    """Plays the scene's script, which begins ``delay`` s after the cloth."""
    scene = Scene.load(find_scene(name))
    solver, state = scene.build()
    rounds = []
    for _ in range(ROUNDS if scene.script.period else 1):
        held, stretch, reach, finite, recovered = dict.fromkeys(scene.inputs.grasps, 0), 1.0, 0.0, True, False
        for _ in range(round((scene.script.period or ONCE) / solver.config.dt)):
            inputs = scene.script.inputs_at(max(0.0, state.time - delay), scene.inputs)
            state = solver.step(state, inputs)
            held = {grasp: max(most, len(state.grips[grasp].vertex)) for grasp, most in held.items()}
            stretch = max(stretch, solver.report.max_stretch)
            reach = max(reach, float(np.abs(state.position).max()))
            finite &= bool(np.isfinite(state.position).all() and np.isfinite(state.velocity).all())
            recovered |= solver.report.recovered
        rounds.append(Round(held, stretch, reach, finite, recovered, state))
    return rounds


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_runs_two_rounds_calmly_and_its_hands_find_the_cloth_in_each(name):
    for played in play_rounds(name):
        assert played.finite and not played.recovered
        assert played.reach < REACH
        assert played.max_stretch < MOST_STRETCH
        assert all(most > 0 for most in played.held.values()), played.held


def test_the_scarf_is_caught_when_the_operator_comes_late():
    assert all(played.held["hand"] > 0 for played in play_rounds("scarf", delay=LATE))


def test_the_scarf_lets_go_in_every_round():
    assert all(len(played.end.held) == 0 for played in play_rounds("scarf"))


def test_the_tablecloth_leaves_the_table_and_stays_in_hand():
    (played,) = play_rounds("tablecloth")
    assert played.end.position[:, 1].max() < -0.4  # the table's near edge
    assert all(len(grip.vertex) > 0 for grip in played.end.grips.values())


def test_the_draped_ball_takes_the_cloth_along():
    scene = Scene.load(find_scene("drape"))
    solver, state = scene.build()
    top = int(np.argmin(np.linalg.norm(scene.mesh.rest_position[:, :2] - [-0.03, -0.02] - [0.1, 0.0], axis=1)))
    while state.time < 3.9:
        state = solver.step(state, scene.script.inputs_at(state.time, scene.inputs))
    before = np.arctan2(state.position[top, 1], state.position[top, 0])
    while state.time < 9.0:
        state = solver.step(state, scene.script.inputs_at(state.time, scene.inputs))
    turned = np.arctan2(state.position[top, 1], state.position[top, 0]) - before
    assert np.degrees(turned % (2 * np.pi)) == pytest.approx(90.0, abs=15.0)


def test_the_flag_sags_in_the_lull_and_streams_in_the_wind():
    scene = Scene.load(find_scene("flag"))
    solver, state = scene.build()
    heights = {}
    for time in (6.0, 13.0):
        while state.time < time:
            state = solver.step(state, scene.script.inputs_at(state.time, scene.inputs))
        heights[time] = float(state.position[scene.mesh.group("right"), 2].mean())
    assert heights[13.0] < heights[6.0] - 0.1
