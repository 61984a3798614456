"""One episode: abuse first, then calm, the contract checked in every step."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from cloth_core.inputs import Inputs
from cloth_core.solver import ClothSolver
from cloth_core.state import State
from cloth_core.validation.torture.abuse import ABUSES, Victim, together
from cloth_core.validation.torture.contract import Breach, Judge, time_to_rest
from cloth_core.validation.torture.episode import Episode


@dataclass(frozen=True)
class Outcome:
    """What became of an episode.

    Args:
        episode: as it was drawn.
        breaches: none, if the contract held.
        worst_excess: largest stretch less the material's limit (a ratio).
        duration: s of simulated time.
        digest: of the last state, to tell whether two plays were the same.
    """

    episode: Episode
    breaches: tuple[Breach, ...]
    worst_excess: float
    duration: float
    digest: str

    @property
    def passed(self) -> bool:
        """Whether every promise was kept."""
        return not self.breaches


def play(episode: Episode, each_step: Callable[[float], None] = lambda _: None) -> Outcome:
    """Play an episode to its end; ``each_step`` hears how far it has come, in s of simulated time."""
    judge = Judge(episode)
    solver, start = episode.stage()
    state = start
    try:
        for state in _states(episode, solver, start, judge):
            each_step(state.time)
    except Exception as error:  # that nothing is raised is part of the promise, and a long run must go on
        judge.note("error", state, note=_in_a_line(error))
    return Outcome(episode, tuple(judge.breaches.values()), judge.worst_excess, state.time, state.digest)


def _states(episode: Episode, solver: ClothSolver, state: State, judge: Judge) -> Iterator[State]:
    """Every state, until the cloth is at rest, its time is up, or it is past being played with."""
    victim = Victim(episode.mesh, episode.pinned, episode.obstacles, episode.config.dt, state.position)
    abusers = [ABUSES[name](victim, episode.abuser(name)) for name in episode.abuses]
    playable = True
    for _ in range(episode.steps):
        victim.position = state.position
        state = solver.step(state, together([next(abuser) for abuser in abusers]))
        playable = judge.see(state, solver.report)
        yield state
        if not playable:
            return
    judge.calm = True
    for _ in range(math.ceil(time_to_rest(episode, state) / episode.config.dt)):
        state = solver.step(state, Inputs())
        playable = judge.see(state, solver.report)
        yield state
        if judge.at_rest or not playable:
            return
    judge.expect_rest(state)


def _in_a_line(error: Exception) -> str:
    """What was raised, and where."""
    where = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({Path(where.filename).name}:{where.lineno})"
