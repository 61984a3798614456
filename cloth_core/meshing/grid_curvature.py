"""Readings of curvature on a grid: the finite differences of a plate."""

from __future__ import annotations

import numpy as np

from cloth_core.meshing.curvature import Readings


def readings(number: np.ndarray, dx: float, dy: float) -> Readings:
    """As :func:`cloth_core.meshing.curvature.readings`, of vertices ``number`` (rows, columns) ``dx``, ``dy`` m apart.

    Second differences along rows and columns, and the twist of every cell, counted twice: |H|^2 of the same plate.
    """
    cell = dx * dy
    straight = np.array([1.0, -2.0, 1.0])
    across, up = _shares(number.shape[1]), _shares(number.shape[0])
    border_up, border_across = _halved(number.shape[0]), _halved(number.shape[1])
    along_x = np.stack([number[:, :-2], number[:, 1:-1], number[:, 2:]], axis=-1).reshape(-1, 3)
    along_y = np.stack([number[:-2], number[1:-1], number[2:]], axis=-1).reshape(-1, 3)
    twisted = np.stack([number[:-1, :-1], number[1:, 1:], number[:-1, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    weight_x = np.sqrt(cell * np.outer(border_up, across)).reshape(-1, 1) * straight / dx**2
    weight_y = np.sqrt(cell * np.outer(up, border_across)).reshape(-1, 1) * straight / dy**2
    weight_twist = np.tile(np.sqrt(2.0 * cell) / cell * np.array([1.0, 1.0, -1.0, -1.0]), (len(twisted), 1))
    return Readings.joined([along_x, along_y, twisted], [weight_x, weight_y, weight_twist])


def _shares(count: int) -> np.ndarray:
    """(count - 2,): cells that each inner place of a row answers for; the outermost for the ends, too."""
    share = np.ones(max(count - 2, 0))
    share[:1] += 0.5
    share[-1:] += 0.5
    return share


def _halved(count: int) -> np.ndarray:
    """(count,): cells that each place across a row answers for; half of one at the border."""
    share = np.ones(count)
    share[[0, -1]] = 0.5
    return share
