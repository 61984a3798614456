"""The shipped scenes do what their comments say, in every round of their scripts."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from clearance import clearance, deepest

from cloth_core import State
from cloth_core.scene import Scene
from cloth_core.script import Script
from cloth_sim_ros.share import find_scene, scene_names

ROUNDS = 2  # where hands have to find the cloth again; else one
AFTER = 3.0  # s that a script without a period is watched when it has ended
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


def _end(script: Script) -> float:
    """When the last keyframe is, s."""
    return max(track[-1].at for track in [*script.grasps.values(), *script.obstacles.values(), script.wind] if track)


@functools.cache
def play_rounds(name: str, *, rounds: int | None = None, delay: float = 0.0) -> list[Round]:
    """Plays the scene's script, which begins ``delay`` s after the cloth."""
    scene = Scene.load(find_scene(name))
    rounds = rounds or (ROUNDS if scene.script.grasps else 1)
    solver, state = scene.build()
    steps = round((scene.script.period or _end(scene.script) + AFTER) / solver.config.dt)
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


@pytest.mark.parametrize("name", scene_names())
def test_nothing_passes_through_the_cloth(name):
    scene = Scene.load(find_scene(name))
    for state in play_rounds(name)[0].states[1:]:  # the tablecloth starts across its bowl
        apart, obstacle = deepest(scene.obstacles, state.obstacles, scene.mesh, state.position)
        assert apart > 0.0, (state.time, obstacle)


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
    assert np.linalg.norm(end[square].mean(axis=0) - lying[square].mean(axis=0)) < 0.025
    assert lying[runner, 1].max() > 0.2 and end[runner, 1].max() < -0.3  # beyond the block's far and near edges
    assert np.isin(played.states[10].held, runner).all()


def test_the_towel_hangs_over_the_line_until_it_is_pulled_off():
    """In the middle of the rope, whose surface is 1.504 m high; one flap is longer than the other."""
    (played,) = play_rounds("clothesline")
    rope = 1.5
    for time in (2, 9):
        x = played.states[time].position
        assert rope < x[:, 2].max() < rope + 0.02
        assert x[:, 2].mean() < rope - 0.15
        assert (np.ptp(x[:, 2]) > 0.4) and (x[:, 2].min() > rope - 0.48)
    front = played.states[2].position.reshape(41, 26, 3)
    assert front[0, :, 2].mean() > front[-1, :, 2].mean() + 0.05
    assert played.states[-1].position[:, 2].max() < 1.3 and len(played.states[-1].grips["hand"].vertex) > 0


def apart(name: str, obstacle: str, state: State) -> float:
    """m between the cloth and an obstacle."""
    scene = Scene.load(find_scene(name))
    return clearance(scene.obstacles[obstacle], state.obstacles[obstacle], scene.mesh, state.position)


def nearest(state: State, *places) -> list[float]:
    """m from each place to the cloth."""
    return [float(np.linalg.norm(state.position - place, axis=1).min()) for place in places]


def test_the_shawl_lies_on_the_mannequins_head_and_shoulders_also_when_it_has_turned():
    states = play_rounds("mannequin")[0].states
    shown = [(0.0, -0.05, 1.67), (0.17, 0.0, 1.4), (-0.17, 0.0, 1.4)]  # m: crown and shoulders
    for second in (2, 6, 10):
        turned = states[second].obstacles["figure"].apply(np.array(shown))
        assert max(nearest(states[second], *turned)) < 0.06
    assert np.degrees(states[6].obstacles["figure"].rotation_vector_to(states[2].obstacles["figure"])[2]) < -55


def test_the_bust_is_covered_and_unveiled():
    states = play_rounds("bust")[0].states
    assert apart("bust", "bust", states[2]) < 0.01
    assert states[2].position[:, 2].min() > 1.0  # m: nothing has slid off
    assert apart("bust", "bust", states[-1]) > 0.1 and len(states[-1].grips["hand"].vertex) > 0


def test_the_dust_sheet_lies_on_desk_screen_and_chair_until_the_chair_rolls_away():
    states = play_rounds("office")[0].states
    for obstacle in ("things", "chair"):
        assert apart("office", obstacle, states[2]) < 0.01
    assert apart("office", "chair", states[6]) > 0.05 and apart("office", "desk", states[6]) < 0.01


def test_the_cape_follows_the_striding_man_and_streams_from_his_shoulders():
    played = play_rounds("ellipsoid_man", rounds=4)
    assert all(len(each.states[-1].grips[clasp].vertex) > 0 for each in played for clasp in ("left", "right"))
    scene, end = Scene.load(find_scene("ellipsoid_man")), played[-1].states[-1]
    wind = np.array(scene.inputs.wind.velocity[:2]) / np.linalg.norm(scene.inputs.wind.velocity[:2])
    hem, neck = (end.position[scene.mesh.group(edge), :2].mean(axis=0) for edge in ("bottom", "top"))
    assert (hem - neck) @ wind > 0.1
