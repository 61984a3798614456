"""The last resort of the stretch limit: what would be torn moves as one body for a substep.

Forces and sweeps keep threads near their limit as long as nobody asks for the impossible. A hand that jerks, an
obstacle that hits, a cloth that whips do; then no thread may end up longer than the limit and ``MARGIN``, whatever
else has to give. First come more sweeps, over such threads alone. The ends of what is still too long are welded for
the substep: a perfectly inelastic impact, which keeps the momentum, and leaves the thread as long as it was. A hand
takes the body along with no more than ``max_grasp_force``, and stays behind where that is not enough; what lies on an
obstacle it does not move.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from cloth_core.kernels import springs
from cloth_core.kernels.weld import weld_overlong, weld_rows
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.physics.rest_scale import RestShape
from cloth_core.physics.self_contacts import SelfContacts

MARGIN = 0.028
"""By which a thread may exceed its stretch limit for a moment, as a share of its rest length."""
AIM = 0.015
"""What the further sweeps aim at, likewise; less than ``MARGIN``, for they never quite get there."""
SWEEPS = 30
"""Most of them in a substep."""
WELDS = 50
"""Rounds in a substep of welding what would be torn, and then what would pass through: bodies only grow."""
LYING = 1e6
"""Weight of a vertex that touches an obstacle, as a multiple of its own."""


class Restraint:
    """Welds what a substep would tear; it knows what hands hold and what is pinned.

    Args:
        mesh: the cloth.
        material: its stretch limit is the one to keep.
        strongest: N, most that a hand pulls with.
    """

    def __init__(self, mesh: ClothMesh, material: Material, strongest: float) -> None:
        self._mesh, self._mass, self._strongest = mesh, mesh.vertex_mass(material), strongest
        self._limited, self._vertex = np.flatnonzero(mesh.spring_limited).astype(np.uint32), mesh.spring_ends
        self._stretch_limit = material.stretch_limit
        self.resize(RestShape.of(mesh))
        self._hands: list[np.ndarray] = []
        self._pinned = np.zeros(0, np.int32)

    def resize(self, rest: RestShape) -> None:
        """Compute with other rest lengths from now on."""
        self._longest = rest.limit_rest * (self._stretch_limit + MARGIN)
        self._aim = rest.limit_rest * (self._stretch_limit + AIM)

    def hold(self, hands: Iterable[np.ndarray], pinned: np.ndarray) -> None:
        """From now on each of the sets of vertices in ``hands`` is one body, and the ``pinned`` ones stay."""
        self._hands, self._pinned = [vertex for vertex in hands if len(vertex)], pinned

    def apply(
        self,
        start: np.ndarray,
        end: np.ndarray,
        velocity: np.ndarray,
        h: float,
        touched: Callable[[], np.ndarray],
        layers: SelfContacts | None = None,
        *,
        threads: bool = True,
    ) -> np.ndarray:
        """Restrain the way from ``start`` to ``end`` (V, 3) m of ``h`` s; ``end`` and ``velocity`` in place.

        ``touched`` gives the vertices that touch an obstacle; what ``layers`` find passing through one another is
        welded as well. Without ``threads`` these may get as long as they like. Returns the vertices that go another
        way now.
        """
        overlong = threads and self._overlong(end)
        if not overlong and (layers is None or layers.are_apart):
            return np.zeros(0, np.int64)
        before, lying = end.copy(), touched()
        if overlong:
            self._sweep(end, np.concatenate([self._pinned, lying, *self._hands]))
            if layers is not None:
                layers.keep_apart(start, end)
            overlong = self._overlong(end)
        if overlong or not (layers is None or layers.are_apart):
            self._weld(start, end, h, lying, layers, threads=threads)
        vertex = np.flatnonzero((end != before).any(axis=1))
        velocity[vertex] = (end[vertex] - start[vertex]) / h
        return vertex

    def _overlong(self, position: np.ndarray) -> bool:
        return springs.any_longer(position, self._limited, self._vertex, self._longest)

    def _sweep(self, end: np.ndarray, unmoved: np.ndarray) -> None:
        """Shorten what is too long, of which some vertices stay ``unmoved``."""
        inverse_mass = 1.0 / self._mass
        inverse_mass[unmoved] = 0.0
        for number in range(SWEEPS):
            worst = springs.shorten_springs(end, self._limited, self._vertex, self._aim, inverse_mass, number % 2 == 1)
            if worst < 0.5 * (MARGIN - AIM):
                break

    def _weld(
        self,
        start: np.ndarray,
        end: np.ndarray,
        h: float,
        lying: np.ndarray,
        layers: SelfContacts | None,
        *,
        threads: bool,
    ) -> None:
        mass = self._mass.copy()
        mass[lying] *= LYING
        way, parent, pulled = end - start, np.arange(len(mass)), np.zeros(len(mass))
        for vertex in self._hands:
            parent[vertex], mass[vertex], pulled[vertex[0]] = vertex[0], 0.0, 1.0
        fixed, welded = np.zeros(len(mass), np.bool_), np.zeros(len(mass), np.bool_)
        fixed[self._pinned] = True
        strongest = self._strongest * h * h
        bodies = (strongest, parent, mass, way.copy(), pulled, way.copy(), fixed, welded, way)
        limited, longest = self._vertex[self._limited], self._longest[self._limited]
        for _ in range(WELDS):
            if threads:
                weld_overlong(start, end, limited, longest, *bodies)
            if layers is None:
                break
            passing = layers.passing(start, end)
            weld_rows(start, end, passing, *bodies)
            if len(passing) == 0:
                break
