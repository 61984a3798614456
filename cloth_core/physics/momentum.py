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
        kind, center, along = kernels.hinges(place, held, self._component, self._count, COLLINEAR)
        chosen = (kind == 1) | (kind == 2)
        if not chosen.any():
            return
        inertia, twist = kernels.moments_about(place, error, self._mass, self._component, center, chosen)
        _, turn = kernels.rigid_motion(chosen.astype(float), np.zeros_like(center), inertia, twist)
        kernels.turn_about_lines(kind, along, inertia, twist, turn)
        kept = moved[held]
        kernels.add_rigid_displacement(place, center, np.zeros_like(center), turn, self._component, chosen, moved)
        moved[held] = kept
