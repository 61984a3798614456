"""Recording what a simulation did, so that it can be shown again and computed again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cloth_core import ClothSolver, Inputs
from cloth_core.scene import Scene
from cloth_sim_ros.recording.content import Event, Snapshot, Step
from cloth_sim_ros.recording.setup import attachments_of, metadata_of
from cloth_sim_ros.session import Health, Qos, SessionWriter

RECORD = ("none", "inputs", "outputs", "all")
"""How much to record: nothing; what drove the cloth; also what was published, bar the Marker, which
points and triangles hold already; everything."""

FLUSH_PERIOD_S = 0.15
"""What kill -9 may take. A chunk of inputs alone costs a kilobyte of index each time."""
_LEDGER_QOS = Qos(depth=100)
_REDUNDANT = "visualization_msgs/msg/Marker"


class Recorder:
    """A session in the making.

    Steps, snapshots, events and raw inputs are always kept; outputs give way when the disk is too
    slow. No method waits for the disk, and none raises when it fails: see :attr:`health`. Every method
    may be called from any thread; the order of the calls is the order in the file.
    """

    def __init__(self, writer: SessionWriter, namespace: str, record: str) -> None:
        self._writer = writer
        self._prefix = namespace.rstrip("/")
        self._record = record

    @classmethod
    def open(
        cls,
        folder: Path | str,
        scene: Scene,
        parameters: Mapping[str, Any],
        solver: ClothSolver,
        namespace: str,
        *,
        record: str = "outputs",
    ) -> Recorder:
        """Begin a session.

        Args:
            folder: the session's own folder, new or empty; parents are made.
            scene: what is simulated, with whatever overrode the file.
            parameters: the node's parameters, in JSON's types.
            solver: what simulates it; pins included.
            namespace: full name of the node, such as ``/cloth_sim``.
            record: one of ``RECORD``, but not ``none``.

        Raises:
            SessionError: the folder cannot be written, or holds something already.
            ValueError: ``record`` is not one of these.
        """
        if record not in RECORD[1:]:
            raise ValueError(f"record: {record!r} is not one of {', '.join(RECORD[1:])}")
        writer = SessionWriter(
            folder,
            attachments=attachments_of(scene, solver, parameters),
            metadata=metadata_of(scene, solver, namespace, record),
            flush_period_s=FLUSH_PERIOD_S,
        )
        return cls(writer, namespace, record)

    def raw_input(self, topic: str, type_name: str, cdr: bytes, receipt_ns: int, *, qos: Qos | None = None) -> None:
        """A message as it came in, at ROS time ``receipt_ns`` [ns], before anyone judged it."""
        self._writer.write(topic, type_name, cdr, receipt_ns, qos=qos)

    def step(self, index: int, inputs: Inputs, sweeps: Sequence[int], digest: str, stamp_ns: int) -> None:
        """A step that was done.

        Args:
            index: ``step_index`` of the state after it.
            inputs: what it was given.
            sweeps: ``report.sweeps`` of the solver.
            digest: ``digest`` of the state after it.
            stamp_ns: stamp of its outputs, ROS time [ns].
        """
        self._keep(Step(index, inputs, tuple(sweeps), digest), stamp_ns)

    def snapshot(self, arrays: Mapping[str, np.ndarray], index: int, stamp_ns: int) -> None:
        """``ClothSolver.snapshot`` of the state after step ``index``.

        To be called at the start, once a second, and after every reset and restore; after :meth:`step`.
        """
        self._keep(Snapshot(index, arrays), stamp_ns)

    def event(self, kind: str, index: int, stamp_ns: int, **details: Any) -> None:
        """``reset``, ``restore``, ``pause`` or ``resume`` after step ``index``; ``details`` in JSON's types."""
        self._keep(Event(kind, index, details), stamp_ns)

    def output(self, topic: str, type_name: str, cdr: bytes, stamp_ns: int, *, qos: Qos | None = None) -> None:
        """A message as it was published; kept if ``record`` says so and the disk is fast enough."""
        if self.wants(type_name):
            self._writer.write(topic, type_name, cdr, stamp_ns, expendable=True, qos=qos)

    def wants(self, type_name: str) -> bool:
        """Whether outputs of this type are recorded, so that nobody encodes one in vain."""
        return self._record == "all" or (self._record == "outputs" and type_name != _REDUNDANT)

    @property
    def path(self) -> Path:
        """The session's folder."""
        return self.health.folder

    @property
    def health(self) -> Health:
        """How much is safe on disk, how much was dropped, and what went wrong."""
        return self._writer.health

    def close(self) -> Health:
        """Finish the file. Calling again changes nothing."""
        return self._writer.close()

    def _keep(self, entry: Step | Snapshot | Event, stamp_ns: int) -> None:
        topic = f"{self._prefix}/{entry.topic}"
        self._writer.write(topic, entry.type_name, entry.encode(), stamp_ns, qos=_LEDGER_QOS)
