"""The adversarial contract: abuses that are what they say, a judge that sees, and a solver that holds.

The last test is the contract itself, a few episodes for every abuse; ``cloth_validate --torture`` plays on from there.
"""

from __future__ import annotations

import dataclasses
import io
import itertools
import json
from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from cloth_core import ClothSolver, Inputs, Pose, State, StepReport
from cloth_core.config import INTEGRATORS
from cloth_core.obstacles import Plane
from cloth_core.validation import cli
from cloth_core.validation.torture import ABUSES, REST_SPEED, STRETCH_MARGIN, Series, draw, play, series
from cloth_core.validation.torture.abuse import SPIN, Victim, together
from cloth_core.validation.torture.contract import Judge
from cloth_core.validation.torture.episode import DEFAULT_INTEGRATOR, Episode

OTHER = next(name for name in INTEGRATORS if name != DEFAULT_INTEGRATOR)
SMALL = 14  # vertices a side
SEEDS = pytest.mark.parametrize("seed", range(3))


def abused(name: str, seed: int, steps: int = 300, **overrule: object) -> tuple[Victim, list[Inputs]]:
    """What one abuser does to a cloth that does not move."""
    episode = draw(seed, 1, abuses=[name], **overrule)
    place = Pose((0.0, 0.0, 1.0)).apply(episode.mesh.rest_position)
    victim = Victim(episode.mesh, episode.pinned, episode.obstacles, episode.config.dt, place)
    return victim, list(itertools.islice(ABUSES[name](victim, episode.abuser(name)), steps))


def places(inputs: list[Inputs], name: str) -> np.ndarray:
    """(N, 3) m of a hand while it is there."""
    return np.array([one.grasps[name].pose.position for one in inputs if name in one.grasps])


def holds(inputs: list[Inputs], name: str) -> list[np.ndarray]:
    """The ways of a hand from one opening to the next."""
    runs = itertools.groupby(inputs, key=lambda one: name in one.grasps)
    return [places(list(run), name) for there, run in runs if there]


@SEEDS
def test_a_teleported_hand_jumps_by_up_to_10_m(seed):
    _, inputs = abused("teleport", seed)
    ways = [np.linalg.norm(one[:, None] - one[None], axis=2).max() for one in holds(inputs, "teleport")]
    assert len(ways) > 2 and max(ways) <= 10.0 + 1e-9 and max(ways) > 2.0


@SEEDS
def test_torn_ends_go_2_to_10_m_apart(seed):
    victim, inputs = abused("tear", seed)
    for a, b in zip(holds(inputs, "tear_a")[:-1], holds(inputs, "tear_b")[:-1], strict=True):
        assert np.linalg.norm(victim.position - a[0], axis=1).min() < 1e-9  # it starts on the cloth
        assert 2.0 - 1e-9 <= np.linalg.norm(a[-1] - b[-1]) <= 10.0 + 1e-9


@SEEDS
def test_chatter_opens_or_closes_in_every_step(seed):
    _, inputs = abused("chatter", seed)
    closures = np.array([[one.grasps[f"chatter_{n}"].closure for n in range(3)] for one in inputs])
    assert (np.abs(np.diff(closures[:, 0])) == 1.0).all()
    assert 0.3 < closures[:, 1:].mean() < 0.7


@SEEDS
def test_the_far_corner_is_pulled_away_from_the_pins(seed):
    victim, inputs = abused("far-corner", seed, integrator=OTHER)  # whose cloths are always pinned
    anchor = victim.position[victim.pinned].mean(axis=0)
    way = places(inputs, "far_corner")
    from_pins = np.linalg.norm(way - anchor, axis=1)
    reach = np.linalg.norm(victim.position - anchor, axis=1).max()
    assert from_pins[0] == pytest.approx(reach) and reach < from_pins.max() <= reach + 10.0


@SEEDS
def test_hands_that_cross_meet_and_change_places(seed):
    _, inputs = abused("cross", seed)
    a, b = holds(inputs, "cross_a")[0], holds(inputs, "cross_b")[0]
    apart = (a - b) @ (a[0] - b[0]) / np.linalg.norm(a[0] - b[0])
    assert apart.min() < 0.0 < apart.max()
    np.testing.assert_allclose(a + b, np.broadcast_to(a[0] + b[0], a.shape), atol=1e-9)


@SEEDS
def test_a_storm_reaches_beyond_all_measure_and_turns_about(seed):
    _, inputs = abused("storm", seed)
    wind = np.array([one.wind.velocity for one in inputs])
    speed = np.linalg.norm(wind, axis=1)
    assert 1e5 < speed.max() <= 1e6 * (1 + 1e-9)
    assert ((wind[1:] * wind[:-1]).sum(axis=1) < -0.99 * speed[1:] ** 2).mean() > 0.3


@SEEDS
def test_obstacles_jump_by_metres_and_the_floor_up_and_down_only(seed):
    victim, inputs = abused("jump", seed)
    for name, shape in victim.obstacles.items():
        place = np.array([one.obstacles[name].position for one in inputs])
        assert 0.5 < np.ptp(place, axis=0).max() <= 3.0
        if isinstance(shape, Plane):
            assert np.ptp(place[:, :2], axis=0).max() == 0.0


@SEEDS
def test_obstacles_spin_at_20_rad_per_s(seed):
    victim, inputs = abused("spin", seed, steps=5)
    for name, shape in victim.obstacles.items():
        first, second = (one.obstacles[name] for one in inputs[:2])
        assert first == shape.pose and second.position == first.position
        assert np.linalg.norm(first.rotation_vector_to(second)) == pytest.approx(SPIN * victim.dt)


@SEEDS
def test_gravity_keeps_its_strength_and_changes_its_direction(seed):
    _, inputs = abused("gravity", seed)
    pull = np.array([one.gravity for one in inputs])
    np.testing.assert_allclose(np.linalg.norm(pull, axis=1), 9.81)
    assert pull[:, 2].min() < -5.0 < 5.0 < pull[:, 2].max()


def test_together_the_first_abuser_has_what_two_want():
    here, there = Pose((1.0, 0.0, 0.0)), Pose((2.0, 0.0, 0.0))
    one, two = Inputs(obstacles={"ball": here}), Inputs(obstacles={"ball": there, "rod": there}, gravity=(0, 0, 9.81))
    both = together([one, two])
    assert both.obstacles == {"ball": here, "rod": there} and both.gravity == (0.0, 0.0, 9.81)


def test_an_episode_follows_from_seed_and_number_alone():
    one, same, next_one, other_seed = draw(3, 5), draw(3, 5), draw(3, 6), draw(4, 5)
    assert str(one) == str(same) and one.mesh.digest == same.mesh.digest and one.material == same.material
    assert len({one.mesh.digest, next_one.mesh.digest, other_seed.mesh.digest}) == 3


def test_fixing_abuse_and_integrator_leaves_the_rest_of_an_episode_as_it_is():
    drawn = draw(3, 5)
    fixed = draw(3, 5, abuses=["storm"])
    assert fixed.abuses == ("storm",)
    assert dataclasses.replace(fixed, abuses=drawn.abuses, mesh=drawn.mesh, pinned=drawn.pinned) == drawn
    assert fixed.mesh.digest == drawn.mesh.digest
    assert draw(3, 5, integrator=OTHER).material == drawn.material
    alone, in_company = (draw(3, 5, abuses=names).abuser("tear").random() for names in (["tear"], ["storm", "tear"]))
    assert alone == in_company


def test_the_dice_know_every_cloth_abuse_and_integrator():
    episodes = [draw(0, number) for number in range(1, 61)]
    assert {episode.cloth.split()[0] for episode in episodes} == {"grid", "irregular", "chain"}
    assert {name for episode in episodes for name in episode.abuses} == set(ABUSES)
    assert {episode.config.integrator for episode in episodes} == set(INTEGRATORS)
    assert {episode.config.dt for episode in episodes} >= {0.001, 0.02, 0.1}
    assert {name for episode in episodes for name in episode.obstacles} == {"floor", "ball", "box", "rod"}
    free = [episode for episode in episodes if len(episode.pinned) == 0]
    assert free and all("floor" in episode.obstacles and episode.strict for episode in free)


def judged(report: StepReport, position: float = 0.0, **overrule: object) -> set[str]:
    """The rules that a state with this report breaks."""
    episode = draw(0, 1, **overrule)
    judge, shape = Judge(episode), episode.mesh.rest_position.shape
    judge.see(State(np.full(shape, position), np.zeros(shape), step_index=1), report)
    return set(judge.breaches)


def test_the_judge_sees_what_is_not_finite_thrown_away_or_overstretched():
    limit = draw(0, 1).material.stretch_limit
    assert judged(StepReport(), integrator=DEFAULT_INTEGRATOR) == set()
    assert judged(StepReport(), np.nan) == {"finite"}
    assert judged(StepReport(recovered=True)) == {"recovered"}
    just, over = limit + STRETCH_MARGIN - 1e-9, limit + STRETCH_MARGIN + 1e-9
    assert judged(StepReport(max_stretch=just), integrator=DEFAULT_INTEGRATOR) == set()
    assert judged(StepReport(max_stretch=over), integrator=DEFAULT_INTEGRATOR) == {"stretch"}
    assert judged(StepReport(max_stretch=np.nan), integrator=DEFAULT_INTEGRATOR) == {"stretch"}
    assert judged(StepReport(max_stretch=over), integrator=OTHER) == set()


@pytest.mark.parametrize(
    ("speeds", "moves", "at_rest"),
    [
        (np.linspace(0.9, 0.5, 60) * REST_SPEED, True, True),
        (np.linspace(0.5, 0.9, 60) * REST_SPEED, True, False),  # growing
        (np.full(60, 1.1 * REST_SPEED), True, False),  # too fast
        (np.linspace(0.5, 0.9, 60) * 0.1 * REST_SPEED, True, True),  # growing, but next to nothing
        (np.full(30, 0.0), True, False),  # too short
        (np.full(60, 0.0), False, False),  # speaks of rest while it moves
    ],
    ids=["dying away", "growing", "too fast", "noise", "too short", "dishonest"],
)
def test_rest_is_slow_lasting_and_not_growing(speeds, moves, at_rest):
    episode = dataclasses.replace(draw(0, 1), config=dataclasses.replace(draw(0, 1).config, dt=0.02))
    judge, shape = Judge(episode), episode.mesh.rest_position.shape
    judge.calm = True
    position = np.zeros(shape)
    for number, speed in enumerate(speeds):
        velocity = np.zeros(shape)
        velocity[:, 0] = speed
        position = position + (velocity if moves else 2.0 * REST_SPEED * np.ones(shape)) * 0.02
        judge.see(State(position, velocity, step_index=number + 1), StepReport())
    assert judge.at_rest == at_rest
    judge.expect_rest(State(position, velocity, step_index=60))
    assert ("rest" in judge.breaches) == (not at_rest)


def quick(numbers: Iterable[int], **overrule: object) -> Iterator[Episode]:
    """Those of the series 0 that take a test no more than a second: small cloths, no tiny steps."""
    episodes = (draw(0, number, largest=SMALL, **overrule) for number in numbers)
    return (episode for episode in episodes if episode.config.dt >= 0.015)


@pytest.mark.parametrize("cloth", ["grid", "irregular", "chain"])
def test_what_is_merely_dropped_comes_to_rest_in_the_time_that_it_is_given(cloth):
    """The promise is a fair one."""
    for support in ("free", "one corner pinned", "two corners pinned", "an edge pinned"):
        drawn = quick(itertools.count(1), integrator=DEFAULT_INTEGRATOR)
        chosen = next(one for one in drawn if one.cloth.startswith(cloth) and one.support == support)
        outcome = play(dataclasses.replace(chosen, abuses=(), steps=1))
        assert "rest" not in [breach.rule for breach in outcome.breaches], str(chosen)
        assert outcome.duration > 1.0


def spoil(monkeypatch, step: int, fault) -> None:
    """From ``step`` on, hand what the solver returns to ``fault`` (solver, state) first."""
    honest = ClothSolver.step

    def spoilt(solver, state, inputs, *others):
        after = honest(solver, state, inputs, *others)
        return fault(solver, after) if after.step_index >= step else after

    monkeypatch.setattr(ClothSolver, "step", spoilt)


def overstretch(solver, state):
    solver.report = dataclasses.replace(solver.report, max_stretch=9.0 + 0.01 * state.step_index)
    return state


def lose(_solver, state):
    return dataclasses.replace(state, position=state.position * np.nan)


def fall_over(_solver, state):
    raise ZeroDivisionError(f"in step {state.step_index}")


@pytest.mark.parametrize(("fault", "rule"), [(overstretch, "stretch"), (lose, "finite"), (fall_over, "error")])
def test_a_solver_at_fault_is_found_told_and_found_again(fault, rule, monkeypatch, capsys, tmp_path):
    spoil(monkeypatch, 7, fault)
    number = next(quick(itertools.count(1), integrator=DEFAULT_INTEGRATOR)).number
    path = tmp_path / "torture.json"
    of_a_series = f"--integrator {DEFAULT_INTEGRATOR} --abuse spin --largest {SMALL}"
    call = f"--torture 0.001 --episode {number} {of_a_series} --json {path}"
    assert cli.main(call.split()) == 1
    printed = capsys.readouterr().out
    (told,) = json.loads(path.read_text())["episodes"]
    (breach,) = [one for one in told["breaches"] if one["rule"] == rule]
    assert breach["step"] == (6 if rule == "error" else 7)
    assert told["command"] == f"cloth_validate --torture 1 --seed 0 --episode {number} {of_a_series}"
    assert told["command"] in printed and f"episode {number} FAILS" in printed and "0 pass, 1 fail" in printed
    assert cli.main(told["command"].split()[1:]) == 1
    assert capsys.readouterr().out == printed


def test_the_same_episode_ends_bit_equal():
    number = next(quick(itertools.count(1))).number
    one, again = (play(draw(0, number, largest=SMALL)) for _ in range(2))
    assert one.digest == again.digest and one.breaches == again.breaches


def test_progress_is_a_calm_line_every_ten_seconds(monkeypatch):
    clock = itertools.count(0.0, 0.5)
    monkeypatch.setattr(series.time, "monotonic", lambda: next(clock))
    stream = io.StringIO()
    progress = series.Progress(60.0, stream)
    for n in range(100):
        progress.each_step(0.02 * n)
    lines = stream.getvalue().splitlines()
    assert [line.split(":")[0] for line in lines] == [f"{s} of 60 s" for s in (10, 20, 30, 40, 50)]
    assert "0 episodes, 0 failed; worst stretch over its limit none yet; 0.0 simulated minutes" in lines[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--torture", "0"], "more than 0 minutes"),
        (["--torture", "nan"], "more than 0 minutes"),
        (["--torture", "1", "--seed", "-1"], "at least 0"),
        (["--torture", "1", "--episode", "0"], "at least 1"),
        (["--torture", "1", "--largest", "51"], "at least 4, at most 50"),
        (["--torture", "1", "--only", "catenary"], "did you mean --abuse?"),
        (["--torture", "1", "--abuse", "tickle"], "invalid choice"),
        (["--seed", "3"], "--seed goes with --torture"),
    ],
)
def test_a_wrong_call_says_what_would_be_right(arguments, message, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(arguments)
    assert stop.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(("name", "integrator"), list(itertools.product(ABUSES, INTEGRATORS)))
def test_the_contract_holds(name, integrator):
    """Finite in every step, stretch within its limit + 0.05 (default integrator), at rest once left alone."""
    played = Series(0, integrator, (name,), SMALL)
    first = 1 + 100 * list(ABUSES).index(name)  # others for every abuse
    chosen = quick(itertools.count(first), integrator=integrator, abuses=[name])
    outcomes = [play(episode) for episode in itertools.islice(chosen, 2 if integrator == DEFAULT_INTEGRATOR else 1)]
    failed = [series.describe(outcome, played.command(outcome)) for outcome in outcomes if not outcome.passed]
    if failed:
        pytest.fail("\n".join([*failed, series.table(outcomes)]), pytrace=False)
