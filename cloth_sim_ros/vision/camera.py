"""A camera: where it stands, and how it maps points to pixels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cloth_core import Pose

NEAR = 0.01
"""m in front of the camera from which on it sees."""


@dataclass(frozen=True)
class Lens:
    """A pinhole: sensor_msgs/CameraInfo without distortion, as of a rectified image.

    Args:
        width: pixels.
        height: pixels.
        fx: focal length in pixels, across.
        fy: and down.
        cx: principal point in pixels, from the left.
        cy: and from the top.
    """

    width: int = 640
    height: int = 480
    fx: float = 554.26
    fy: float = 554.26
    cx: float = 319.5
    cy: float = 239.5

    def project(self, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (N, 2) of points (N, 3) m in the optical frame, and whether they are in the image, in front of it."""
        depth = seen[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            u = self.fx * seen[:, 0] / depth + self.cx
            v = self.fy * seen[:, 1] / depth + self.cy
            inside = (depth > NEAR) & (u >= -0.5) & (u < self.width - 0.5) & (v >= -0.5) & (v < self.height - 0.5)
        return np.stack([u, v], axis=1), inside


@dataclass
class Viewpoint:
    """The camera as it was told last; each field is replaced as a whole, so it may be read at any time.

    Args:
        pose: of the optical frame (z ahead, x to the right, y down) in the cloth's frame; None before it is known.
        lens: how it maps points.
        follows_topic: the pose came by a topic of its own.
    """

    pose: Pose | None = None
    lens: Lens = Lens()
    follows_topic: bool = False
