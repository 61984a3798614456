"""Messages written by numpy read back as what went in, through the serialiser of ROS itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cloth_sim_ros.messages import cdr

serialization = pytest.importorskip("rclpy.serialization", reason="rclpy is missing: nothing to compare with")
from sensor_msgs.msg import PointCloud2, PointField  # noqa: E402
from shape_msgs.msg import Mesh  # noqa: E402
from std_msgs.msg import MultiArrayDimension, String, UInt8MultiArray  # noqa: E402
from visualization_msgs.msg import Marker  # noqa: E402

# Every remainder modulo 8 that a string can leave the fields behind it with.
FRAME_IDS = ["cloth_frame"[:length] for length in range(10)]
STAMP_NS = 1_722_000_123_456_789_012


def numbers(shape):
    return arrays(np.float64, shape, elements=st.floats(-1e3, 1e3))


@st.composite
def clouds(draw):
    vertex_count = draw(st.integers(0, 12))
    return draw(numbers((vertex_count, 3))), draw(numbers((vertex_count, 3))), draw(numbers(vertex_count))


@st.composite
def triangulations(draw):
    """Vertex positions and triangles among them, in any order and number, none included."""
    vertex_count = draw(st.integers(1, 9))
    triangle_count = draw(st.integers(0, 5))
    triangles = draw(arrays(np.int32, (triangle_count, 3), elements=st.integers(0, vertex_count - 1)))
    return draw(numbers((vertex_count, 3))), triangles


def read(data: bytes, message_type):
    assert type(data) is bytes, "publish() takes bytes and nothing else as serialised"
    return serialization.deserialize_message(data, message_type)


def stamp_ns(header) -> int:
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def points_of(points) -> np.ndarray:
    return np.array([(p.x, p.y, p.z) for p in points], dtype=np.float64).reshape(-1, 3)


def columns(cloud: PointCloud2) -> dict[str, np.ndarray]:
    """The columns of a cloud, taken apart by what its fields declare."""
    scalar = {PointField.FLOAT32: "<f4", PointField.UINT32: "<u4"}
    dtype = np.dtype(
        {
            "names": [field.name for field in cloud.fields],
            "formats": [scalar[field.datatype] for field in cloud.fields],
            "offsets": [field.offset for field in cloud.fields],
            "itemsize": cloud.point_step,
        }
    )
    table = np.frombuffer(bytes(cloud.data), dtype=dtype)
    return {name: table[name] for name in dtype.names}


@pytest.mark.parametrize("frame_id", FRAME_IDS)
@settings(max_examples=20, deadline=None)
@given(values=clouds())
def test_a_cloud_carries_position_normal_strain_and_vertex_id(frame_id, values):
    position, normal, strain = values
    cloud = read(cdr.PointCloudEncoder(frame_id).encode(STAMP_NS, position, normal, strain), PointCloud2)

    assert (cloud.header.frame_id, stamp_ns(cloud.header)) == (frame_id, STAMP_NS)
    assert (cloud.height, cloud.width, cloud.point_step) == (1, len(position), 32)
    assert cloud.row_step == len(cloud.data) == 32 * len(position)
    assert cloud.is_dense is True and cloud.is_bigendian is False
    assert all(field.count == 1 for field in cloud.fields)
    expected = {
        **dict(zip(("x", "y", "z"), position.T.astype(np.float32), strict=True)),
        **dict(zip(("normal_x", "normal_y", "normal_z"), normal.T.astype(np.float32), strict=True)),
        "strain": strain.astype(np.float32),
        "vertex_id": np.arange(len(position), dtype=np.uint32),
    }
    found = columns(cloud)
    assert list(found) == list(expected)
    for name, column in expected.items():
        np.testing.assert_array_equal(found[name], column, err_msg=name, strict=True)


def test_a_cloud_encoder_follows_a_cloth_whose_vertices_become_more_or_fewer():
    encoder = cdr.PointCloudEncoder("world")
    for step, vertex_count in enumerate((3, 5, 5, 1)):
        position = np.full((vertex_count, 3), float(step))
        cloud = read(encoder.encode(step, position, position, position[:, 0]), PointCloud2)
        assert (cloud.width, stamp_ns(cloud.header)) == (vertex_count, step)
        np.testing.assert_array_equal(columns(cloud)["vertex_id"], np.arange(vertex_count))
        np.testing.assert_array_equal(columns(cloud)["x"], np.full(vertex_count, step))


def test_earlier_bytes_stay_as_they_were_when_the_encoder_goes_on():
    encoder = cdr.MarkerEncoder("world", "cloth", 0, (1.0, 1.0, 1.0, 1.0), np.array([[0, 1, 2]]))
    first = encoder.encode(1, np.zeros((3, 3)))
    encoder.encode(2, np.ones((3, 3)))
    marker = read(first, Marker)
    assert stamp_ns(marker.header) == 1
    np.testing.assert_array_equal(points_of(marker.points), np.zeros((3, 3)))


@pytest.mark.parametrize("frame_id", FRAME_IDS)
@settings(max_examples=20, deadline=None)
@given(cloth=triangulations(), namespace=st.sampled_from(FRAME_IDS), marker_id=st.integers(-(2**31), 2**31 - 1))
def test_a_marker_carries_three_points_per_triangle(frame_id, cloth, namespace, marker_id):
    position, triangles = cloth
    encoder = cdr.MarkerEncoder(frame_id, namespace, marker_id, (0.25, 0.5, 0.75, 1.0), triangles)
    marker = read(encoder.encode(STAMP_NS, position), Marker)

    assert (marker.header.frame_id, stamp_ns(marker.header)) == (frame_id, STAMP_NS)
    assert (marker.ns, marker.id) == (namespace, marker_id)
    assert (marker.type, marker.action) == (Marker.TRIANGLE_LIST, Marker.ADD)
    np.testing.assert_array_equal(points_of(marker.points), position[triangles.ravel()])
    color = marker.color
    assert (color.r, color.g, color.b, color.a) == (0.25, 0.5, 0.75, 1.0)


@pytest.mark.parametrize("triangle_count", [0, 1, 2])
def test_every_other_field_of_a_marker_is_what_ros_would_default_to(triangle_count):
    triangles = np.zeros((triangle_count, 3), dtype=np.int32)
    encoder = cdr.MarkerEncoder("world", "cloth", 7, (1.0, 0.0, 0.0, 1.0), triangles)
    marker = read(encoder.encode(0, np.zeros((1, 3))), Marker)

    expected = Marker()
    expected.scale.x = expected.scale.y = expected.scale.z = 1.0
    for name in Marker.get_fields_and_field_types():
        if name not in ("header", "ns", "id", "type", "color", "points"):
            assert getattr(marker, name) == getattr(expected, name), name


@pytest.mark.parametrize("frame_id", FRAME_IDS)
@settings(max_examples=20, deadline=None)
@given(cloth=triangulations())
def test_triangles_travel_as_a_cloud_of_vertex_indices(frame_id, cloth):
    _, triangles = cloth
    cloud = read(cdr.encode_triangles(frame_id, STAMP_NS, triangles), PointCloud2)
    assert (cloud.header.frame_id, stamp_ns(cloud.header)) == (frame_id, STAMP_NS)
    assert (cloud.height, cloud.width, cloud.point_step, cloud.is_dense) == (1, len(triangles), 12, True)
    assert cloud.row_step == 12 * len(triangles)
    found = columns(cloud)
    assert list(found) == ["v0", "v1", "v2"]
    for column, name in enumerate(found):
        np.testing.assert_array_equal(found[name], triangles[:, column].astype(np.uint32), strict=True)


@settings(max_examples=50, deadline=None)
@given(cloth=triangulations())
def test_a_mesh_carries_triangles_and_vertices(cloth):
    position, triangles = cloth
    mesh = read(cdr.encode_mesh(triangles, position), Mesh)
    indices = [triangle.vertex_indices for triangle in mesh.triangles]
    np.testing.assert_array_equal(np.array(indices, dtype=np.int64).reshape(-1, 3), triangles)
    np.testing.assert_array_equal(points_of(mesh.vertices), position)


def test_an_empty_mesh_is_a_mesh():
    mesh = read(cdr.encode_mesh(np.zeros((0, 3), dtype=np.int32), np.zeros((0, 3))), Mesh)
    assert len(mesh.triangles) == 0 and len(mesh.vertices) == 0


@given(text=st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])))
def test_a_string_goes_to_ros_and_back(text):
    data = cdr.encode_string(text)
    assert read(data, String).data == text
    assert cdr.decode_string(data) == text
    assert cdr.decode_string(serialization.serialize_message(String(data=text))) == text


@given(octets=st.binary(max_size=40), labels=st.lists(st.sampled_from(FRAME_IDS), max_size=3))
def test_octets_go_to_ros_and_back_whatever_the_layout_says(octets, labels):
    data = cdr.encode_octets(octets)
    assert bytes(read(data, UInt8MultiArray).data) == octets
    assert cdr.decode_octets(data) == octets

    theirs = UInt8MultiArray(data=octets)
    theirs.layout.dim = [MultiArrayDimension(label=label, size=1, stride=2) for label in labels]
    assert cdr.decode_octets(serialization.serialize_message(theirs)) == octets


@pytest.mark.parametrize("decode", [cdr.decode_string, cdr.decode_octets])
@given(data=st.binary(max_size=24))
def test_damaged_bytes_are_refused_in_words(decode, data):
    """Whatever the bytes: either they decode or a ValueError says why not, never anything else."""
    for damaged in (data, cdr.ENCAPSULATION + data):
        try:
            assert isinstance(decode(damaged), (str, bytes))
        except ValueError as error:
            assert str(error)


def test_a_cut_message_is_refused():
    for encode, decode in ((cdr.encode_string, cdr.decode_string), (cdr.encode_octets, cdr.decode_octets)):
        whole = encode("cloth" if encode is cdr.encode_string else b"cloth")
        for length in range(len(whole)):
            with pytest.raises(ValueError, match="message"):
                decode(whole[:length])


def test_shapes_that_do_not_fit_are_refused():
    position = np.zeros((4, 3))
    cloud = cdr.PointCloudEncoder("world")
    with pytest.raises(ValueError, match=r"normal has shape \(1, 3\), expected \(4, 3\)"):
        cloud.encode(0, position, np.zeros((1, 3)), np.zeros(4))
    with pytest.raises(ValueError, match=r"strain has shape \(\), expected \(4,\)"):
        cloud.encode(0, position, position, np.float64(0.0))
    marker = cdr.MarkerEncoder("world", "cloth", 0, (1.0, 1.0, 1.0, 1.0), np.array([[0, 1, 4]]))
    with pytest.raises(ValueError, match=r"position has shape \(4, 3\), the triangles need \(5 or more, 3\)"):
        marker.encode(0, position)
    with pytest.raises(ValueError, match="triangles name vertex -1"):
        cdr.encode_mesh(np.array([[0, 1, -1]]), position)
    with pytest.raises(ValueError, match=r"triangles have shape \(3,\)"):
        cdr.encode_triangles("world", 0, np.array([0, 1, 2]))


@pytest.mark.parametrize("stamp", [-(2**31) * 10**9 - 1, 2**31 * 10**9])
def test_a_stamp_beyond_ros_time_is_refused(stamp):
    with pytest.raises(ValueError, match=f"stamp {stamp} ns"):
        cdr.encode_triangles("world", stamp, np.zeros((0, 3), dtype=np.int32))
