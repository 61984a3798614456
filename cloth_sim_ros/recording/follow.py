"""A simulation that does what a recording says, entry by entry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cloth_core import ClothError, ClothSolver, Material, SolverConfig, State
from cloth_sim_ros.recording.content import Event, Snapshot, Step
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.session import SessionError

Change = Callable[[Material, SolverConfig], "tuple[Material, SolverConfig]"]
"""What is simulated with instead of what was."""

_NEW_EPISODE = ("reset", "restore")


def pin_exactly(solver: ClothSolver, vertices: np.ndarray) -> None:
    """Pin these vertices and no others; W is kept if they are those that are pinned already.

    Raises:
        MeshError: a vertex does not exist.
    """
    if not np.array_equal(solver.pinned, vertices):
        solver.unpin()
        solver.pin(vertices)


class Follower:
    """Simulates a session again from its recorded inputs.

    Args:
        session: what was recorded.
        change: other parameters than the recorded ones; then no passes are forced, for others may be needed.

    Raises:
        SessionError: the session is damaged.
        ClothError: what ``change`` gives cannot be simulated.
    """

    def __init__(self, session: RecordedSession, change: Change | None = None) -> None:
        self._session = session
        self._change = change
        self.solver: ClothSolver = session.scene.build()[0]
        self.state: State | None = None
        """None while the next snapshot says where to go on."""
        if change is not None:
            self._equip(self.solver.material, self.solver.config)
        self.solver.prepare()

    def follow(self, entry: Step | Snapshot | Event) -> None:
        """Do what ``entry`` says.

        Raises:
            SessionError: it cannot be done; the message says at which step.
        """
        if isinstance(entry, Step):
            self._step(entry)
        elif isinstance(entry, Snapshot):
            self._take_up(entry)
        elif entry.kind in _NEW_EPISODE:
            self.state = None
        elif entry.kind == "parameters":
            self._take_over(entry)
        elif entry.kind == "pins":
            self._pin(entry)

    def _step(self, step: Step) -> None:
        if self.state is None or step.index != self.state.step_index + 1:
            before = "no snapshot" if self.state is None else f"step {self.state.step_index}"
            raise self._problem(f"step {step.index} follows {before}: something is missing between")
        try:
            forced = step.sweeps if self._change is None else None
            self.state = self.solver.step(self.state, step.inputs, sweeps=forced)
        except ClothError as error:
            raise self._problem(f"step {step.index} cannot be computed: {error}") from error

    def _take_up(self, snapshot: Snapshot) -> None:
        if self.state is None:
            try:
                self.state = self.solver.restore(snapshot.arrays)
            except (KeyError, ValueError) as error:
                raise self._problem(f"the snapshot of step {snapshot.index} is damaged: {error}") from error

    def _take_over(self, event: Event) -> None:
        try:
            material = Material.from_mapping(event.details["material"])
            self._equip(material, SolverConfig.from_mapping(event.details["solver"]))
        except (ClothError, KeyError) as error:
            raise self._problem(f"the parameters after step {event.index} cannot be used: {error}") from error

    def _pin(self, event: Event) -> None:
        try:
            pin_exactly(self.solver, np.array(event.details["vertices"], dtype=np.int64))
        except (ClothError, KeyError, TypeError, ValueError) as error:
            raise self._problem(f"the pins after step {event.index} cannot be used: {error}") from error

    def _equip(self, material: Material, config: SolverConfig) -> None:
        if self._change is not None:
            material, config = self._change(material, config)
        pinned = self.solver.pinned
        self.solver = self.solver.changed(material=material, config=config)
        pin_exactly(self.solver, pinned)

    def _problem(self, text: str) -> SessionError:
        return SessionError(f"{self._session.path}: {text}")
