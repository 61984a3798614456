"""The work that every engine is given: a square cloth of 1 m x 1 m, N x N vertices, and what happens to it.

SI units. One frame is 20 ms. The scenarios:

* ``hang``: horizontal at 1.5 m, two corners of one side held, 4 s;
* ``drape``: horizontal at 0.75 m, falls on a fixed sphere and the ground, 4 s;
* ``selfcol``: drape, with self-collision where the engine has it;
* ``drag``: one corner held and led round a circle of 0.3 m at 1 m/s, 4 s;
* ``crumple``: upright, dropped edge first on the ground, self-collision where offered, 3 s.
"""

from __future__ import annotations

import numpy as np

FRAME = 0.02
AREAL_DENSITY = 0.2
FRICTION = 0.3
SPHERE_CENTER = np.array([0.0, 0.0, 0.3])
SPHERE_RADIUS = 0.3
CIRCLE_RADIUS = 0.3
DRAG_SPEED = 1.0
SPIN = 20.0  # rad/s
ABUSE_BEGINS = 0.6  # s

SCENARIOS = ("hang", "drape", "selfcol", "drag", "crumple")
ABUSES = ("teleport", "nan", "spin", "stiff", "dt01")


class Scene:
    """One scenario at one size.

    Args:
        name: one of ``SCENARIOS``.
        n: vertices along each side.
        abuse: one of ``ABUSES``, or None.
        frame_dt: s.
        frames: stop after so many; 0 for the whole scenario.
    """

    def __init__(self, name: str, n: int, abuse: str | None = None, frame_dt: float = FRAME, frames: int = 0) -> None:
        self.name, self.n, self.abuse, self.frame_dt = name, n, abuse, frame_dt
        self.spacing = 1.0 / (n - 1)
        self.mass = AREAL_DENSITY
        self.sphere = name in ("drape", "selfcol")
        self.ground = name in ("drape", "selfcol", "crumple")
        self.self_collision = name in ("selfcol", "crumple")
        self.spin = SPIN if abuse == "spin" else 0.0
        seconds = 2.0 if abuse in ("teleport", "nan", "stiff", "spin") else 3.0 if name == "crumple" else 4.0
        self.whole = round(seconds / frame_dt)
        self.frames = min(frames or self.whole, self.whole)
        self.start = _start(name, n, self.spacing)
        """(n * n, 3) m: vertex i * n + j stands at column i along x and row j along y."""
        self.held = {"hang": [0, n * (n - 1)], "drag": [0]}.get(name, [])
        number = np.arange(n * n).reshape(n, n)
        self.edges = np.concatenate([_pairs(number[:-1], number[1:]), _pairs(number[:, :-1], number[:, 1:])])
        self.triangles = _triangles(number)

    def targets(self, time: float) -> np.ndarray | None:
        """Where the held vertices shall be at ``time``, (H, 3) m; None where nothing is held."""
        if not self.held:
            return None
        target = self.start[self.held].copy()
        if self.name != "drag":
            return target
        angle = DRAG_SPEED / CIRCLE_RADIUS * time
        target += CIRCLE_RADIUS * np.array([np.cos(angle) - 1, np.sin(angle), 0.0])
        if self.abuse == "teleport" and time >= ABUSE_BEGINS:
            target += [5.0, 0.0, 0.0]
        if self.abuse == "nan" and ABUSE_BEGINS <= time < ABUSE_BEGINS + 1.5 * self.frame_dt:
            target *= np.nan
        return target


def _start(name: str, n: int, spacing: float) -> np.ndarray:
    column, row = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    x, y = -0.5 + column * spacing, -0.5 + row * spacing
    if name == "crumple":  # tilted by 3 degrees, so that it folds
        tilt = np.radians(87.0)
        upright = [x, (y + 0.5) * np.cos(tilt), 0.05 + (y + 0.5) * np.sin(tilt)]
        return np.stack(upright, axis=-1).reshape(-1, 3)
    aside = np.array([0.03, 0.02, 0.0]) if name in ("drape", "selfcol") else np.zeros(3)
    height = {"hang": 1.5, "drag": 1.6}.get(name, 0.75)
    return np.stack([x, y, np.full_like(x, height)], axis=-1).reshape(-1, 3) + aside


def _pairs(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.stack([one.ravel(), other.ravel()], axis=1)


def _triangles(number: np.ndarray) -> np.ndarray:
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
