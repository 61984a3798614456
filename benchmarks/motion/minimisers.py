"""Ways to spend solves with W on the minimum of Phi; each starts at z, and none searches along a line.

All take the objective, W, the start and the number of solves. W is the Hessian of Phi with every spring's direction
left free, so z - W grad Phi(z) is one local/global iteration (Liu, Bargteil, O'Brien and Kavan 2013).
"""

from __future__ import annotations

from collections import deque

import numpy as np

from motion.stage import Field, Minimiser, Objective

Pair = tuple[np.ndarray, np.ndarray, float]


def local_global(phi: Objective, w: Field, z: np.ndarray, iterations: int) -> np.ndarray:
    """z <- z - W grad Phi(z)."""
    for _ in range(iterations):
        z = z - w(phi.gradient(z))
    return z


def chebyshev(radius: float) -> Minimiser:
    """Semi-iteration for a contraction of spectral radius ``radius`` (Wang 2015, without his delayed start)."""

    def minimise(phi: Objective, w: Field, z: np.ndarray, iterations: int) -> np.ndarray:
        before, omega = z, 1.0
        for number in range(iterations):
            plain = z - w(phi.gradient(z))
            z, before = omega * (plain - before) + before, z
            omega = 2.0 / (2.0 - radius**2) if number == 0 else 4.0 / (4.0 - radius**2 * omega)
        return z

    return minimise


def anderson(window: int) -> Minimiser:
    """Mix the last ``window`` differences so that the residual is least; fall back if Phi rose (Peng et al. 2018)."""

    def minimise(phi: Objective, w: Field, z: np.ndarray, iterations: int) -> np.ndarray:
        changes: deque[tuple[np.ndarray, np.ndarray]] = deque(maxlen=window)
        plain, residual, lowest = z, None, np.inf
        for _ in range(iterations):
            if phi(z) > lowest:
                z = plain
            lowest = phi(z)
            last_plain, last_residual = plain, residual
            residual = -w(phi.gradient(z))
            plain = z + residual
            if last_residual is not None:
                changes.append((residual - last_residual, plain - last_plain))
            z = plain - _mixture(changes, residual)
        return plain if phi(z) > phi(plain) else z

    return minimise


def lbfgs(memory: int, *, keep: bool = False) -> Minimiser:
    """Quasi-Newton on W (Liu, Bouaziz and Kavan 2017); ``keep`` carries the curvature pairs over to the next stage."""
    kept: deque[Pair] = deque(maxlen=memory)

    def minimise(phi: Objective, w: Field, z: np.ndarray, iterations: int) -> np.ndarray:
        pairs = kept if keep else deque(maxlen=memory)
        gradient = phi.gradient(z)
        for number in range(iterations):
            step = -_two_loops(pairs, w, gradient)
            z, last = z + step, gradient
            if keep or number + 1 < iterations:
                gradient = phi.gradient(z)
                _remember(pairs, step, gradient - last)
        return z

    return minimise


def _mixture(changes: deque[tuple[np.ndarray, np.ndarray]], residual: np.ndarray) -> np.ndarray | float:
    if not changes:
        return 0.0
    of_residual = np.stack([change.ravel() for change, _ in changes])
    share = np.linalg.lstsq(of_residual @ of_residual.T, of_residual @ residual.ravel(), rcond=1e-14)[0]
    return sum(s * change for s, (_, change) in zip(share, changes, strict=True))


def _remember(pairs: deque[Pair], step: np.ndarray, change: np.ndarray) -> None:
    curvature = float((step * change).sum())
    if curvature > 1e-10 * np.sqrt((step * step).sum() * (change * change).sum()):
        pairs.append((step, change, 1.0 / curvature))


def _two_loops(pairs: deque[Pair], w: Field, gradient: np.ndarray) -> np.ndarray:
    """The inverse Hessian that the pairs make of W, times the gradient."""
    shares = []
    for step, change, scale in reversed(pairs):
        shares.append(scale * (step * gradient).sum())
        gradient = gradient - shares[-1] * change
    direction = w(gradient)
    for (step, change, scale), share in zip(pairs, reversed(shares), strict=True):
        direction = direction + (share - scale * (change * direction).sum()) * step
    return direction
