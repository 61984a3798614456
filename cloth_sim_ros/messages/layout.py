"""How a CDR message is laid out: the rules behind ``cdr.py``.

Plain CDR (XCDR version 1), little endian: four bytes of encapsulation header, then the body, where each
primitive is aligned to its own size, counted from the start of the body. Source: OMG DDS-XTypes 1.3, 7.4.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

ENCAPSULATION = b"\x00\x01\x00\x00"
_NANOSECONDS = 1_000_000_000


class CdrBuilder:
    """The body of a message under construction, or a part of it that begins ``origin`` bytes into it."""

    def __init__(self, origin: int = 0) -> None:
        self.data = bytearray()
        self._origin = origin

    def align(self, size: int) -> None:
        """Pad to a multiple of ``size`` bytes."""
        self.data.extend(bytes(-(self._origin + len(self.data)) % size))

    def append(self, data: bytes) -> None:
        """Append ``data`` as it is."""
        self.data.extend(data)

    def put(self, code: str, *values: float) -> None:
        """Append primitives of one ``struct`` code, aligned."""
        self.align(struct.calcsize(code))
        self.data.extend(struct.pack(f"<{len(values)}{code}", *values))

    def string(self, text: str) -> None:
        """Append a string: its length with the closing zero, its UTF-8 bytes, the zero."""
        encoded = text.encode("utf-8") + b"\x00"
        self.put("I", len(encoded))
        self.append(encoded)

    def header(self, frame_id: str) -> None:
        """Append a std_msgs/Header, its stamp left 0."""
        self.put("I", 0, 0)
        self.string(frame_id)

    def message(self) -> bytes:
        """The complete message."""
        return ENCAPSULATION + bytes(self.data)


def message_around(
    head: CdrBuilder, payload_size: int, write_tail: Callable[[CdrBuilder], None]
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """A message of ``head``, ``payload_size`` bytes still 0, and what ``write_tail`` appends.

    Returns the whole message and the view of the payload in it. A payload that CDR aligns to 4 or 8 bytes is
    aligned in memory too, so it may be viewed as floats or doubles.
    """
    start = len(head.data)
    tail = CdrBuilder(origin=start + payload_size)
    write_tail(tail)
    body_size = start + payload_size + len(tail.data)
    # The doubles underneath put the body, which follows 4 + 4 bytes, on a multiple of 8.
    storage = np.zeros(1 + -(-body_size // 8), dtype=np.float64).view(np.uint8)
    message = storage[4 : 8 + body_size]
    message[:4] = np.frombuffer(ENCAPSULATION, dtype=np.uint8)
    message[4 : 4 + start] = np.frombuffer(head.data, dtype=np.uint8)
    message[4 + start + payload_size :] = np.frombuffer(tail.data, dtype=np.uint8)
    return message, message[4 + start : 4 + start + payload_size]


def write_stamp(message: NDArray[np.uint8], stamp_ns: int) -> None:
    """Set the stamp of a ``message`` that begins with a std_msgs/Header to ``stamp_ns`` [ns].

    Raises ValueError when it does not fit into a ROS time.
    """
    seconds, nanoseconds = divmod(int(stamp_ns), _NANOSECONDS)
    if not -(2**31) <= seconds < 2**31:
        raise ValueError(f"stamp {stamp_ns} ns does not fit into the 32-bit seconds of a ROS time")
    struct.pack_into("<iI", message, len(ENCAPSULATION), seconds, nanoseconds)


def unpack_uint32(cdr: bytes, offset: int, count: int) -> tuple[int, ...]:
    """``count`` uint32 that begin ``offset`` bytes into the body of ``cdr``.

    Raises ValueError when the message is shorter or is not little-endian CDR.
    """
    if cdr[:2] != ENCAPSULATION[:2]:
        raise ValueError(f"the message starts with {cdr[:4]!r}, not with the header of little-endian CDR")
    start = len(ENCAPSULATION) + offset
    if len(cdr) < start + 4 * count:
        raise ValueError(f"the message ends after {len(cdr)} bytes, {start + 4 * count} are needed")
    return struct.unpack_from(f"<{count}I", cdr, start)
