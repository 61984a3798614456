"""Obstacles bear the cloth: what they hold stays where it is while W reconciles threads with inertia.

W knows of no contacts. If points of the cloth were brought back to surfaces after it alone, threads would be relaxed
as if what an obstacle holds had gone on: M kg that hang on vertices of m kg would be borne with threads that are
g h^2 M / 2 m too long, and each push would add k h^2 / m of the energy that it takes out. Over something thin a cloth
would be hurled about. So contacts come first and last:

- Before threads choose their directions, points are pushed to where obstacles keep them, each by itself. So threads see
  what is held, and W hands the pull of those that have grown on to what hangs on them.
- W lets them draw what is held along. What threads thus draw into an obstacle is brought back by forces that W
  spreads. It takes a thread for as stiff across as along, so it bears what goes along the threads alone; across them
  a point is pushed against its own inertia. One force for each point, as if it were alone, and the best share of them
  all together: a step of steepest descent, and a product with W; a few such rounds at most. Pushes and friction follow,
  before the stretch limit looks. The sweeps do the rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cloth_core.kernels import bearing as kernels
from cloth_core.kernels import midpoint
from cloth_core.mesh import ClothMesh
from cloth_core.physics.contacts import Contacts
from cloth_core.physics.stretch_limit import HeldMasses

NEGLIGIBLE = 0.006
"""Of the usual thread: what threads draw into an obstacle by less is left to the sweeps."""


ROUNDS = 3
"""Times that forces are sought, at most."""


class Bearing(HeldMasses):
    """Meets obstacles before the solve and bears what they hold after it; nothing is kept from substep to substep.

    Args:
        contacts: of the cloth with its obstacles.
        mesh: the cloth.
        mass: (V,) kg.
        stiffness: (V,) kg, that threads add to the mass of each vertex in W's system.
        solve: overwrites the free rows of its second argument (V, 3) with W times the first; held rows are read.
    """

    def __init__(
        self,
        contacts: Contacts,
        mesh: ClothMesh,
        mass: np.ndarray,
        stiffness: np.ndarray,
        solve: Callable[[np.ndarray, np.ndarray], None],
    ) -> None:
        super().__init__(mass)
        self._contacts, self._solve = contacts, solve
        threads = np.flatnonzero(mesh.spring_limited)
        self._threads = stiffness / mass, *_neighbours(mesh.spring_ends[threads], len(mass))
        self._negligible, self._known = NEGLIGIBLE * mesh.usual_thread, True
        shape = mass.shape[0], 3
        self._expected, self._total, self._kept, self._moved = (np.zeros(shape) for _ in range(4))
        self._hard, self._rooms = np.zeros((len(mass), 6)), np.zeros((2, 0, 3))
        self._heavy = self._seeming_mass(mass) if contacts.names else 1.0
        self.met = np.zeros(shape)
        """(V, 3) m, by which obstacles have moved the end of the substep before threads saw it."""
        self.borne = np.zeros(shape)
        """(V, 3) m, by which the forces against the pull of threads have moved it."""
        if contacts.names:
            self._load(mesh.rest_position.copy())

    def meet(self, start: np.ndarray, end: np.ndarray, h: float) -> bool:
        """Find what may touch in ``h`` s from ``start`` to ``end`` (V, 3) m, and push that out; whether any was."""
        contacts = self._contacts
        self.met[:] = self.borne[:] = 0.0
        self._known = True
        contacts.find(start, end, h)
        self._expected[:] = end
        if contacts.count == 0 or contacts.push_out(end) == 0.0:
            return False
        kernels.keep_in(start, end, contacts.bodies, contacts.points, contacts.count, self._inverse_mass)
        np.subtract(end, self._expected, out=self.met)
        self._expected[:] = end
        return True

    def strays(self, end: np.ndarray) -> bool:
        """Whether the ``end`` (V, 3) m is farther from where points were looked for than they are looked for."""
        return bool(self._contacts.names) and midpoint.farthest_apart(end, self._expected) > self._contacts.shell

    def forget(self) -> None:
        """Nothing was met in this substep, and who may touch is to be found again."""
        self.met[:] = 0.0
        self._known = False

    def bear(self, start: np.ndarray, end: np.ndarray, held: np.ndarray, h: float) -> None:
        """Keep threads from drawing points into obstacles: move ``end`` (V, 3) m by forces, pushes and friction."""
        contacts = self._contacts
        if not self._known or self.strays(end):
            contacts.find_again(start, end, h)
        elif contacts.count > 0:
            self._spread_forces(start, end, held)
        if contacts.count > 0:  # The stretch limit shall not count on what obstacles do not let slide.
            contacts.push_out(end)
            contacts.apply_friction(start, end)

    def _spread_forces(self, start: np.ndarray, end: np.ndarray, held: np.ndarray) -> None:
        count = self._contacts.count
        if self._rooms.shape[1] < count:
            self._rooms = np.zeros((2, 2 * count, 3))
        self._moved[held] = 0.0
        for number in range(ROUNDS):
            if self._find_lack(start, end, count) <= self._negligible:
                break
            if number == 0:
                kernels.find_hardness(end, *self._threads, self._hard)
            self._ask(count)
            self._solve(self._kept, self._moved)
            self._give(end, count)
            self.borne += self._moved

    def _find_lack(self, start: np.ndarray, end: np.ndarray, count: int) -> float:
        contacts = self._contacts
        return kernels.find_lack(
            start, self._expected, end, contacts.bodies, contacts.points, count, self._negligible, *self._threads,
            self._hard, self._rooms[0],
        )  # fmt: skip

    def _ask(self, count: int) -> None:
        contacts, (lack, force) = self._contacts, self._rooms
        kernels.ask(
            contacts.points, count, contacts.bodies.friction, self._inverse_mass, self._hard, self._heavy, lack, force,
            self._total, self._kept,
        )  # fmt: skip

    def _give(self, end: np.ndarray, count: int) -> None:
        lack, force = self._rooms
        kernels.give(
            self._contacts.points, count, self._inverse_mass, self._hard, self._total, lack, force, self._moved, end
        )

    def _load(self, place: np.ndarray) -> None:
        """Have kernels loaded, or compiled, that only a cloth over something thin would call for."""
        self._find_lack(place, place, 0)
        kernels.find_hardness(place, *self._threads, self._hard)
        self._ask(0)
        self._give(place, 0)

    def _seeming_mass(self, mass: np.ndarray) -> float:
        """How much heavier than itself a vertex is for W: that of a cloth's middle."""
        vertex = len(mass) // 2
        self._total[vertex, 0] = mass[vertex]
        self._solve(self._total, self._kept)
        moved = float(self._kept[vertex, 0])
        self._total[vertex, 0] = 0.0
        return 1.0 / moved if moved > 0.0 else 1.0


def _neighbours(ends: np.ndarray, vertices: int) -> tuple[np.ndarray, np.ndarray]:
    """(V + 1,) where the neighbours of each vertex along its threads begin, and they, one vertex after the other."""
    vertex, other = ends.astype(np.int64).ravel(), ends[:, ::-1].astype(np.int64).ravel()
    begins = np.concatenate([[0], np.cumsum(np.bincount(vertex, minlength=vertices))])
    return begins, other[np.argsort(vertex, kind="stable")]
