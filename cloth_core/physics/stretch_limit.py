"""The stretch limit: no thread gets longer than its material allows (paper, 3.3)."""

from __future__ import annotations

import numpy as np

from cloth_core.kernels import springs as kernels
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.physics.rest_scale import RestShape

FADE = 0.97
"""Share of a limit's tension that the next substep starts with. A tension that only ever adds up lags behind what it
limits by a quarter of a period, and so pumps energy into what swings."""
YIELDING = 3.0
"""Multiple of what it grows with, by which a limit's tension lets go of a thread that shortens. What adds up lags: it
hauls a thread in with more than it held it with on its way out, which is negative damping of about stiffness / (h w^2)
at w 1/s. FADE / (1 - FADE), 32, would leave no lag at all; that much trembles."""
STEADY = 1e-4
"""Share of its length by which a thread may shorten in a substep before its tension lets go: what hangs still does."""
SHARE = 0.8
"""Of the stiffness of a sheet along its threads, with which a limit's tension grows. As much as W holds them with, and
long steps with one pass of one iteration come to no rest; the less, the more of an excess stays."""


SLACK = 0.02
"""What is shorter than its longest by more than this share is left out of a substep's sweeps."""


RECOVERY = 1.5
"""1/s, share of its length by which an overlong thread shortens at most: what brings it back corrects its length and is
no impulse. Left in the velocity it would keep a cloth that was torn about in motion for ever."""


class HeldMasses:
    """How easily vertices give way to corrections: by their mass, and not at all where they are held.

    Args:
        mass: (V,) kg.
    """

    def __init__(self, mass: np.ndarray) -> None:
        self._free_inverse_mass = 1.0 / mass
        self.hold(np.zeros(0, dtype=np.int32))

    def hold(self, held: np.ndarray) -> None:
        """From now on these vertices stay and the other end moves all the way."""
        self._inverse_mass = self._free_inverse_mass.copy()
        self._inverse_mass[held] = 0.0


class StretchLimit(HeldMasses):
    """Shortens overlong springs in place, in a fixed order that alternates so that corrections cross the cloth."""

    def __init__(self, mesh: ClothMesh, material: Material, mass: np.ndarray) -> None:
        super().__init__(mass)
        self._vertex = mesh.spring_ends
        self._limited = np.flatnonzero(mesh.spring_limited).astype(np.uint32)
        # That of the cloth along the thread, whatever part of it the diagonals of a grid have.
        sheet = SHARE * np.array(material.sheet_stiffness())
        self._stiffness = np.maximum(mesh.spring_weight, 0.0) @ np.array([*sheet, 1.0])
        self._stretch_limit = material.stretch_limit
        self.resize(RestShape.of(mesh))
        self._taut, self._room = self._limited, np.empty_like(self._limited)

    def resize(self, rest: RestShape) -> None:
        """Compute with other rest lengths from now on."""
        self._longest = rest.spring_rest * self._stretch_limit
        self._shortest = (1.0 - SLACK) * self._longest
        # What the spring would pull with at twice its length: more would outweigh W.
        self._strongest = self._stiffness * rest.spring_rest

    def slack(self) -> np.ndarray:
        """(S,) N, no tension yet."""
        return np.zeros(len(self._longest))

    def find(self, position: np.ndarray, tension: np.ndarray) -> None:
        """Find what :meth:`carry` and :meth:`sweep` shall look at: the springs under tension, or nearly overlong.

        Args:
            position: (V, 3) m.
            tension: (S,) N, by which springs at their limit pull beyond their stiffness.
        """
        count = kernels.find_taut(position, self._limited, self._vertex, self._shortest, tension, self._room)
        self._taut = self._room[:count]

    def carry(self, start: np.ndarray, position: np.ndarray, tension: np.ndarray) -> None:
        """Update the ``tension`` (S,) N in place, after a substep from ``start`` to ``position`` (V, 3) m.

        Sweeps are local: what hangs on a few threads, they would have to lift anew in every substep, and they
        fall behind. What lasts is therefore carried by forces that W spreads over the cloth.
        """
        kernels.carry_limit(
            start, position, self._taut, self._vertex, self._longest, self._stiffness, self._strongest,
            FADE, YIELDING, STEADY, tension,
        )  # fmt: skip

    def sweep(self, position: np.ndarray, number: int) -> float:
        """One pass over ``position`` (V, 3); odd numbers run backwards. Returns the worst excess it met (a ratio)."""
        return kernels.shorten_springs(
            position, self._taut, self._vertex, self._longest, self._inverse_mass, number % 2 == 1
        )

    def calm(self, position: np.ndarray, velocity: np.ndarray, lag: np.ndarray) -> None:
        """End as an inelastic impact what threads over their limit did in a substep.

        What brings them back too fast is taken out of ``velocity`` (V, 3) m/s, in place. The ``lag`` (V, 3) m/s of
        their ends is dropped: it would go on with an acceleration that the limit has answered already, and nothing in
        the midpoint rule would ever take that energy away.
        """
        kernels.calm_overlong(
            position, velocity, lag, self._taut, self._vertex, self._longest, self._inverse_mass, RECOVERY
        )
