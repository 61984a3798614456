"""Recording a session beside a simulation that must not wait for a disk."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cloth_sim_ros.session.bag import CHUNK_BYTES, Bag, OpenFile, open_unbuffered
from cloth_sim_ros.session.channel import Channel, Qos
from cloth_sim_ros.session.errors import SessionError
from cloth_sim_ros.session.schemas import find_message_type

_MAX_TIME_NS = 2**64 - 1


@dataclass(frozen=True)
class Health:
    """How a recording does.

    ``messages`` and ``bytes`` [B] are in the file and survive kill -9; ``dropped`` messages will never be
    there; ``error`` says why the recording stopped, or lacks a topic.
    """

    folder: Path
    messages: int
    bytes: int
    dropped: int
    error: str | None


class _Entry(NamedTuple):
    topic: str
    type_name: str
    cdr: bytes
    log_time_ns: int
    publish_time_ns: int
    qos: Qos


class SessionWriter:
    """A session being recorded into ``folder``; a thread of its own does all the writing.

    ``attachments`` (name to content) and ``metadata`` (name to keys and values) go to the start of the file.
    What is written is handed to the operating system at least once per ``flush_period_s`` [s]: kill -9 loses
    no more. Up to ``queue_bytes`` [B] may wait for the disk; beyond that expendable messages are dropped,
    the others still wait.

    Close it, or leave its ``with`` block: a program that just ends loses what a kill would.
    A disk that fails ends the recording, not the caller: see ``health``. What had been written until then
    stays readable. Raises SessionError when the session cannot be begun: the folder holds something or is
    not writable; ValueError when the period is not positive.
    """

    def __init__(
        self,
        folder: Path | str,
        *,
        attachments: Mapping[str, bytes] | None = None,
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        flush_period_s: float = 1.0,
        queue_bytes: int = 64 * 1024 * 1024,
        open_file: OpenFile = open_unbuffered,
    ) -> None:
        if not flush_period_s > 0.0:
            raise ValueError(f"flush_period_s is {flush_period_s} s, allowed is more than 0 s")
        self._folder = Path(folder).absolute()
        self._bag = Bag(
            self._folder, attachments=attachments or {}, metadata=metadata or {}, open_file=open_file
        )
        self._flush_period_s = flush_period_s
        self._queue_bytes = queue_bytes
        self._wake_bytes = min(CHUNK_BYTES, queue_bytes // 2)
        self._channels: dict[tuple[str, str], Channel | None] = {}

        self._wake = threading.Condition()  # guards everything below
        self._queue: deque[_Entry] = deque()
        self._pending_bytes = 0  # queued, or just being written
        self._closing = False
        self._dropped = 0
        self._accepted = 0
        self._error: str | None = None
        self._thread = threading.Thread(target=self._run, name="session writer", daemon=True)
        self._thread.start()

    def write(
        self,
        topic: str,
        type_name: str,
        cdr: bytes,
        log_time_ns: int,
        publish_time_ns: int | None = None,
        *,
        expendable: bool = False,
        qos: Qos | None = None,
    ) -> bool:
        """Queue one serialised message; returns at once, from any thread, with whether it was taken.

        ``log_time_ns`` and ``publish_time_ns`` (default: the same) are ROS times [ns]. ``expendable``
        messages give way when the disk falls behind. ``qos`` is what the topic offers; the topic's first
        message decides. Raises TypeError when ``cdr`` is not bytes, ValueError when a time is outside
        0..2^64-1 ns.
        """
        if publish_time_ns is None:
            publish_time_ns = log_time_ns
        if not isinstance(cdr, bytes):
            raise TypeError(f"{topic}: a message is recorded as bytes, not {type(cdr).__name__}")
        for name, value in (("log_time_ns", log_time_ns), ("publish_time_ns", publish_time_ns)):
            if not 0 <= value <= _MAX_TIME_NS:
                raise ValueError(f"{topic}: {name} is {value}, allowed is 0 to {_MAX_TIME_NS} ns")
        entry = _Entry(topic, type_name, cdr, log_time_ns, publish_time_ns, qos or Qos())
        with self._wake:
            full = self._pending_bytes + len(cdr) > self._queue_bytes
            if self._closing or (full and expendable):
                self._dropped += 1
                return False
            self._queue.append(entry)
            self._accepted += 1
            self._pending_bytes += len(cdr)
            # Waking the thread for each small message would cost more than writing it.
            if self._pending_bytes >= self._wake_bytes:
                self._wake.notify()
        return True

    @property
    def health(self) -> Health:
        """How the recording does right now."""
        with self._wake:
            return Health(
                self._folder, self._bag.safe_messages, self._bag.safe_bytes, self._dropped, self._error
            )

    def close(self) -> Health:
        """Write what is queued, then the indexes and metadata.yaml, and wait for it.

        Calling again changes nothing.
        """
        with self._wake:
            self._closing = True
            self._wake.notify()
        self._thread.join()
        return self.health

    def __enter__(self) -> SessionWriter:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            self._record_until_closed()
            self._bag.finish()
        except OSError as error:
            self._fail(error.strerror or str(error))
        except Exception as error:  # a thread that died in silence would look like a healthy recording
            self._fail(f"{type(error).__name__}: {error}")

    def _record_until_closed(self) -> None:
        closing = False
        flush_at = time.monotonic() + self._flush_period_s
        while not closing:
            entries, closing = self._next_entries(flush_at - time.monotonic())
            for entry in entries:
                self._add(entry)
            if time.monotonic() >= flush_at:
                self._bag.flush()
                flush_at = time.monotonic() + self._flush_period_s

    def _next_entries(self, timeout_s: float) -> tuple[list[_Entry], bool]:
        """What is queued, once it fills a chunk or ``timeout_s`` [s] are over; and whether it is the last."""
        with self._wake:
            self._wake.wait_for(lambda: self._closing or self._pending_bytes >= self._wake_bytes, timeout_s)
            entries = list(self._queue)
            self._queue.clear()
            return entries, self._closing

    def _add(self, entry: _Entry) -> None:
        channel = self._channel(entry)
        if channel is not None:
            self._bag.add(channel, entry.cdr, entry.log_time_ns, entry.publish_time_ns)
        with self._wake:
            self._pending_bytes -= len(entry.cdr)
            if channel is None:
                self._accepted -= 1
                self._dropped += 1

    def _channel(self, entry: _Entry) -> Channel | None:
        """The channel of an entry; None when its type is unknown: that costs the topic, not the session."""
        key = (entry.topic, entry.type_name)
        if key not in self._channels:
            try:
                message_type = find_message_type(entry.type_name)
                self._channels[key] = Channel(entry.topic, message_type, entry.qos.to_yaml())
            except (SessionError, OSError) as error:
                self._channels[key] = None
                with self._wake:
                    self._error = self._error or f"{entry.topic} is not recorded: {error}"
        return self._channels[key]

    def _fail(self, reason: str) -> None:
        self._bag.abandon()
        with self._wake:
            self._closing = True
            self._error = f"{self._bag.path}: recording stopped: {reason}"
            self._dropped += self._accepted - self._bag.safe_messages
            self._queue.clear()
