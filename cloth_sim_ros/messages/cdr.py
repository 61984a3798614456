"""Messages as CDR bytes, written by numpy.

A cloth at 50 Hz is too much for message objects: a Marker of 2,500 vertices built from Point objects takes
longer than the step it shows. So the large messages are laid out here once per size, and only the numbers
change. The bytes are what ``publish()`` accepts and what a session file stores.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cloth_sim_ros.messages.layout import ENCAPSULATION, CdrBuilder, message_around, unpack_uint32, write_stamp

_FLOAT32, _UINT32 = 7, 6  # sensor_msgs/PointField
_TRIANGLE_LIST, _ADD = 11, 0  # visualization_msgs/Marker
_CLOUD_FIELDS = ("x", "y", "z", "normal_x", "normal_y", "normal_z", "strain")


class PointCloudEncoder:
    """sensor_msgs/PointCloud2 of a cloth, one point per vertex.

    Fields x y z, normal_x normal_y normal_z, strain (float32) and vertex_id (uint32); height 1, width V,
    32 bytes a point, dense. Keeps a buffer between calls: use one encoder per thread.
    """

    def __init__(self, frame_id: str) -> None:
        self._frame_id = frame_id
        self._allocate(0)

    def _allocate(self, vertex_count: int) -> None:
        fields = [(name, _FLOAT32) for name in _CLOUD_FIELDS] + [("vertex_id", _UINT32)]
        self._message, data = _cloud_template(self._frame_id, fields, vertex_count)
        self._values = data.view("<f4").reshape(vertex_count, 8)
        self._ids = data.view("<u4").reshape(vertex_count, 8)[:, 7]
        self._ids[:] = np.arange(vertex_count)

    def encode(
        self,
        stamp_ns: int,
        position: NDArray[np.float64],
        normal: NDArray[np.float64],
        strain: NDArray[np.float64],
        vertex_id: NDArray[np.uint32] | None = None,
    ) -> bytes:
        """Bytes of the cloud at ``stamp_ns`` [ns].

        ``position`` [m] and unit ``normal`` have shape (V, 3), ``strain`` [1] has shape (V,). ``vertex_id`` (V,)
        numbers the points; 0 .. V - 1 if it never was given.
        Raises ValueError when the shapes disagree or the stamp does not fit into a ROS time.
        """
        vertex_count = len(position)
        for name, array, shape in (
            ("position", position, (vertex_count, 3)),
            ("normal", normal, (vertex_count, 3)),
            ("strain", strain, (vertex_count,)),
        ):
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
        if vertex_count != len(self._values):
            self._allocate(vertex_count)
        write_stamp(self._message, stamp_ns)
        self._values[:, 0:3] = position
        self._values[:, 3:6] = normal
        self._values[:, 6] = strain
        if vertex_id is not None:
            self._ids[:] = vertex_id
        return self._message.tobytes()


class MarkerEncoder:
    """visualization_msgs/Marker, TRIANGLE_LIST, in one solid colour: three points per triangle.

    ``color_rgba`` is four numbers in 0..1, ``triangles`` (T, 3) vertex indices. The pose is the identity, the
    scale 1, the marker stays until replaced. A cut or seam changes the triangles and so needs a new encoder.
    Keeps a buffer between calls: use one encoder per thread. Raises ValueError when an index is negative.
    """

    def __init__(
        self,
        frame_id: str,
        namespace: str,
        marker_id: int,
        color_rgba: tuple[float, float, float, float],
        triangles: NDArray[np.integer],
    ) -> None:
        self._corners = _corners(triangles)
        self._vertices_needed = int(self._corners.max(initial=-1)) + 1
        head = CdrBuilder()
        head.header(frame_id)
        head.string(namespace)
        head.put("i", marker_id, _TRIANGLE_LIST, _ADD)
        head.put("d", *(0.0, 0.0, 0.0), *(0.0, 0.0, 0.0, 1.0))  # position, orientation
        head.put("d", 1.0, 1.0, 1.0)  # scale
        head.put("f", *color_rgba)
        head.put("i", 0, 0)  # lifetime: for ever
        head.put("B", False)  # frame_locked
        head.put("I", len(self._corners))
        if len(self._corners):  # CDR aligns an element, not the empty sequence
            head.align(8)
        self._message, points = message_around(head, 24 * len(self._corners), _marker_tail)
        self._points = points.view("<f8").reshape(-1, 3)

    def encode(self, stamp_ns: int, position: NDArray[np.float64]) -> bytes:
        """Bytes of the marker at ``stamp_ns`` [ns] for the vertex ``position`` (V, 3) float64 [m].

        Raises ValueError when a triangle names a vertex that ``position`` does not have.
        """
        if position.ndim != 2 or position.shape[1] != 3 or len(position) < self._vertices_needed:
            expected = f"({self._vertices_needed} or more, 3)"
            raise ValueError(f"position has shape {position.shape}, the triangles need {expected}")
        write_stamp(self._message, stamp_ns)
        # The indices are known to be in range; any other mode would go through a copy of the output.
        np.take(position, self._corners, axis=0, out=self._points, mode="clip")
        return self._message.tobytes()


def encode_triangles(frame_id: str, stamp_ns: int, triangles: NDArray[np.integer]) -> bytes:
    """sensor_msgs/PointCloud2 with one point per triangle: its vertex indices v0 v1 v2 (uint32).

    ``triangles`` has shape (T, 3); ``stamp_ns`` [ns] is the stamp of the first cloud the indices fit.
    """
    corners = _corners(triangles)
    fields = [(name, _UINT32) for name in ("v0", "v1", "v2")]
    message, data = _cloud_template(frame_id, fields, len(corners) // 3)
    data.view("<u4")[:] = corners
    write_stamp(message, stamp_ns)
    return message.tobytes()


def encode_mesh(triangles: NDArray[np.integer], position: NDArray[np.float64]) -> bytes:
    """shape_msgs/Mesh of ``triangles`` (T, 3) and vertex ``position`` (V, 3) [m]."""
    corners = _corners(triangles)
    position = np.asarray(position, dtype=np.float64)
    if position.ndim != 2 or position.shape[1] != 3:
        raise ValueError(f"position has shape {position.shape}, expected (V, 3)")
    cdr = CdrBuilder()
    cdr.put("I", len(corners) // 3)
    cdr.append(corners.astype("<u4").tobytes())
    cdr.put("I", len(position))
    if len(position):
        cdr.align(8)
        cdr.append(position.astype("<f8").tobytes())
    return cdr.message()


def encode_string(text: str) -> bytes:
    """std_msgs/String."""
    cdr = CdrBuilder()
    cdr.string(text)
    return cdr.message()


def encode_octets(data: bytes) -> bytes:
    """std_msgs/UInt8MultiArray without dimensions, carrying ``data``."""
    cdr = CdrBuilder()
    cdr.put("I", 0, 0, len(data))  # no dimensions, data_offset, length
    cdr.append(data)
    return cdr.message()


def decode_string(cdr: bytes) -> str:
    """Text of a std_msgs/String. Raises ValueError when the bytes are not one in little-endian CDR."""
    (length,) = unpack_uint32(cdr, 0, 1)
    if length < 1 or len(cdr) < 8 + length:
        raise ValueError(f"a string of {length} bytes does not fit into a message of {len(cdr)} bytes")
    return cdr[8 : 7 + length].decode("utf-8")


def decode_octets(cdr: bytes) -> bytes:
    """Data of a std_msgs/UInt8MultiArray; its layout is skipped.

    Raises ValueError when the bytes are not one in little-endian CDR.
    """
    (dimensions,) = unpack_uint32(cdr, 0, 1)
    offset = 4
    for _ in range(dimensions):
        (label,) = unpack_uint32(cdr, offset, 1)
        offset += 4 + label + -label % 4 + 8  # label, padding, size and stride
    _, length = unpack_uint32(cdr, offset, 2)
    start = len(ENCAPSULATION) + offset + 8
    if len(cdr) < start + length:
        raise ValueError(f"an array of {length} bytes does not fit into a message of {len(cdr)} bytes")
    return cdr[start : start + length]


def _cloud_template(
    frame_id: str, fields: list[tuple[str, int]], width: int
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """A PointCloud2 of four-byte ``fields`` and ``width`` points, stamp and data 0: message, data."""
    head = CdrBuilder()
    head.header(frame_id)
    head.put("I", 1, width, len(fields))
    for index, (name, datatype) in enumerate(fields):
        head.string(name)
        head.put("I", 4 * index)
        head.put("B", datatype)
        head.put("I", 1)
    point_step = 4 * len(fields)
    head.put("B", False)  # is_bigendian
    head.put("I", point_step, point_step * width, point_step * width)  # point_step, row_step, length of data
    return message_around(head, point_step * width, lambda tail: tail.put("B", True))  # is_dense


def _marker_tail(tail: CdrBuilder) -> None:
    """The fields of a Marker behind its points, all empty."""
    tail.put("I", 0)  # colors
    tail.string("")  # texture_resource
    tail.header("")  # texture
    tail.string("")  # texture.format
    tail.put("I", 0, 0)  # texture.data, uv_coordinates
    tail.string("")  # text
    tail.string("")  # mesh_resource
    tail.string("")  # mesh_file.filename
    tail.put("I", 0)  # mesh_file.data
    tail.put("B", False)  # mesh_use_embedded_materials


def _corners(triangles: NDArray[np.integer]) -> NDArray[np.intp]:
    """The vertex indices of (T, 3) triangles in one row, checked."""
    triangles = np.asarray(triangles)
    if triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError(f"triangles have shape {triangles.shape}, expected (T, 3)")
    if triangles.min(initial=0) < 0:
        raise ValueError(f"triangles name vertex {triangles.min()}, indices start at 0")
    return triangles.reshape(-1).astype(np.intp)
