"""W for what goes along threads alone.

W is that of springs which resist in every direction. Across itself a thread resists only with what it pulls, and if it
is pressed it gives way: cloth buckles. To W it is some hundred times stiffer there, so that cloth which falls onto
something would stay flat like a sheet of metal, store the energy in its threads and spring back.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cloth_core.kernels import along as kernels
from cloth_core.physics.membrane import Membrane
from cloth_core.physics.springs import Springs


class AlongThreads:
    """P W P + (1 - P) (m + s)^-1 (1 - P), P being what the threads of a vertex bear and s what they resist across.

    Args:
        sheet: of the threads.
        mass: (V,) kg.
        solve: overwrites the free rows of its second argument (V, 3) with W times the first; held rows are read.
    """

    def __init__(
        self, sheet: Springs | Membrane, mass: np.ndarray, solve: Callable[[np.ndarray, np.ndarray], None]
    ) -> None:
        self._sheet, self._mass, self._solve = sheet, mass, solve
        vertices = len(mass)
        self._along, self._hard = np.zeros((vertices, 6)), np.zeros((vertices, 6))
        self._across, self._kept = np.zeros(vertices), np.zeros((vertices, 3))

    def look(self, position: np.ndarray, tension: np.ndarray, scale: float) -> None:
        """See how threads run at ``position`` (V, 3) m, under the ``tension`` of their limits; ``scale`` s^2, of W."""
        self._along[:] = self._across[:] = 0.0
        self._sheet.add_resistance(position, tension, scale, self._along, self._across)
        kernels.find_hardness(self._along, self._mass, self._hard)

    def solve(self, push: np.ndarray, moved: np.ndarray, farthest: float) -> None:
        """Overwrite ``moved`` (V, 3) m with what the ``push`` (V, 3) kg m does, at most ``farthest`` m a vertex.

        Held rows are read, and what is written there has no meaning.
        """
        kernels.keep(self._hard, push, self._kept)
        self._solve(self._kept, moved)
        kernels.join(self._hard, push, self._mass, self._across, farthest, moved)
