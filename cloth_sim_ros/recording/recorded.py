"""Reading back what :class:`~cloth_sim_ros.recording.recorder.Recorder` wrote."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from cloth_core.scene import Scene
from cloth_sim_ros.recording.content import Event, Snapshot, Step
from cloth_sim_ros.recording.setup import METADATA, scene_from, versions
from cloth_sim_ros.session import Record, SessionError, SessionReader

_ENTRIES = (Step, Snapshot, Event)


class Stamped(NamedTuple):
    """An entry of the session and the ROS time [ns] it was recorded with."""

    stamp_ns: int
    entry: Step | Snapshot | Event


class ForeignBag:
    """A bag that something else recorded: there is nothing in it but topics."""

    namespace = ""
    bookkeeping: frozenset[str] = frozenset()

    def __init__(self, reader: SessionReader) -> None:
        self.reader = reader
        self.path = reader.path
        self.about: dict[str, str] = {}

    @property
    def complete(self) -> bool:
        """False when the recording was cut off."""
        return self.reader.complete


def open_recording(path: Path | str) -> RecordedSession | ForeignBag:
    """A session, or whatever bag there is at ``path``. Raises SessionError when there is none."""
    reader = SessionReader(path)
    return RecordedSession(path) if METADATA in reader.metadata else ForeignBag(reader)


class RecordedSession:
    """A session of the cloth simulation at ``path``: a bag folder or .mcap file, cut-off ones included.

    Raises:
        SessionError: there is no session at ``path``, or it is a bag of something else.
    """

    def __init__(self, path: Path | str) -> None:
        self.reader = SessionReader(path)
        self.path = self.reader.path
        if METADATA not in self.reader.metadata:
            raise SessionError(
                f"{path}: a bag, but not a session of the cloth simulation: it lacks the metadata {METADATA}"
            )
        self.about: dict[str, str] = self.reader.metadata[METADATA]
        self.window_ns: tuple[int, int] | None = None
        """Log times [ns] between which entries are given: from the first snapshot in there on."""
        self._kinds = {f"{self.namespace.rstrip('/')}/{kind.topic}": kind for kind in _ENTRIES}

    @property
    def namespace(self) -> str:
        """Full name of the node that was recorded."""
        return self.about.get("namespace", "")

    @property
    def bookkeeping(self) -> frozenset[str]:
        """The session's own topics, which no node publishes."""
        return frozenset(self._kinds)

    @property
    def complete(self) -> bool:
        """False when the recording was cut off."""
        return self.reader.complete

    @cached_property
    def scene(self) -> Scene:
        """The scene as it was simulated, overrides included. Raises SessionError when it is damaged."""
        try:
            return scene_from(self.reader.attachments, self.about)
        except SessionError as error:
            raise SessionError(f"{self.path}: {error}") from error

    def entries(self) -> Iterator[Stamped]:
        """Steps, snapshots and events in the order in which they happened.

        Raises:
            SessionError: one of them is damaged.
        """
        first, last = self.window_ns or (0, 2**64)
        begun = self.window_ns is None
        for record in self.reader.messages(self._kinds):
            if record.log_time_ns > last:
                return
            if not begun and record.log_time_ns < first and self._kinds[record.topic] is not Event:
                continue
            entry = self._decode(record)
            begun = begun or isinstance(entry, Snapshot)
            # Parameters stay in force, whenever it was that they were changed.
            if begun or (isinstance(entry, Event) and entry.kind == "parameters"):
                yield Stamped(record.log_time_ns, entry)

    def steps(self) -> Iterator[Step]:
        """The steps alone."""
        return (entry for _, entry in self.entries() if isinstance(entry, Step))

    def snapshots(self) -> Iterator[Snapshot]:
        """The snapshots alone."""
        return (entry for _, entry in self.entries() if isinstance(entry, Snapshot))

    def events(self) -> Iterator[Event]:
        """The events alone."""
        return (entry for _, entry in self.entries() if isinstance(entry, Event))

    def outputs(self, name: str) -> Iterator[Record]:
        """Recorded messages of the topic ``name`` below the node's own, for example ``cloth/points``."""
        return self.reader.messages([f"{self.namespace.rstrip('/')}/{name}"])

    def changed_versions(self) -> dict[str, tuple[str, str]]:
        """What is not as it was when the session was recorded: name to (then, now)."""
        now = versions()
        return {name: (then, now[name]) for name, then in self.about.items() if name in now and now[name] != then}

    def _decode(self, record: Record) -> Step | Snapshot | Event:
        try:
            return self._kinds[record.topic].decode(record.cdr)
        except (ValueError, KeyError, TypeError) as error:
            raise SessionError(f"{self.path}: {record.topic} at {record.log_time_ns} ns is damaged: {error}") from error
