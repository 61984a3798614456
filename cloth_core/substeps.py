"""The substeps of a step: hands go on, the integrator moves the cloth, and what would tear is held back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cloth_core.integrators import ImplicitMidpoint, Meyer2000, Model, Substep
from cloth_core.kernels.immersion import Regions
from cloth_core.passivity import Passivity
from cloth_core.physics.hands import Hands
from cloth_core.physics.rest_scale import RestScale
from cloth_core.physics.restraint import Restraint
from cloth_core.reaction import Reactions
from cloth_core.state import FARTHEST, FASTEST, State


class Passes:
    """How many passes over stretch limit and contacts every substep may take.

    Args:
        most: passes where nothing else is known.
        forced: passes per substep of an earlier run, to be repeated.
        out_of_time: the caller's clock, asked between substeps; once true, the rest get one pass each.
    """

    def __init__(self, most: int, forced: Sequence[int] | None, out_of_time: Callable[[], bool] | None) -> None:
        self._most, self._forced, self._clock = most, forced, out_of_time
        self.out_of_time = False

    def of(self, number: int) -> int:
        """Those of the substep ``number``, from 0; to be asked in turn."""
        self.out_of_time = self.out_of_time or (number > 0 and self._clock is not None and self._clock())
        if self._forced is not None:
            return self._forced[number]
        return 1 if self.out_of_time else self._most


@dataclass(frozen=True, eq=False)
class Motion:
    """What the substeps of a step came to.

    Args:
        position: (V, 3) m.
        velocity: (V, 3) m/s.
        history: what the integrator needs to go on exactly.
        sweeps: passes done, per substep.
        excess: worst excess over the stretch limit in the last pass (a ratio).
        restrained: vertices that would have torn their threads in one of the substeps.
        reaction: (len(held), 3) N, what each held vertex did to what holds it, as a mean over the step.
        pressure: (O, 6) N and N m, what the cloth did to each obstacle, likewise.
    """

    position: np.ndarray
    velocity: np.ndarray
    history: Mapping[str, np.ndarray]
    sweeps: tuple[int, ...]
    excess: float
    restrained: int
    reaction: np.ndarray
    pressure: np.ndarray

    def undone(self, state: State) -> Motion:
        """Nothing moved: the cloth is at rest where ``state`` had it, and nothing felt it."""
        return replace(
            self,
            position=state.position.copy(),
            velocity=np.zeros_like(state.velocity),
            history={},
            reaction=np.zeros_like(self.reaction),
            pressure=np.zeros_like(self.pressure),
        )

    @property
    def is_sound(self) -> bool:
        """Whether all positions and velocities are finite and within the bounds of a state."""
        return bool((np.abs(self.position) <= FARTHEST).all() and (np.abs(self.velocity) <= FASTEST).all())


class Substeps:
    """Plays the substeps of one step after the other.

    Args:
        model: the cloth of the integrator.
        integrator: moves it.
        restraint: holds it back.
        rest_scale: changes its rest lengths.
        count: substeps in a step.
    """

    def __init__(
        self,
        model: Model,
        integrator: ImplicitMidpoint | Meyer2000,
        restraint: Restraint,
        rest_scale: RestScale,
        count: int,
    ) -> None:
        self._model, self._integrator, self._count = model, integrator, count
        self._restraint, self._rest_scale = restraint, rest_scale
        self._passivity = Passivity(model, count * model.h)
        self._reactions = Reactions(model, count * model.h)

    def play(
        self,
        state: State,
        hands: Hands,
        held: np.ndarray,
        flow: np.ndarray,
        gravity: Sequence[float],
        passes: Passes,
        fluids: Regions | None = None,
    ) -> Motion:
        """Advance a copy of ``state`` by a step that contacts and rest lengths have begun already.

        Args:
            state: where the cloth is.
            hands: what carries the held vertices.
            held: vertices that are pinned or grasped, sorted.
            flow: (V, 3) m/s, velocity of the air.
            gravity: (3,) m/s^2.
            passes: that each substep may take.
            fluids: what the cloth may be immersed in.
        """
        model, integrator = self._model, self._integrator
        integrator.begin(state.history)
        position, velocity, excess = state.position, state.velocity, 0.0
        if model.self_contacts is not None:
            position = model.self_contacts.begin_step(position, velocity, self._count * model.h)
        lag, weight = state.history.get("lag", np.zeros_like(velocity)), np.array(gravity)
        self._passivity.begin(position, velocity, lag, flow, weight, alone=fluids is None)
        self._reactions.begin(position, velocity + lag, held)
        done: list[int] = []
        restrained = np.zeros(len(position), dtype=bool)
        for number in range(self._count):
            allowed = passes.of(number)
            target = hands.targets(number, held, state.position)
            model.contacts.begin_substep((number + 1) / self._count)
            self._rest_scale.begin_substep((number + 1) / self._count)
            given = Substep(
                h=model.h,
                number=number,
                held=held,
                target=target,
                flow=flow,
                gravity=weight,
                sweeps=allowed,
                fluids=fluids,
            )
            start = position
            position, velocity, sweeps, excess = integrator.advance(start, velocity, given)
            done.append(sweeps)
            pull = integrator.pull(position, held) if len(held) else None
            self._reactions.add(integrator.air_force if model.drag > 0.0 or fluids else None, pull)
            if integrator.restrained or model.self_contacts is not None:
                restrained[self._restrain(start, position, velocity, hands)] = True
        history = integrator.end()
        after = velocity
        if "lag" in history:
            self._passivity.end(position, velocity, history["lag"], held)
            after = velocity + history["lag"]
        felt = self._reactions.end(position, after, weight)
        return Motion(position, velocity, history, tuple(done), excess, int(restrained.sum()), *felt)

    def _restrain(self, start: np.ndarray, end: np.ndarray, velocity: np.ndarray, hands: Hands) -> np.ndarray:
        """Hold back what the way from ``start`` to ``end`` (V, 3) m would tear; returns the vertices stopped."""
        model, integrator = self._model, self._integrator
        stopped = self._restraint.apply(
            start, end, velocity, model.h, model.contacts.touched, model.self_contacts, threads=integrator.restrained
        )
        integrator.restart(stopped)
        hands.hold_back(stopped, start, end)
        return stopped
