"""One bag folder being written: ``<name>/<name>_0.mcap`` and, once that is complete, ``metadata.yaml``.

A folder without metadata.yaml is therefore one that was cut off: no tool takes it for a complete bag.
"""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from cloth_sim_ros.session.bag_metadata import Tally, write_bag_metadata
from cloth_sim_ros.session.channel import Channel
from cloth_sim_ros.session.errors import SessionError

_MEDIA_TYPES = {".yaml": "application/yaml", ".json": "application/json", ".txt": "text/plain"}
# By measured processor time LZ4 is close to no compression, and it takes more than half off a Marker, so off
# the work of the disk; floats hardly shrink under either. zstd takes twice as long or more for little gain.
_COMPRESSION = CompressionType.LZ4
CHUNK_BYTES = 512 * 1024  # one chunk is one pause of the writing thread

OpenFile = Callable[[Path], BinaryIO]


def open_unbuffered(path: Path) -> BinaryIO:
    """A new file at ``path`` without a buffer of its own: what is written has left the process."""
    return open(path, "xb", buffering=0)


class Bag:
    """A bag folder under construction. Every method raises OSError when the disk does not take the data.

    Attachments and metadata stand at the start of the file, so a cut-off one has them too.
    """

    def __init__(
        self,
        folder: Path,
        *,
        attachments: Mapping[str, bytes],
        metadata: Mapping[str, Mapping[str, str]],
        open_file: OpenFile = open_unbuffered,
    ) -> None:
        """Raises SessionError when ``folder`` cannot be made, is not empty, or takes no file."""
        self.path = folder / f"{folder.name}_0.mcap"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if any(folder.iterdir()):
                raise SessionError(f"{folder}: cannot write a session here: the folder is not empty")
            self._file = _Appender(open_file(self.path))
        except OSError as error:
            raise SessionError.from_os(folder, "cannot write a session here", error) from error
        self._writer = Writer(self._file, chunk_size=CHUNK_BYTES, compression=_COMPRESSION)
        self._tally = Tally()
        self._channel_ids: dict[Channel, int] = {}
        self._schema_ids: dict[str, int] = {}
        self.safe_messages = 0
        self.safe_bytes = 0
        try:
            self._begin(attachments, metadata)
        except OSError as error:
            self.abandon()
            raise SessionError.from_os(self.path, "cannot begin a session", error) from error

    def _begin(self, attachments: Mapping[str, bytes], metadata: Mapping[str, Mapping[str, str]]) -> None:
        self._writer.start(profile="ros2", library="cloth_sim_ros")
        for name, data in attachments.items():
            media_type = _MEDIA_TYPES.get(Path(name).suffix, "application/octet-stream")
            self._writer.add_attachment(0, 0, name, media_type, data)
        for name, entries in metadata.items():
            self._writer.add_metadata(name, dict(entries))
        self._mark_safe()

    def add(self, channel: Channel, cdr: bytes, log_time_ns: int, publish_time_ns: int) -> None:
        """Append one message; it is safe on disk once ``safe_messages`` counts it."""
        if channel not in self._channel_ids:
            self._channel_ids[channel] = self._register(channel)
        before = self._file.offset
        self._tally.add(channel, log_time_ns)
        self._writer.add_message(self._channel_ids[channel], log_time_ns, cdr, publish_time_ns)
        if self._file.offset != before:  # the chunk was full, and was written with this message in it
            self._mark_safe()

    def _register(self, channel: Channel) -> int:
        if channel.type.name not in self._schema_ids:
            definition = channel.type.definition.encode("utf-8")
            schema_id = self._writer.register_schema(channel.type.name, "ros2msg", definition)
            self._schema_ids[channel.type.name] = schema_id
        schema_id = self._schema_ids[channel.type.name]
        return self._writer.register_channel(channel.topic, "cdr", schema_id, channel.metadata)

    def flush(self) -> None:
        """Write the chunk in progress: kill -9 can no longer take what was added."""
        if not self.path.exists():  # the system would go on writing into a file that nobody can find
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
        self._writer.flush()
        self._mark_safe()

    def finish(self) -> None:
        """Write indexes and metadata.yaml and close the file: from now on it is a complete bag."""
        self.flush()
        self._writer.finish()
        self._mark_safe()
        self._file.close()
        write_bag_metadata(self.path.parent, self.path.name, self._tally)

    def abandon(self) -> None:
        """Close the file behind its last complete record, for ``recover`` to finish. Raises nothing."""
        with contextlib.suppress(OSError, ValueError):  # a device has no size, a closed file takes none
            self._file.truncate(self.safe_bytes)
        with contextlib.suppress(OSError):
            self._file.close()

    def _mark_safe(self) -> None:
        self.safe_messages = self._tally.total
        self.safe_bytes = self._file.offset


class _Appender:
    """The part of a file that the MCAP writer uses. Writes all or raises, and knows its offset."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.offset = 0

    def write(self, data: bytes) -> int:
        rest = memoryview(data)
        while rest:
            written = self._file.write(rest)
            self.offset += written
            rest = rest[written:]
        return len(data)

    def tell(self) -> int:
        return self.offset

    def flush(self) -> None:
        self._file.flush()

    def truncate(self, size: int) -> None:
        self._file.truncate(size)

    def close(self) -> None:
        self._file.close()
