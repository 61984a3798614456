"""The little push that gives back the momentum a constant W loses (paper, 3.2 and Fig. 4)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import momentum as kernels
from cloth_core.mesh import ClothMesh


class MomentumBalance:
    """Corrects displacements of the free components so that internal forces leave both momenta alone.

    The paper's correction lacks the inverse inertia, without which it explodes at moderate stiffness;
    here the spurious angular impulse is removed by the rigid rotation that carries exactly that impulse.
    Components with a held vertex are left alone: there an external torque is legitimate.
    """

    def __init__(self, mesh: ClothMesh, mass: np.ndarray) -> None:
        self._component = mesh.component
        self._count = int(self._component.max()) + 1
        self._mass = mass

    def correct(self, start: np.ndarray, inertial: np.ndarray, moved: np.ndarray, held: np.ndarray) -> None:
        """Add to ``moved`` the rigid displacement that gives it the momenta of ``inertial`` about ``start``.

        Args:
            start: (V, 3) m, positions at the start of the substep.
            inertial: (V, 3) m, where inertia and external forces alone lead.
            moved: (V, 3) m, where the filtered internal forces led; corrected in place.
            held: vertices that are pinned or grasped.
        """
        chosen = np.ones(self._count, dtype=np.bool_)
        chosen[self._component[held]] = False
        if not chosen.any():
            return
        total, center, drift, inertia, twist = kernels.moments(
            start, inertial - moved, self._mass, self._component, chosen, self._count
        )
        shift, turn = kernels.rigid_motion(total, drift, inertia, twist)
        kernels.add_rigid_displacement(start, center, shift, turn, self._component, chosen, moved)
