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
        self._component, self._mass = mesh.component, mass
        changes = np.flatnonzero(np.diff(self._component)) + 1
        begins, ends = np.append(0, changes), np.append(changes, len(self._component))
        self._runs = np.column_stack([begins, ends, self._component[begins]]).astype(np.int64)

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
        kernels.balance(
            place, inertial, moved, self._mass, self._runs, self._component, held.astype(np.int64), hanging, COLLINEAR
        )
