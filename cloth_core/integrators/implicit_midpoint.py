"""The default step: implicit midpoint by local/global on the paper's W, in small substeps.

The rule is x' = x + h (v + v') / 2, v' = v + h a(middle): second order, and without damping of its own. Its middle
minimises |z - y|^2_M / (h^2 / 2) + E(z) with y the inertial prediction. From y, one local/global iteration is taken
(Liu, Bargteil, O'Brien and Kavan 2013, "Fast simulation of mass-spring systems"): springs choose their directions,
one product with the constant W reconciles them with inertia. Unlike the paper's predictor it does not damp what moves
without deforming.

Four things differ from the textbook. The velocity kept is the displacement over the substep, so that contacts and the
stretch limit, which move positions, end impacts as they should; the half step h a / 2 by which the rule's velocity is
ahead is kept apart, as ``lag``. Threads at their stretch limit pull with a ``tension`` that W spreads over the
cloth (augmented Lagrangian): sweeps alone would have to lift the cloth anew in every substep. What obstacles hold is
held before springs choose their directions, and borne after it, for W knows of no contacts. And where the iteration
changes much, another one lets pressed threads buckle, for W takes them for as stiff across as along.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.integrators.model import Model, Substep
from cloth_core.kernels import midpoint, surface
from cloth_core.mesh import ClothMesh
from cloth_core.physics.along import AlongThreads
from cloth_core.physics.bending import LEAST_DAMPING, SLOWEST, Bending

LONGEST_SUBSTEP = 0.0025
"""s; halving it halves the error of a stiff cloth and doubles the cost."""
LEAST_STRETCH_DAMPING = 1e-4
"""s, the least ``stretch_damping`` that a cloth which bends is computed with: bending that is held for some substeps
excites the fastest threads, which the rule itself does not damp."""

USUAL_SWEEPS, TOLERATED_EXCESS = 6, 0.005
"""After so many sweeps, more follow only for an excess above this ratio. Fewer would come and go with the excess, and
what hangs still would tremble."""
MUCH = 0.01
"""Of the usual thread, that a local and global step may change a vertex without another one."""
DRAWN = 15.0
"""Times the way that gravity alone leads in half a substep: threads of what lies draw it into an obstacle by about so
much in every substep, and nothing buckles."""
RESOLVED = 0.1
"""Share of the shortest thread at a vertex by which half an acceleration may move it in a substep. One step of W
follows threads that turn by a small angle; beyond, the midpoint rule feeds a whipping chain without end. There what
exceeds it is left out of the ``lag``, which makes the rule an implicit Euler step, and dissipative."""
ALARMING_EXCESS = 0.01
"""An excess that sweeps cannot cope with calls for another iteration, with the tensions that it gives rise to."""


class ImplicitMidpoint:
    """Default integrator: substeps of 2.5 ms, ``iterations`` 1, ``stretch_sweeps`` up to 30."""

    iterations, stretch_sweeps = 1, 30
    restrained = True

    def __init__(self, model: Model, substeps: int) -> None:
        self.model = model
        self.iterations = model.config.iterations or self.iterations
        half = 0.5 * model.h
        least = LEAST_STRETCH_DAMPING if model.bends else 0.0
        self._viscosity = max(model.material.stretch_damping, least) / half
        self._filter = model.filter_by((1.0 + self._viscosity) * model.stretch, half * half)
        self._along = AlongThreads(model.sheet, model.mass, self._filter.solve)
        self._bearing = model.bear_by(self._filter)
        self._every = _longest_run(substeps, model.h)
        self._bending = self._bending_for(self._every * model.h) if model.bends else None
        shape = model.mesh.rest_position.shape
        self.air_force, self._right_side, self._change, self._inertial = (np.zeros(shape) for _ in range(4))
        self._nothing, self._end, self._sudden = (np.zeros(shape) for _ in range(3))
        self._much = MUCH * model.mesh.usual_thread
        self._most_lag = RESOLVED / model.h * _shortest_thread(model.mesh)

    @staticmethod
    def substeps(config: SolverConfig) -> int:
        """Substeps in a step if the configuration leaves the choice."""
        return max(1, math.ceil(config.dt / LONGEST_SUBSTEP - 1e-9))

    def begin(self, history: Mapping[str, np.ndarray]) -> None:
        """Take up the ``history`` of a state; an empty one means to start afresh."""
        mesh = self.model.mesh
        self._lag = np.array(history["lag"]) if "lag" in history else np.zeros((mesh.vertex_count, 3))
        slack = self.model.limit.slack()
        # A change of the material may have passed the sheet on from springs to triangles.
        known = history.get("tension", slack).shape == slack.shape
        self._tension = np.array(history.get("tension", slack)) if known else slack

    def end(self) -> dict[str, np.ndarray]:
        """What the next step needs to go on exactly."""
        return {"lag": self._lag, "tension": self._tension}

    def restart(self, vertex: np.ndarray) -> None:
        """Forget how these vertices were accelerated: something else has stopped them."""
        self._lag[vertex] = 0.0

    def pull(self, position: np.ndarray, held: np.ndarray) -> np.ndarray:
        """(len(held), 3) N, what the cloth pulled the ``held`` vertices with in the substep that ended at ``position``.

        Of stretching it is what the rows of the system that stand for them leave over: the forces at its middle.
        """
        model, scale = self.model, 0.25 * self.model.h * self.model.h
        force = self._right_side[held] / scale
        model.add_rows(model.stretch, held, self._change, -(1.0 + self._viscosity), force)
        # What is borne moves the end, of which the middle is half, and has no share in the lag.
        model.add_rows(model.stretch, held, self._bearing.borne, -0.25 * (1.0 + self._viscosity), force)
        if model.bends:
            model.add_rows(model.bending, held, position, -1.0, force)
        return force

    def advance(
        self, position: np.ndarray, velocity: np.ndarray, substep: Substep
    ) -> tuple[np.ndarray, np.ndarray, int, float]:
        """Advance (V, 3) ``position`` and ``velocity`` by one substep.

        Returns:
            New position, new velocity, sweeps done, worst excess over the stretch limit in the last sweep.
        """
        model = self.model
        if self._bending is not None and substep.number % self._every == 0:
            velocity = self._bending.damp(position, velocity, substep.held)
            self._bending.bend(position, velocity, self._lag, substep.gravity, substep.held)
        inertial, middle = self.predict(position, velocity, substep)
        met = self.meet(position, inertial, middle, substep)
        self.iterate(position, inertial, middle, substep)
        if met and self._strays(position, middle):
            self.undo_meeting(inertial, middle)
            self.iterate(position, inertial, middle, substep)
        end, sweeps, excess = self.finish(position, inertial, middle, substep)
        if excess > ALARMING_EXCESS and substep.sweeps > USUAL_SWEEPS and not model.contacts.touching:
            self.relax(position, inertial, middle, substep.held, settled=True)
            end, _, excess = self.finish(position, inertial, middle, substep)
        bearing = self._bearing
        midpoint.renew_lag(position, velocity, middle, self._sudden, substep.h, self._lag)
        if model.contacts.touching:
            midpoint.end_acceleration(bearing.borne, substep.h, self._lag)
        midpoint.bound_lag(substep.gravity, substep.h, self._most_lag, self._lag)
        self._lag[substep.held] = 0.0
        settled = model.settle(position, velocity, end, substep)
        model.limit.calm(end, settled, self._lag)
        return end, settled, sweeps, excess

    def predict(self, position: np.ndarray, velocity: np.ndarray, substep: Substep) -> tuple[np.ndarray, np.ndarray]:
        """The middle of the substep by inertia, gravity, air and bending, (V, 3) m, and a copy of it to be moved.

        Held vertices are halfway to their targets.
        """
        model, inertial, middle = self.model, self._inertial, np.empty_like(position)
        bending = self._nothing if self._bending is None else self._bending.acceleration
        self.air_force[:] = 0.0
        if model.drag > 0.0 or substep.fluids is not None:
            surface.add_relative_drag(
                velocity, substep.flow, *model.exposed(position, velocity, substep, self.air_force), model.drag,
                model.mass, substep.h, self.air_force,
            )  # fmt: skip
        midpoint.predict(
            position, velocity, self._lag, self.air_force, model.mass, bending, substep.gravity, substep.h, inertial
        )
        inertial[substep.held] = 0.5 * (position[substep.held] + substep.target)
        middle[:] = inertial
        return inertial, middle

    def meet(self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, substep: Substep) -> bool:
        """Push out of obstacles what ``inertial`` leads into them, and ``middle`` with it, both (V, 3) m, in place.

        Returns:
            Whether there was anything.
        """
        midpoint.extrapolate(position, inertial, self._end)
        met = self._bearing.meet(position, self._end, substep.h)
        self._sudden[:] = self._bearing.met
        if not met:
            return False
        inertial += 0.5 * self._bearing.met
        middle[:] = inertial
        return True

    def _strays(self, position: np.ndarray, middle: np.ndarray) -> bool:
        """Whether threads lead far from where obstacles were met: what was held there does not tell what will be."""
        midpoint.extrapolate(position, middle, self._end)
        return self._bearing.strays(self._end)

    def undo_meeting(self, inertial: np.ndarray, middle: np.ndarray) -> None:
        """Leave what obstacles do to the sweeps: where inertia alone leads, ``middle`` and ``inertial`` (V, 3) m."""
        inertial -= 0.5 * self._bearing.met
        middle[:] = inertial
        self._sudden[:] = 0.0
        self._bearing.forget()

    def iterate(self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, substep: Substep) -> None:
        """As many local and global steps as are wanted, of a ``middle`` (V, 3) m that is at ``inertial``, in place.

        One more where they change much: that is where cloth meets something, and its threads are pressed.
        """
        for number in range(self.iterations):
            self.relax(position, inertial, middle, substep.held, settled=number > 0)
        resting = DRAWN * 0.25 * substep.h**2 * float(np.linalg.norm(substep.gravity))
        if midpoint.farthest_apart(self._change, self._nothing) > max(self._much, resting):
            self.buckle(position, inertial, middle, substep.held)

    def relax(
        self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, held: np.ndarray, *, settled: bool
    ) -> None:
        """One local and one global step: springs choose their directions, W reconciles them with inertia.

        In terms of what ``middle`` still has to move, so that W need not be exact; ``settled`` says whether it
        has left ``inertial`` already.
        """
        self._find_right_side(position, inertial, middle, settled=settled)
        self._change[held] = 0.0  # they are where they shall be
        self._filter.solve(self._right_side, self._change)
        middle += self._change

    def buckle(self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, held: np.ndarray) -> None:
        """One local and one global step in which threads give way across themselves, as far as that leads down.

        No vertex goes farther than what calls for it, and none is thought to go on like that: it is a start that the
        motion makes of, and cloth that whips would make too much of it.
        """
        model, change = self.model, self._change
        self._along.look(middle, self._tension, 0.25 * model.h * model.h * (1.0 + self._viscosity))
        self._find_right_side(position, inertial, middle, settled=True)
        change[held] = 0.0
        self._along.solve(self._right_side, change, self._much)
        change[held] = 0.0
        model.balance.correct(middle, self._nothing, change, held)
        # No product of BLAS: how that adds up depends on the number of its threads.
        slope = np.einsum("va,va->", change, self._right_side)
        middle += change
        self._find_right_side(position, inertial, middle, settled=True)
        beyond = np.einsum("va,va->", change, self._right_side)
        if beyond < 0.0:
            middle -= beyond / (beyond - slope) * change
            change *= slope / (slope - beyond)
        self._sudden += 2.0 * change
        change[:] = 0.0  # The right side is that of the end already.

    def _find_right_side(
        self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, *, settled: bool
    ) -> None:
        model = self.model
        self._right_side[:] = 0.0
        if settled:
            midpoint.add_inertia(model.mass, inertial, middle, self._right_side)
        scale = 0.25 * model.h * model.h
        model.sheet.add_impulses(middle, position, self._tension, self._viscosity, scale, self._right_side)

    def finish(
        self, position: np.ndarray, inertial: np.ndarray, middle: np.ndarray, substep: Substep
    ) -> tuple[np.ndarray, int, float]:
        """The end of the substep whose ``middle`` is known, (V, 3) m: as far again, then within the limits.

        Returns:
            It, the sweeps done, and the worst excess over the stretch limit in the last sweep.
        """
        model, end = self.model, np.empty_like(position)
        model.balance.correct(middle, inertial, middle, substep.held)
        midpoint.extrapolate(position, middle, end)
        end[substep.held] = substep.target
        self._bearing.bear(position, end, substep.held, substep.h)
        model.limit.find(end, self._tension)
        model.limit.carry(position, end, self._tension)
        sweeps, excess = model.limit_stretch_in_contact(position, end, substep, USUAL_SWEEPS, TOLERATED_EXCESS)
        return end, sweeps, excess

    def _bending_for(self, time: float) -> Bending:
        model, lasting = self.model, max(self.model.material.bend_damping, LEAST_DAMPING)
        return Bending(
            model.bending,
            model.mass,
            model.balance,
            model.filter_by(model.bending, time * time),
            model.filter_by(model.bending, time * lasting),
            time,
        )


def _shortest_thread(mesh: ClothMesh) -> np.ndarray:
    """(V,) m, the rest length of the shortest spring at each vertex."""
    shortest = np.full(mesh.vertex_count, np.inf)
    np.minimum.at(shortest, mesh.spring_vertex, mesh.spring_rest[:, None])
    return shortest


def _longest_run(substeps: int, h: float) -> int:
    """The most substeps that one bending solve may cover: a divisor of ``substeps``."""
    fitting = (n for n in range(substeps, 0, -1) if substeps % n == 0 and n * h <= SLOWEST * (1.0 + 1e-9))
    return next(fitting, 1)
