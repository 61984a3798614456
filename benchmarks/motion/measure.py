"""Letting a contestant, or the solver itself, play the release test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig
from motion.cloth import GRAVITY, MASS, SIDE, Cloth, release_test
from motion.contestants import Contestant
from motion.stage import Stage

STIFFNESSES = (200, 2000)  # N/m
BARS = {200: (0.010, 0.004), 2000: (0.050, 0.015)}  # m: the bar and the aim at ten solves a frame
FRAME, SAMPLED, SECONDS = 0.02, 5, 1.0  # s, every so many frames, s
RELEASED = MASS * -GRAVITY[2] * SIDE / 2  # J, about what the cloth loses from level to hanging
LOST = 10.0 * RELEASED

Frames = Iterator[tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Play:
    """What one run showed, frame by frame.

    Args:
        height: mean over the vertices, m.
        energy: in ``RELEASED``; the true motion keeps 0, a cloth that hangs still has about -1.
        stretch: the most stretched thread so far.
    """

    height: np.ndarray
    energy: np.ndarray
    stretch: float


@dataclass(frozen=True)
class Score:
    """A split of a budget and its errors.

    Args:
        substeps: in a frame.
        iterations: solves in a stage.
        error: m, by stiffness; infinite if the run blew up.
    """

    substeps: int
    iterations: int
    error: dict[int, float]

    @property
    def in_bars(self) -> float:
        """The worse error, as a multiple of its bar."""
        return max(error / BARS[k][0] for k, error in self.error.items())


def play(cloth: Cloth, frames: Frames, seconds: float = SECONDS) -> Play | None:
    """Watch for so long; None if the motion blows up."""
    height, energy, stretch = [], [], 1.0
    with np.errstate(all="ignore"):  # what blows up overflows first
        for x, v in islice(frames, round(seconds / FRAME)):
            height.append(x[:, 2].mean())
            energy.append(cloth.energy(x, v) / RELEASED)
            stretch = max(stretch, cloth.stretch(x))
            if not abs(energy[-1]) < LOST / RELEASED:
                return None
    return Play(np.array(height), np.array(energy), stretch)


def frames_of(cloth: Cloth, contestant: Contestant, substeps: int, iterations: int, *, hinge: bool) -> Frames:
    """x and v (V, 3) after each frame of a contestant's motion."""
    stage = Stage(cloth, contestant.minimiser(), iterations, hinge=hinge, **contestant.tweaks)
    return islice(contestant.integrator(cloth, FRAME / substeps, stage), substeps - 1, None, substeps)


def solver_of(cloth: Cloth, substeps: int, iterations: int) -> ClothSolver:
    """The default solver for a cloth, through its public interface; air, damping and stretch limit off."""
    mesh = ClothMesh.from_springs(
        cloth.start, cloth.ends, stiffness=cloth.stiffness, mass=cloth.mass, rest_length=cloth.rest, limited=False
    )
    config = SolverConfig(dt=FRAME, substeps=substeps, iterations=iterations, air_density=0.0)
    solver = ClothSolver(mesh, Material(stretch_damping=0.0), config)
    solver.pin(cloth.pins)
    return solver


def frames_of_solver(cloth: Cloth, substeps: int, iterations: int = 1) -> Frames:
    """As :func:`frames_of` of that solver; 0 leaves substeps or iterations to it."""
    solver = solver_of(cloth, substeps, iterations)
    state = solver.initial_state()
    while True:
        state = solver.step(state, Inputs())
        yield state.position, state.velocity + state.history["lag"]


def rms_error(played: Play | None, reference: np.ndarray) -> float:
    """Of the mean height over the first second, every 0.1 s, m."""
    if played is None:
        return float("inf")
    sampled = played.height[SAMPLED - 1 : round(SECONDS / FRAME) : SAMPLED]
    return float(np.sqrt(np.mean((sampled - reference) ** 2)))


def best_split(contestant: Contestant, solves: int, references: dict[int, np.ndarray], *, hinge: bool) -> Score:
    """The split of ``solves`` a frame that errs least."""
    scores = []
    for iterations in contestant.iterations:
        substeps = contestant.substeps(solves, iterations)
        error = {}
        for k, reference in references.items():
            cloth = release_test(k)
            played = play(cloth, frames_of(cloth, contestant, substeps, iterations, hinge=hinge))
            error[k] = rms_error(played, reference)
        scores.append(Score(substeps, iterations, error))
    return min(scores, key=lambda score: score.in_bars)


def score_of_solver(solves: int, references: dict[int, np.ndarray]) -> Score:
    """The default solver with one solve a substep, or for 0 ``solves`` a frame as it comes."""
    split = (solves, 1) if solves else (0, 0)
    plays = {k: play(cloth := release_test(k), frames_of_solver(cloth, *split)) for k in references}
    return Score(*split, {k: rms_error(played, references[k]) for k, played in plays.items()})


def solves_of_solver(cloth: Cloth, substeps: int, iterations: int) -> float:
    """Solves with W in a frame, on the average over the test."""
    solver = solver_of(cloth, substeps, iterations)
    state = solver.initial_state()
    solver.prepare(state)
    count = 0

    def counting(solve: Callable[..., None]) -> Callable[..., None]:
        def counted(*arguments: Any) -> None:
            nonlocal count
            count += 1
            solve(*arguments)

        return counted

    for one in solver._model._filters:
        one.solve = counting(one.solve)
    frames = round(SECONDS / FRAME)
    for _ in range(frames):
        state = solver.step(state, Inputs())
    return count / frames


def swing(frames: Callable[[Cloth], Frames], seconds: float) -> dict[int, Play | None]:
    """Long runs, by stiffness: does what swings keep its energy?"""
    return {k: play(cloth := release_test(k), frames(cloth), seconds) for k in STIFFNESSES}
