"""Contacts with obstacles that are distance fields (paper, 4.2): their part of :mod:`cloth_core.physics.contacts`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core.errors import MeshError, SettingError
from cloth_core.fields import Field, pooled
from cloth_core.kernels import field_approach, field_contact
from cloth_core.kernels.bodies import Bodies
from cloth_core.kernels.contact import Points
from cloth_core.kernels.field_approach import Course
from cloth_core.obstacles import FIELD, Obstacle


class FieldContacts:
    """The fields among the obstacles of a scene, in one pool; they are the bodies from ``first`` on.

    Args:
        obstacles: by name, fields last, in the order of the bodies.
        shell: m, of the contacts. Fields are exact as far as twice that from the surface.
        vertices: of the cloth.
        edges: of the cloth.
        between: whether edges and triangles are looked at, too.

    Raises:
        SettingError: a field would have too many voxels; the message names the obstacle and what would fit.
        MeshError: a mesh is refused; the message names obstacle, file and fault.
    """

    def __init__(
        self, obstacles: Mapping[str, Obstacle], shell: float, vertices: int, edges: int, between: bool
    ) -> None:
        fields = {name: shape for name, shape in obstacles.items() if shape.kind == FIELD}
        self.first = len(obstacles) - len(fields)
        self.pool = pooled([_made(name, shape, 2.0 * shell) for name, shape in fields.items()])
        self._between, self._shell, count = between, shell, len(fields)
        self._course = Course(
            last=np.zeros((vertices, 3)),
            passed=np.zeros(vertices),
            gone=np.zeros(count),
            clear=np.zeros((count, edges)),
            fresh=np.ones(count, np.bool_),
            near=np.zeros(edges, np.bool_),
        )
        self._seen, self._begin = np.zeros((0, 7)), 0

    def __len__(self) -> int:
        return len(self.pool.real)

    def begin_step(self) -> None:
        """Forget what was known of the step before: a step depends on nothing but its state and its inputs."""
        self._course.last[:] = np.nan
        self._course.gone[:] = 0.0
        self._course.fresh[:] = True

    def begin_substep(self, travel: np.ndarray) -> None:
        """The fields have moved by up to ``travel`` (O,) m of all bodies since the last substep began."""
        self._course.gone[:] += travel[self.first :]

    def find(
        self, start: np.ndarray, predicted: np.ndarray, sheet: tuple, bodies: Bodies, recover: float,
        points: Points, count: int, room: tuple[np.ndarray, ...],
    ) -> int:  # fmt: skip
        """Add to the first ``count`` points what may touch a field; returns how many there are then.

        ``sheet`` and ``room`` are what the kernel needs of the cloth, and to work in.
        """
        self._begin = count
        if len(self) == 0:
            return count
        count = field_approach.find_field_points(
            start, predicted, *sheet, bodies, self.first, *self.pool, self._between, self._shell, recover,
            points, count, *room, self._course,
        )  # fmt: skip
        if len(self._seen) < count:
            self._seen = np.zeros((2 * count, 7))
        self._seen[self._begin : count] = np.nan
        return count

    def push_out(
        self, position: np.ndarray, bodies: Bodies, points: Points, count: int, inverse_mass: np.ndarray
    ) -> float:
        """Bring what is too deep in a field back to the shell, in place; returns the farthest push in m."""
        if self._begin == count:
            return 0.0
        return field_contact.push_out_of_fields(
            position, bodies, self.first, *self.pool, points, self._begin, count, inverse_mass, self._shell,
            self._seen,
        )  # fmt: skip


def _made(name: str, shape: Obstacle, band: float) -> Field:
    try:
        return shape.made(band=band)  # type: ignore[attr-defined]
    except SettingError as error:
        raise error.under(f"obstacles.{name}") from None
    except MeshError as error:
        raise MeshError(f"obstacles.{name}: {error}") from error
