"""Wind: the flow at every vertex, with gusts, and the drag it causes (paper, 4.1)."""

from __future__ import annotations

import functools
import math

import numpy as np

from cloth_core.inputs import Wind
from cloth_core.kernels import surface

GUST_MODES = 12


def capped(wind: Wind, max_speed: float) -> tuple[np.ndarray, bool]:
    """The mean velocity (3,) m/s within ``max_speed``, and whether it had to be capped."""
    velocity = np.array(wind.velocity)
    speed = float(np.linalg.norm(velocity))
    return (velocity * (max_speed / speed), True) if speed > max_speed else (velocity, False)


def flow_at(position: np.ndarray, wind: Wind, time: float, max_speed: float, flow: np.ndarray) -> bool:
    """Velocity of the air at every vertex into ``flow`` (V, 3) m/s; returns whether the mean was capped.

    Gusts are a sum of waves that drift with the mean wind (Taylor's frozen turbulence) and change within
    ``gust_time``. Their root mean square in all three directions together is ``gust_intensity`` times
    the mean speed, and no instant exceeds ``max_speed`` by more than the gusts' largest sum.
    """
    mean, was_capped = capped(wind, max_speed)
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
