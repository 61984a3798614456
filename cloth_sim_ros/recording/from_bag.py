"""A scene simulated with the inputs of any bag, whoever recorded it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cloth_core.scene import Scene
from cloth_sim_ros import interfaces
from cloth_sim_ros.messages.cdr import PointCloudEncoder, encode_triangles
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.session import Record, SessionError, SessionReader
from cloth_sim_ros.simulation.closures import ClosureMapping
from cloth_sim_ros.simulation.frames import FrameTree
from cloth_sim_ros.simulation.intake import Intake, Source, sources
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation

NAME = "/cloth_sim"
SNAPSHOT_S = 1.0

Decode = Callable[[bytes, str], Any]
"""(bytes, type name) -> message; raises what it likes for bytes that are none."""


@dataclass
class Outcome:
    """What came of it.

    Args:
        steps: simulated.
        used: messages by topic of the bag.
        refused: messages that were not used, by cause.
        unused: topics of the bag that lead nowhere.
    """

    steps: int = 0
    used: Counter[str] = field(default_factory=Counter)
    refused: Mapping[str, int] = field(default_factory=dict)
    unused: Sequence[str] = ()


def simulate(
    reader: SessionReader,
    scene: Scene,
    folder: Path,
    decode: Decode,
    *,
    remap: Mapping[str, str],
    closures: Sequence[ClosureMapping] = (),
    transforms: Sequence[str] = (),
    on_progress: Callable[[float], None] | None = None,
) -> Outcome:
    """Simulate ``scene`` from the first to the last message of a bag; write a session that holds inputs and points.

    Args:
        reader: of the bag.
        scene: what to simulate.
        folder: the new session's own.
        decode: makes messages of bytes.
        remap: topics of the bag to those of a node :data:`NAME`; those not named stay.
        closures: as the node's parameter.
        transforms: static transforms, as the node's parameter.
        on_progress: gets the s that are simulated.

    Raises:
        SessionError: the bag is damaged, none of its topics is an input, or the session cannot be written.
        SettingError: a transform is malformed.
    """
    run = _Run(reader, scene, folder, decode, remap, closures, transforms)
    try:
        return run.go(on_progress)
    finally:
        run.recorder.close()


class _Run:
    """One simulation: the newest inputs before each slot, one step a slot."""

    def __init__(
        self,
        reader: SessionReader,
        scene: Scene,
        folder: Path,
        decode: Decode,
        remap: Mapping[str, str],
        closures: Sequence[ClosureMapping],
        transforms: Sequence[str],
    ) -> None:
        known = {s.topic: s for _, s in sources(scene, closures, lambda name: name.replace("~", NAME, 1))}
        present = sorted({entry.channel.topic for entry in reader.entries()})
        self._sources: dict[str, Source] = {t: known[remap.get(t, t)] for t in present if remap.get(t, t) in known}
        if not self._sources:
            has, wants = ", ".join(present) or "none", ", ".join(known)
            raise SessionError(f"{reader.path}: no topic of it is an input: it has {has}; inputs are {wants}")
        self._outcome = Outcome(unused=[topic for topic in present if topic not in self._sources])
        self._reader, self._decode = reader, decode
        self._notices = Notices(lambda _line: None)
        self._simulation = Simulation(scene)
        self._intake = Intake(self._simulation, FrameTree("world", transforms), self._notices)
        self._points = PointCloudEncoder("world")
        self.recorder = Recorder.open(folder, scene, {}, self._simulation.solver, NAME, record="outputs")

    def go(self, on_progress: Callable[[float], None] | None) -> Outcome:
        """Step through all of the bag."""
        (first, last), dt = self._reader.times_ns, round(1e9 * self._simulation.solver.config.dt)
        self._begin(first)
        slot = first
        for record in self._reader.messages(self._sources):
            while record.log_time_ns > slot + dt:
                slot += dt
                self._step(slot)
                if on_progress is not None:
                    on_progress((slot - first) * 1e-9)
            self._take(record)
        while slot < last:
            slot += dt
            self._step(slot)
        self._outcome.refused = dict(self._notices.counts)
        return self._outcome

    def _begin(self, stamp_ns: int) -> None:
        self._keep(stamp_ns)
        triangles = encode_triangles("world", stamp_ns, self._simulation.solver.mesh.triangles)
        self._publish(interfaces.TRIANGLES, triangles, stamp_ns)

    def _take(self, record: Record) -> None:
        source = self._sources[record.topic]
        self.recorder.raw_input(
            source.topic, source.interface.type_name, record.cdr, record.log_time_ns, qos=source.interface.qos
        )
        if record.type_name != source.interface.type_name:
            self._intake.refuse(record.topic, "type", f"is {record.type_name}, not {source.interface.type_name}")
            return
        try:
            message = self._decode(record.cdr, record.type_name)
        except Exception as error:  # middleware has no common one
            self._intake.refuse(record.topic, "bytes", str(error))
            return
        self._outcome.used[record.topic] += self._intake.receive(source, message, record.log_time_ns * 1e-9)

    def _step(self, stamp_ns: int) -> None:
        frame = self._simulation.tick(stamp_ns * 1e-9)
        self.recorder.step(frame.step_index, frame.inputs, frame.report.sweeps, frame.digest, stamp_ns)
        self._publish(
            interfaces.POINTS, self._points.encode(stamp_ns, frame.position, frame.normal, frame.strain), stamp_ns
        )
        self._outcome.steps += 1
        if frame.step_index % round(SNAPSHOT_S / self._simulation.solver.config.dt) == 0:
            self._keep(stamp_ns)

    def _keep(self, stamp_ns: int) -> None:
        state = self._simulation.state
        self.recorder.snapshot(self._simulation.solver.snapshot(state), state.step_index, stamp_ns)

    def _publish(self, interface: interfaces.Interface, cdr: bytes, stamp_ns: int) -> None:
        topic = interface.name.replace("~", NAME, 1)
        self.recorder.output(topic, interface.type_name, cdr, stamp_ns, qos=interface.qos)
