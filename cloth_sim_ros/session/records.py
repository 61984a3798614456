"""MCAP files record by record, also those that end in the middle of one.

The readers of the mcap package want a complete file, or lose the place where it breaks off. A file is a
magic number, then records of one byte of opcode, eight of length and the content, to the footer and the
magic again. Source: MCAP specification, "Structure of an MCAP file".
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Metadata, Schema
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

from cloth_sim_ros.session.errors import SessionError

_HEAD = struct.Struct("<BQ")
_CHUNK_TIMES = struct.Struct("<QQ")  # at the start of a chunk: log times of its first and last message, ns

# What parsing and unpacking raise at bytes that are not what they should be.
DAMAGE = (McapError, ZstdError, ValueError, RuntimeError, OverflowError, MemoryError, struct.error)


class Span(NamedTuple):
    """Where one whole record lies: its opcode, the offset [B] and the length [B] of its content."""

    opcode: int
    offset: int
    length: int

    @property
    def end(self) -> int:
        """Offset [B] of the byte behind the record."""
        return self.offset + self.length


@dataclass
class Survey:
    """What a file holds beside messages, and how far it is good.

    ``end`` [B] is where the last whole record ends; the file is ``complete`` if it closes as it should.
    ``schemas`` and ``channels``, by id, are those outside of chunks: all of them where the file has a
    summary. ``first_ns`` and ``last_ns`` are log times of the messages in chunks, None without any.
    """

    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    end: int = len(MCAP0_MAGIC)
    complete: bool = False
    first_ns: int | None = None
    last_ns: int | None = None


def spans(stream: BinaryIO) -> Iterator[Span]:
    """The whole records of a file, in order, to the footer or to where it was cut."""
    size = os.fstat(stream.fileno()).st_size
    offset = len(MCAP0_MAGIC)
    while offset + _HEAD.size <= size:
        stream.seek(offset)
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        span = Span(opcode, offset + _HEAD.size, length)
        # No record has opcode 0: this is space that the file system gave and nobody filled.
        if opcode == 0 or span.end > size:
            return
        yield span
        if opcode == Opcode.FOOTER:
            return
        offset = span.end


def content(stream: BinaryIO, span: Span) -> ReadDataStream:
    """The content of the record at ``span``, for the ``read`` of its class in ``mcap.records``."""
    stream.seek(span.offset)
    # Only these bytes: a damaged length inside must not make the record reach, or allocate, beyond them.
    return ReadDataStream(io.BytesIO(stream.read(span.length)))


def survey(path: Path) -> Survey:
    """Walk over the file at ``path`` without reading its chunks.

    Raises SessionError when it is no MCAP file, or is damaged where it should hold attachments or metadata.
    """
    found = Survey()
    try:
        with open(path, "rb") as stream:
            if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
                raise SessionError(f"{path}: not a session: the file does not begin as MCAP files do")
            for span in spans(stream):
                _note(found, stream, span)
    except OSError as error:
        raise SessionError.from_os(path, "cannot read the session", error) from error
    except DAMAGE as error:
        raise SessionError(f"{path}: the record at byte {found.end} is damaged: {error}") from error
    return found


def _note(found: Survey, stream: BinaryIO, span: Span) -> None:
    if span.opcode == Opcode.ATTACHMENT:
        attachment = Attachment.read(content(stream, span))
        found.attachments[attachment.name] = attachment.data
    elif span.opcode == Opcode.METADATA:
        metadata = Metadata.read(content(stream, span))
        found.metadata[metadata.name] = metadata.metadata
    elif span.opcode == Opcode.SCHEMA:
        schema = Schema.read(content(stream, span))
        found.schemas[schema.id] = schema
    elif span.opcode == Opcode.CHANNEL:
        channel = Channel.read(content(stream, span))
        found.channels[channel.id] = channel
    elif span.opcode == Opcode.CHUNK and span.length >= _CHUNK_TIMES.size:
        stream.seek(span.offset)
        first, last = _CHUNK_TIMES.unpack(stream.read(_CHUNK_TIMES.size))
        if last:  # a chunk without messages has the times 0
            found.first_ns = first if found.first_ns is None else min(first, found.first_ns)
            found.last_ns = last if found.last_ns is None else max(last, found.last_ns)
    elif span.opcode == Opcode.FOOTER:
        stream.seek(span.end)
        found.complete = stream.read(len(MCAP0_MAGIC)) == MCAP0_MAGIC
    found.end = span.end
