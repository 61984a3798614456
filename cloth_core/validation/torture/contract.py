"""What is promised whatever a user does, and how it is checked in every step.

- Positions and velocities are finite, and no step had to be thrown away (``report.recovered``).
- No limited spring is longer than ``stretch_limit`` + ``STRETCH_MARGIN`` of its rest length (default integrator).
- Left alone, the cloth comes to rest within the time that physics gives it: :func:`time_to_rest`.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cloth_core.obstacles import Plane
from cloth_core.pose import Pose
from cloth_core.report import StepReport
from cloth_core.state import State
from cloth_core.validation.scenes import GRAVITY
from cloth_core.validation.torture.episode import Episode

STRETCH_MARGIN = 0.05
# Root mean square over the mass, m/s: a millimetre in a frame of 20 ms, which nobody sees.
REST_SPEED = 0.05
# s for which it must last: longer than a pendulum of a cloth's size stands still at its turning point.
REST_TIME = 1.0
# Times longer that the paper's step may take: its viscosity brakes what turns and unfolds as well.
BRAKED = 2.0
# Below this, m/s, the kinetic energy may do what it likes: it is rounding and the last sweep.
STILL = 0.005


@dataclass(frozen=True)
class Breach:
    """One promise that an episode broke.

    Args:
        rule: finite, recovered, stretch, rest or error.
        step: first step (from 1) that broke it; for an error, the last one that went well.
        time: s of simulated time then.
        calm: whether the abuse was over by then.
        figure: the worst value in the episode.
        bound: what it should have stayed within.
        unit: of both.
        note: more about it; the message, for an error.
    """

    rule: str
    step: int
    time: float
    calm: bool
    figure: float
    bound: float = math.nan
    unit: str = ""
    note: str = ""

    def __str__(self) -> str:
        when = f"step {self.step} ({self.time:.3f} s, {'calm' if self.calm else 'abused'})"
        figure = "" if math.isnan(self.bound) else f"{self.figure:.4g} {self.unit}, at most {self.bound:.4g}"
        return f"{' '.join(part for part in (self.rule, figure, self.note) if part)}, {when}"


class Judge:
    """Watches one episode; ``breaches`` holds the first step and the worst figure of every rule that was broken."""

    def __init__(self, episode: Episode) -> None:
        self.breaches: dict[str, Breach] = {}
        self.calm = False
        """Whether the abuse is over."""
        self.worst_excess = -math.inf
        """Largest stretch so far, less the material's limit (a ratio)."""
        self._limit = episode.material.stretch_limit
        self._strict = episode.strict
        self._mass = episode.mesh.vertex_mass(episode.material)
        self._dt = episode.config.dt
        self._before: np.ndarray | None = None
        self._speeds: deque[float] = deque(maxlen=max(4, math.ceil(REST_TIME / episode.config.dt)))

    def see(self, state: State, report: StepReport) -> bool:
        """Check the outcome of a step; false if the cloth is past being played with."""
        finite = bool(np.isfinite(state.position).all() and np.isfinite(state.velocity).all())
        if not finite:
            self.note("finite", state)
        if report.recovered:
            self.note("recovered", state)
        most = self._limit + STRETCH_MARGIN
        if self._strict and not report.max_stretch <= most:
            self.note("stretch", state, figure=report.max_stretch, bound=most, unit="m/m")
        self.worst_excess = max(self.worst_excess, report.max_stretch - self._limit)
        self._speeds.append(self._speed(state) if self.calm else math.inf)
        self._before = state.position
        return finite

    def note(self, rule: str, state: State, *, figure: float = math.nan, **details: Any) -> None:
        """Keep a breach that the step which led to ``state`` committed: the first of its rule, with the worst figure.

        ``details`` are further fields of :class:`Breach`.
        """
        now = Breach(rule, state.step_index, state.time, self.calm, figure, **details)
        first = self.breaches.get(rule, now)
        self.breaches[rule] = now if first is now else replace(first, figure=max(first.figure, figure))

    def _speed(self, state: State) -> float:
        """Root mean square speed in m/s, weighted by mass: kinetic energy, made comparable.

        Of the velocities or of what one sees, the displacements, whichever is faster: a contact may push out what it
        reports as still.
        """
        seen = state.velocity if self._before is None else (state.position - self._before) / self._dt
        squares = (float(self._mass @ (motion**2).sum(axis=1)) for motion in (state.velocity, seen))
        return math.sqrt(max(squares) / float(self._mass.sum()))

    @property
    def at_rest(self) -> bool:
        """Whether the cloth was slow for ``REST_TIME``, its kinetic energy not rising."""
        speeds = np.array(self._speeds)
        if len(speeds) < (self._speeds.maxlen or 0) or speeds.max() > REST_SPEED:
            return False
        half = len(speeds) // 2
        before, after = (math.sqrt(float((part**2).mean())) for part in (speeds[:half], speeds[half:]))
        return after <= max(before, STILL)

    def expect_rest(self, state: State) -> None:
        """The time is up: the cloth must be at rest now."""
        if not self.at_rest:
            figure = max(self._speeds)
            rising = "" if figure > REST_SPEED else "and rising"
            self.note("rest", state, figure=figure, bound=REST_SPEED, unit="m/s", note=rising)


def time_to_rest(episode: Episode, state: State) -> float:
    """s that physics gives the cloth to come to rest from ``state``, generously.

    It falls to the floor, no slower than air and damping c let it: both at once h c / g + h / v + sqrt(2 h / g), with
    v the speed at which a sheet sinks face-on. What hangs is a pendulum of the cloth's length L, damped by c: from
    its speed it dies away at the rate c / 2, or g / (L c) where it is overdamped. Three times that, for a crumpled
    cloth unfolds before it swings, and twice that with other integrators than the default. What slides is slowed by c
    itself.
    """
    material, mesh = episode.material, episode.mesh
    length = float(np.linalg.norm(np.ptp(mesh.rest_position, axis=0)))
    damping = material.damping
    rate = min(0.5 * damping, GRAVITY / (length * damping))
    fastest = max(float(np.linalg.norm(state.velocity, axis=1).max()), math.sqrt(2.0 * GRAVITY * length))
    swing = math.log(fastest / REST_SPEED) / rate
    return fall_time(episode, state) + 3.0 * swing * (1.0 if episode.strict else BRAKED) + REST_TIME


def fall_time(episode: Episode, state: State) -> float:
    """s until what is free has reached the lowest floor, at the most; zero for what is pinned."""
    floors = [n for n, shape in episode.obstacles.items() if isinstance(shape, Plane)]
    if len(episode.pinned) or not floors:
        return 0.0
    floor: Pose = min((state.obstacles[name] for name in floors), key=lambda pose: pose.position[2])
    # What flies up when the calm begins falls from higher.
    rise = max(0.0, float(state.velocity[:, 2].max())) ** 2 / (2.0 * GRAVITY)
    height = max(0.0, float(state.position[:, 2].max()) - floor.position[2]) + rise
    drag = 0.5 * episode.config.air_density * episode.material.drag if len(episode.mesh.triangles) else 0.0
    sinking = drag / (episode.material.areal_density * GRAVITY)
    return height * (episode.material.damping / GRAVITY + math.sqrt(sinking)) + math.sqrt(2.0 * height / GRAVITY)
