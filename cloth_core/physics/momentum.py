"""The little push that gives back the momentum a constant W loses (paper, 3.2 and Fig. 4)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import momentum as kernels
from cloth_core.mesh import ClothMesh

COLLINEAR = 1e-6
"""Held vertices closer to one line than this share of their extent leave the turn about it free."""


class MomentumBalance:
    """Corrects displacements so that internal forces change no momentum that only a force from outside may change.

    The paper's correction lacks the inverse inertia, without which it explodes at moderate stiffness;
    here the spurious impulse is removed by the rigid motion that carries exactly that impulse. Which motions those
    are depends on what is held: a free part keeps both momenta, one that hangs on a point keeps the angular momentum
    about that point, one that hangs on two or on a straight edge the angular momentum about that line.
    """

    def __init__(self, mesh: ClothMesh, mass: np.ndarray) -> None:
        self._component = mesh.component
        self._count = int(self._component.max()) + 1
        self._mass = mass

    def correct(
        self, place: np.ndarray, inertial: np.ndarray, moved: np.ndarray, held: np.ndarray, *, hanging: bool = True
    ) -> None:
        """Add to ``moved`` the rigid displacement that gives it the momenta of ``inertial``.

        Args:
            place: (V, 3) m, where the internal forces act: the torque is taken there.
            inertial: (V, 3) m, where inertia and external forces alone lead.
            moved: (V, 3) m, where the filtered internal forces led; corrected in place, but for held vertices.
            held: vertices that are pinned or grasped.
            hanging: correct parts that hang on a point or a line, too; the paper corrects free ones alone.
        """
        free = np.ones(self._count, dtype=np.bool_)
        free[self._component[held]] = False
        error = inertial - moved
        if free.any():
            total, center, drift, inertia, twist = kernels.moments(
                place, error, self._mass, self._component, free, self._count
            )
            shift, turn = kernels.rigid_motion(total, drift, inertia, twist)
            kernels.add_rigid_displacement(place, center, shift, turn, self._component, free, moved)
        if hanging and not free.all():
            self._correct_hanging(place, error, moved, held)

    def _correct_hanging(self, place: np.ndarray, error: np.ndarray, moved: np.ndarray, held: np.ndarray) -> None:
        center, axis = np.zeros((self._count, 3)), {}
        for component in np.unique(self._component[held]):
            points = place[held[self._component[held] == component]]
            center[component], found = _pivot(points)
            if found is not None:
                axis[component] = found
        if not axis:
            return
        chosen = np.zeros(self._count, dtype=np.bool_)
        chosen[list(axis)] = True
        inertia, twist = kernels.moments_about(place, error, self._mass, self._component, center, chosen)
        turn = np.zeros_like(center)
        for component, free_axes in axis.items():
            resisting = free_axes @ inertia[component] @ free_axes.T
            turn[component] = free_axes.T @ np.linalg.pinv(resisting, hermitian=True) @ (free_axes @ twist[component])
        kept = moved[held]
        kernels.add_rigid_displacement(
            place, center, np.zeros_like(center), turn, self._component, chosen, moved
        )
        moved[held] = kept


def _pivot(points: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """A point about which a part that is held at ``points`` (K, 3) can turn, and the free axes (1 or 3, 3), if any."""
    center = points[0]
    arms = points - center
    reach = np.linalg.norm(arms, axis=1)
    far = int(reach.argmax())
    if reach[far] == 0.0:
        return center, np.eye(3)
    along = arms[far] / reach[far]
    off = np.linalg.norm(np.cross(arms, along), axis=1).max()
    return center, along[None] if off <= COLLINEAR * reach[far] else None
