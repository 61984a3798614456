"""Wind: the flow at every vertex, with gusts, and the drag it causes (paper, 4.1)."""

from __future__ import annotations

import functools
import math

import numpy as np

from cloth_core.inputs import Wind
from cloth_core.kernels import surface

GUST_MODES = 12


def capped(velocity: tuple[float, float, float], limit: float) -> tuple[tuple[float, float, float], bool]:
    """``velocity`` m/s, no faster than ``limit`` m/s in the same direction; and whether it was faster."""
    if math.hypot(*velocity) <= limit * (1.0 + 1e-12):  # what was capped before is not faster by its last digit
        return velocity, False
    largest = max(abs(c) for c in velocity)
    direction = [c / largest for c in velocity]  # the length of the largest floats would overflow
    scale = limit / math.hypot(*direction)
    return tuple(c * scale for c in direction), True  # type: ignore[return-value]


def flow_at(position: np.ndarray, wind: Wind, time: float, max_speed: float, flow: np.ndarray) -> bool:
    """Velocity of the air at every vertex into ``flow`` (V, 3) m/s; returns whether the mean was capped.

    Gusts are a sum of waves that drift with the mean wind (Taylor's frozen turbulence) and change within
    ``gust_time``. Their root mean square in all three directions together is ``gust_intensity`` times
    the mean speed, and no instant exceeds ``max_speed`` by more than the gusts' largest sum.
    """
    velocity, was_capped = capped(wind.velocity, max_speed)
    mean = np.array(velocity)
    speed = float(np.linalg.norm(mean))
    wave, frequency, phase, amplitude = _gust_modes(wind.gust_seed)
    if wind.gust_intensity == 0.0 or speed == 0.0:
        flow[:] = mean
        return was_capped
    wave = wave / wind.gust_length
    frequency = frequency / wind.gust_time + wave @ mean
    surface.gust_flow(position, time, mean, wave, frequency, phase, amplitude * (wind.gust_intensity * speed), flow)
    return was_capped


@functools.lru_cache(maxsize=64)
def _gust_modes(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Unit gusts: wave vectors (rad), frequencies (rad), phases (rad) and amplitudes whose rms is one."""
    random = np.random.default_rng(seed)
    direction = random.normal(size=(GUST_MODES, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    wave = 2 * math.pi * direction * random.uniform(0.3, 1.5, (GUST_MODES, 1))
    frequency = 2 * math.pi * random.uniform(0.2, 1.2, GUST_MODES)
    phase = random.uniform(0, 2 * math.pi, GUST_MODES)
    amplitude = random.normal(size=(GUST_MODES, 3))
    amplitude /= math.sqrt(0.5 * (amplitude**2).sum())
    return wave, frequency, phase, amplitude
