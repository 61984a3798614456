"""The shipped scenes do what their comments say, in every round of their scripts."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import pytest

from cloth_core import State
from cloth_core.scene import Scene
from cloth_sim_ros.share import find_scene, scene_names

ROUNDS = 2
ONCE = 20.0  # s that a script without a period is watched
REACH = 3.0  # m
MOST_STRETCH = 1.35
LATE = 2.3  # s that an operator may need to appear


@dataclass(frozen=True)
class Round:
    """What one period of a scene's script did; ``states`` are those at whole seconds, the last one is its end."""

    held: dict[str, int]
    max_stretch: float
    reach: float
    finite: bool
    recovered: bool
    states: list[State]


@functools.cache
def play_rounds(name: str, *, rounds: int = ROUNDS, delay: float = 0.0) -> list[Round]:
    """Plays the scene's script, which begins ``delay`` s after the cloth."""
    scene = Scene.load(find_scene(name))
    solver, state = scene.build()
    steps = round((scene.script.period or ONCE) / solver.config.dt)
    played = []
    for _ in range(rounds if scene.script.period else 1):
        held, stretch, reach, finite, recovered = dict.fromkeys(scene.script.grasps, 0), 1.0, 0.0, True, False
        states = []
        for number in range(steps):
            if number % round(1.0 / solver.config.dt) == 0:
                states.append(state)
            inputs = scene.script.inputs_at(max(0.0, state.time - delay), scene.inputs)
            state = solver.step(state, inputs)
            held = {grasp: max(most, len(state.grips[grasp].vertex)) for grasp, most in held.items()}
            stretch = max(stretch, solver.report.max_stretch)
            reach = max(reach, float(np.abs(state.position).max()))
            finite &= bool(np.isfinite(state.position).all() and np.isfinite(state.velocity).all())
            recovered |= solver.report.recovered
        played.append(Round(held, stretch, reach, finite, recovered, [*states, state]))
    return played


@pytest.mark.parametrize("name", scene_names())
def test_a_scene_plays_calmly_and_its_hands_find_the_cloth_in_every_round(name):
    for played in play_rounds(name):
        assert played.finite and not played.recovered
        assert played.reach < REACH
        assert played.max_stretch < MOST_STRETCH
        assert all(most > 0 for most in played.held.values()), played.held


def test_the_scarf_is_caught_when_the_operator_comes_late():
    (played,) = play_rounds("scarf", rounds=1, delay=LATE)
    assert played.held["hand"] > 0


def test_the_scarf_is_let_go_in_every_round():
    assert all(len(played.states[-1].held) == 0 for played in play_rounds("scarf"))


def test_the_tablecloth_leaves_the_table_and_stays_in_hand():
    (played,) = play_rounds("tablecloth")
    end = played.states[10]
    assert end.position[:, 1].max() < -0.4  # the table's near edge
    assert all(len(grip.vertex) > 0 for grip in played.states[-1].grips.values())


def test_the_gripper_holds_the_cloth_up_off_the_table():
    (played,) = play_rounds("gripper")
    end = played.states[-1]
    assert end.position[:, 1].max() < -0.3  # the table's near edge
    assert end.position[:, 2].max() > 0.85 and len(end.grips["gripper"].vertex) > 0


def test_the_draped_ball_takes_the_cloth_along():
    states = play_rounds("drape")[0].states
    top = int(np.argmin(np.linalg.norm(states[4].position - [0.1, 0.0, 0.58], axis=1)))
    before, after = (np.arctan2(state.position[top, 1], state.position[top, 0]) for state in (states[4], states[9]))
    assert np.degrees(after - before) == pytest.approx(90.0, abs=15.0)


def test_the_flag_hangs_lower_in_the_lull_than_in_the_wind():
    states = play_rounds("flag")[0].states
    tip = Scene.load(find_scene("flag")).mesh.group("right")
    windy, lull = (float(states[second].position[tip, 2].mean()) for second in (7, 13))
    assert lull < windy - 0.1


def test_the_runner_is_pulled_off_and_the_square_under_it_stays():
    (played,) = play_rounds("runner")
    mesh = Scene.load(find_scene("runner")).mesh
    lying, end = played.states[3].position, played.states[10].position
    square, runner = mesh.pieces["square"], mesh.pieces["runner"]
    assert np.linalg.norm(end[square].mean(axis=0) - lying[square].mean(axis=0)) < 0.01
    assert lying[runner, 1].max() > 0.2 and end[runner, 1].max() < -0.3  # beyond the block's far and near edges
    assert np.isin(played.states[10].held, runner).all()
