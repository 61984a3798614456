"""What a hand is to feel of the cloth that it holds: a wrench, and how strongly its controller hums."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cloth_core.report import Wrench
from cloth_sim_ros.simulation.frame import Frame

STEADY_S = 0.2
"""A force that lasts longer is no longer felt as a hum: what a hand carries shall not make it numb."""
CAUGHT = (0.4, 0.06)
"""Intensity and s of the hum when cloth is caught."""
SLIPPED = (1.0, 0.2)
"""The same when it is lost."""
TAUT = 0.3
"""Least intensity while a hand is held back because the cloth reaches no farther."""


@dataclass
class _Felt:
    """One hand's past."""

    steady: np.ndarray = field(default_factory=lambda: np.zeros(3))
    held: int = 0
    pulse: float = 0.0
    pulse_left: float = 0.0


class Haptics:
    """Turns what steps report into what hands feel, frame by frame."""

    def __init__(self) -> None:
        self._felt: dict[str, _Felt] = {}
        self._last = -1

    def wrenches(self, frame: Frame) -> dict[str, Wrench]:
        """Wrench of the cloth on every hand, N and N m, about the grip's origin and along its axes."""
        turned = {}
        for name, wrench in frame.report.grasp_wrenches.items():
            to_hand = frame.state.grips[name].pose.rotation.T
            turned[name] = Wrench(_along(to_hand, wrench.force), _along(to_hand, wrench.torque))
        return turned

    def rumble(self, frame: Frame, dt: float, full: float) -> dict[str, float]:
        """Intensity 0..1 for every hand: of changes of the force, of catching and losing cloth, of cloth pulled taut.

        Args:
            frame: the newest one; every frame is to be told once. One that does not follow the last begins anew.
            dt: s since the one before.
            full: N, a change of force that hums fully.
        """
        if frame.step_index != self._last + 1:
            self._felt.clear()
        self._last = frame.step_index
        slipped = frame.report.slipped
        return {
            name: self._hum(name, frame, force, name in slipped, dt, full) for name, force in _forces(frame).items()
        }

    def _hum(self, name: str, frame: Frame, force: np.ndarray, slipped: bool, dt: float, full: float) -> float:
        felt = self._felt.setdefault(name, _Felt())
        held = len(frame.state.grips[name].vertex)
        if slipped:
            felt.pulse, felt.pulse_left = SLIPPED
        elif held > felt.held:
            felt.pulse, felt.pulse_left = CAUGHT
        change = math.hypot(*(force - felt.steady)) / full
        felt.steady += (1.0 - math.exp(-dt / STEADY_S)) * (force - felt.steady)
        intensity = max(change, TAUT if name in frame.report.taut else 0.0)
        if felt.pulse_left > 0.5 * dt:
            intensity = max(intensity, felt.pulse)
        felt.pulse_left, felt.held = felt.pulse_left - dt, held
        return min(1.0, intensity)


def _forces(frame: Frame) -> Mapping[str, np.ndarray]:
    return {name: np.array(wrench.force) for name, wrench in frame.report.grasp_wrenches.items()}


def _along(axes: np.ndarray, vector: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in axes @ np.array(vector))
    return x, y, z
