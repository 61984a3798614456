"""The ground that things stand on: a disc that fades out, with a soft shadow of all above it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyvista as pv
from scipy.ndimage import gaussian_filter

from cloth_core.pose import Pose
from cloth_sim_ros.rendering.shapes import matrix

CELLS = 1024
TONE, LINE, SHADE = 236.0, 222.0, 0.34
LINE_SPACING = 0.25


class Ground:
    """The plane z = 0 of a frame, ``radius`` m of it around ``center``, which is given in that frame.

    Args:
        plotter: what it is drawn by.
        pose: the frame; the plane faces along its z axis.
        center: (2,) m.
        radius: m.
        light: (3,) direction in the world in which light falls.
    """

    def __init__(
        self, plotter: pv.Plotter, pose: Pose, center: np.ndarray, radius: float, light: Sequence[float]
    ) -> None:
        self._pose, self._center, self._radius = pose, np.asarray(center, float), radius
        self._light = pose.rotation.T @ np.asarray(light, float)
        sheet = pv.Plane(center=(*self._center, 0.0), i_size=2 * radius, j_size=2 * radius)
        self._actor = plotter.add_mesh(sheet, lighting=False, texture=pv.Texture(np.zeros((2, 2, 4), np.uint8)))
        self._actor.user_matrix = matrix(pose)
        self._cell = 2.0 * radius / CELLS
        at = (np.arange(CELLS) + 0.5) * self._cell - radius
        x, y = np.meshgrid(at, at[::-1])
        self._tone = self._lines(x + self._center[0], y + self._center[1])
        away = np.hypot(x, y) / radius
        self._alpha = 255.0 * np.clip((1.0 - away) / 0.6, 0.0, 1.0) ** 1.5

    def _lines(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        half = 0.5 * self._cell
        share = np.zeros_like(x)
        for along in (x, y):
            off = np.abs((along + 0.5 * LINE_SPACING) % LINE_SPACING - 0.5 * LINE_SPACING)
            share = np.maximum(share, np.clip(1.2 - off / half, 0.0, 1.0))
        return TONE + (LINE - TONE) * share

    def cast_shadow(self, points: np.ndarray) -> None:
        """Darken the ground where ``points`` (N, 3) m, dense enough to be a surface, keep the light off."""
        local = self._pose.inverse_apply(points)
        local = local[local[:, 2] > -1e-3]
        hit = local[:, :2] - local[:, 2:] * (self._light[:2] / self._light[2]) - self._center
        column = ((hit[:, 0] + self._radius) / self._cell).astype(int)
        row = CELLS - 1 - ((hit[:, 1] + self._radius) / self._cell).astype(int)
        inside = (column >= 0) & (column < CELLS) & (row >= 0) & (row < CELLS)
        covered = np.bincount(row[inside] * CELLS + column[inside], minlength=CELLS * CELLS) > 0
        shade = gaussian_filter(covered.reshape(CELLS, CELLS).astype(np.float32), 0.03 / self._cell)
        tone = self._tone * (1.0 - SHADE * np.clip(1.3 * shade, 0.0, 1.0))
        image = np.empty((CELLS, CELLS, 4), np.uint8)
        image[..., :3] = tone[..., None]
        image[..., 3] = np.maximum(self._alpha, 0.0)
        texture = pv.Texture(image)
        texture.interpolate = texture.mipmap = True
        self._actor.texture = texture


def surface_points(points: np.ndarray, triangles: np.ndarray, spacing: float = 0.006) -> np.ndarray:
    """(N, 3) points spread evenly over a surface, in the same places of each triangle every time.

    Args:
        points: (V, 3) vertices, m.
        triangles: (T, 3).
        spacing: mean distance of neighbouring points, m.
    """
    corner = points[triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = 0.5 * np.linalg.norm(np.cross(a, b), axis=1)
    count = np.ceil(area / spacing**2).astype(int)
    owner = np.repeat(np.arange(len(triangles)), count)
    # The additive recurrence of the plastic number covers the square evenly; its upper half is folded back.
    share = (np.arange(1, len(owner) + 1)[:, None] * [0.7548776662466927, 0.5698402909980532]) % 1.0
    share = np.where(share.sum(axis=1, keepdims=True) > 1.0, 1.0 - share, share)
    return corner[owner, 0] + share[:, :1] * a[owner] + share[:, 1:] * b[owner]
