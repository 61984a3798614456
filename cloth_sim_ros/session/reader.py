"""Reading a session, or any ROS 2 bag in MCAP files, cut-off ones included."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import mcap.records
from mcap.opcode import Opcode
from mcap.records import Chunk, McapRecord, Message, Schema
from mcap.stream_reader import breakup_chunk
from ruamel.yaml.error import YAMLError

from cloth_sim_ros.session import bag_metadata
from cloth_sim_ros.session.channel import Channel
from cloth_sim_ros.session.errors import SessionError
from cloth_sim_ros.session.records import DAMAGE, Survey, content, spans, survey
from cloth_sim_ros.session.schemas import MessageType
from cloth_sim_ros.session.yaml_text import load


@dataclass(frozen=True)
class Record:
    """One recorded message: serialised as ``cdr``, with its times [ns]."""

    topic: str
    type_name: str
    cdr: bytes
    log_time_ns: int
    publish_time_ns: int


class Entry(NamedTuple):
    """A message with the channel it came through."""

    channel: Channel
    record: Record


OnDamage = Callable[[SessionError], None]


def _raise(error: SessionError) -> None:
    raise error


class SessionReader:
    """The session at ``path``: a bag folder, or one .mcap file.

    ``attachments`` (name to content), ``metadata`` (name to keys and values). ``complete`` is False when the
    session was cut off, so that only what is before the cut can be read and other tools refuse it: see
    ``recover``. Raises SessionError when there is no session at ``path``.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._surveys = {file: survey(file) for file in _files(self.path)}
        self.attachments: dict[str, bytes] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        for found in self._surveys.values():
            self.attachments.update(found.attachments)
            self.metadata.update(found.metadata)
        whole = all(found.complete for found in self._surveys.values())
        self.complete = whole and (self.path.is_file() or (self.path / bag_metadata.FILE_NAME).is_file())

    @property
    def lost_bytes(self) -> int:
        """Bytes behind the last whole record, which cannot be read."""
        cut = [(file, found.end) for file, found in self._surveys.items() if not found.complete]
        return sum(file.stat().st_size - end for file, end in cut)

    @property
    def times_ns(self) -> tuple[int, int]:
        """Log times [ns] of the first and the last message; 0 and 0 without any."""
        first = [found.first_ns for found in self._surveys.values() if found.first_ns is not None]
        last = [found.last_ns for found in self._surveys.values() if found.last_ns is not None]
        return (min(first), max(last)) if first else (0, 0)

    def messages(self, topics: Collection[str] | None = None) -> Iterator[Record]:
        """The messages, of all topics or of ``topics``, in the order in which they are in the file.

        Raises SessionError at a damaged record, and at a topic that is not in ROS 2's CDR.
        """
        for entry in self.entries(topics):
            yield entry.record

    def entries(
        self, topics: Collection[str] | None = None, *, on_damage: OnDamage = _raise
    ) -> Iterator[Entry]:
        """As ``messages``, each with its channel; ``on_damage`` may return to go on behind the damage."""
        for file, found in self._surveys.items():
            yield from _FileReader(file, found, on_damage).entries(topics)


class _FileReader:
    """Reads one file from front to end, learning its schemas and channels on the way."""

    def __init__(self, path: Path, found: Survey, on_damage: OnDamage) -> None:
        self._path = path
        self._on_damage = on_damage
        self._schemas = dict(found.schemas)
        self._raw_channels = dict(found.channels)
        self._channels: dict[int, Channel] = {}

    def entries(self, topics: Collection[str] | None) -> Iterator[Entry]:
        for offset, record in self._records():
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, mcap.records.Channel):
                self._raw_channels[record.id] = record
            elif isinstance(record, Message):
                raw = self._raw_channels.get(record.channel_id)
                if raw is None:
                    self._damage(
                        offset, f"a message on channel {record.channel_id}, which nothing introduced"
                    )
                elif topics is None or raw.topic in topics:
                    channel = self._channel(raw)
                    times = record.log_time, record.publish_time
                    yield Entry(channel, Record(channel.topic, channel.type.name, record.data, *times))

    def _records(self) -> Iterator[tuple[int, McapRecord]]:
        """Schemas, channels and messages in and outside of chunks, with the offset [B] they are found at."""
        with open(self._path, "rb") as stream:
            for span in spans(stream):
                if span.opcode == Opcode.DATA_END:
                    return
                stream_of = content(stream, span)
                try:
                    if span.opcode == Opcode.CHUNK:
                        records = breakup_chunk(Chunk.read(stream_of), validate_crc=True)
                    elif span.opcode == Opcode.MESSAGE:
                        records = [Message.read(stream_of, span.length)]
                    else:
                        continue  # schemas and channels outside of chunks are in the survey
                except DAMAGE as error:
                    self._damage(span.offset, str(error) or type(error).__name__)
                    continue
                yield from ((span.offset, record) for record in records)

    def _channel(self, raw: mcap.records.Channel) -> Channel:
        if raw.id not in self._channels:
            schema = self._schemas.get(raw.schema_id)
            if raw.message_encoding != "cdr" or schema is None or schema.encoding != "ros2msg":
                encoding = f"{raw.message_encoding}/{schema.encoding if schema else 'no schema'}"
                raise SessionError(f"{self._path}: {raw.topic} is encoded as {encoding}, not as cdr/ros2msg")
            self._channels[raw.id] = Channel(
                raw.topic,
                MessageType(
                    schema.name, schema.data.decode("utf-8"), raw.metadata.get("topic_type_hash", "")
                ),
                raw.metadata.get("offered_qos_profiles", ""),
            )
        return self._channels[raw.id]

    def _damage(self, offset: int, reason: str) -> None:
        self._on_damage(SessionError(f"{self._path}: the record at byte {offset} is damaged: {reason}"))


def _files(path: Path) -> list[Path]:
    """The .mcap files at ``path``, in their order."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise SessionError(f"{path}: no such session: there is neither a folder nor a file")
    files = _listed(path) or sorted(path.glob("*.mcap"), key=lambda file: (len(file.name), file.name))
    if not files:
        sqlite = any(path.glob("*.db3"))
        hint = (
            "it holds an sqlite3 bag, convert it with 'ros2 bag convert'"
            if sqlite
            else "it holds no .mcap file"
        )
        raise SessionError(f"{path}: not a session: {hint}")
    return files


def _listed(folder: Path) -> list[Path]:
    """The .mcap files that the folder's metadata.yaml lists, if it does."""
    try:
        information = load((folder / bag_metadata.FILE_NAME).read_text(encoding="utf-8"))
        names = information["rosbag2_bagfile_information"]["relative_file_paths"]
    except FileNotFoundError:
        return []
    except (YAMLError, UnicodeDecodeError, KeyError, TypeError) as error:
        raise SessionError(
            f"{folder / bag_metadata.FILE_NAME}: not the description of a bag: {error}"
        ) from error
    return [folder / name for name in names if str(name).endswith(".mcap")]
