"""A session is a ROS 2 bag: rosbags reads it, from the definitions in the file and with its own."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_sim_ros.messages import cdr
from cloth_sim_ros.session import Qos, SessionWriter, find_message_type

highlevel = pytest.importorskip("rosbags.highlevel", reason="rosbags is not installed")
pytest.importorskip("visualization_msgs", reason="no ROS message definitions are installed")
from rosbags.interfaces import QosDurability, QosReliability  # noqa: E402
from rosbags.rosbag2 import Reader  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

CLOUD, MARKER = "sensor_msgs/msg/PointCloud2", "visualization_msgs/msg/Marker"
STRING, MESH = "std_msgs/msg/String", "shape_msgs/msg/Mesh"
POSITION = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 3.0], [1.0, 1.0, 4.0]])
TRIANGLES = np.array([[0, 1, 2], [1, 3, 2]], dtype=np.int32)
START_NS = 1_722_000_000_000_000_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A session of a cloth that rises 1 m a step for three steps."""
    folder = tmp_path_factory.mktemp("bags") / "session"
    cloud = cdr.PointCloudEncoder("world")
    marker = cdr.MarkerEncoder("world", "cloth", 0, (0.25, 0.5, 0.75, 1.0), TRIANGLES)
    with SessionWriter(folder, attachments={"scene.yaml": b"a: 1"}, metadata={"run": {"seed": "7"}}) as writer:
        latched = Qos(durability="transient_local", depth=1)
        writer.write("/mesh", MESH, cdr.encode_mesh(TRIANGLES, POSITION), START_NS, qos=latched)
        for step in range(3):
            stamp = START_NS + step * 20_000_000
            position = POSITION + np.array([0.0, 0.0, step])
            points = cloud.encode(stamp, position, np.zeros((4, 3)), np.zeros(4))
            writer.write("/points", CLOUD, points, stamp, expendable=True)
            writer.write("/marker", MARKER, marker.encode(stamp, position), stamp, expendable=True)
            writer.write("/step", STRING, cdr.encode_string(f"step {step}"), stamp)
    return folder


@pytest.fixture(params=["definitions in the file", "definitions of rosbags"])
def bag(request, folder):
    """The session, opened by rosbags with either source of definitions."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with highlevel.AnyReader([folder], default_typestore=store) as reader:
        if request.param == "definitions of rosbags":
            reader.typestore = store
        yield reader


def read(bag, topic):
    connections = [connection for connection in bag.connections if connection.topic == topic]
    return [(time, bag.deserialize(data, connection.msgtype)) for connection, time, data in bag.messages(connections)]


def test_the_clouds_are_the_ones_that_were_written(bag):
    clouds = read(bag, "/points")
    assert [time for time, _ in clouds] == [START_NS + step * 20_000_000 for step in range(3)]
    for step, (_, cloud) in enumerate(clouds):
        points = cloud.data.view("<f4").reshape(4, 8)
        np.testing.assert_array_equal(points[:, :3], POSITION + np.array([0.0, 0.0, step]))
        np.testing.assert_array_equal(cloud.data.view("<u4").reshape(4, 8)[:, 7], np.arange(4))


def test_the_markers_are_the_ones_that_were_written(bag):
    for step, (_, marker) in enumerate(read(bag, "/marker")):
        points = [(point.x, point.y, point.z) for point in marker.points]
        np.testing.assert_array_equal(points, (POSITION + np.array([0.0, 0.0, step]))[TRIANGLES.ravel()])
        assert (marker.color.r, marker.color.a) == (0.25, 1.0)


def test_mesh_and_text_are_the_ones_that_were_written(bag):
    ((_, mesh),) = read(bag, "/mesh")
    np.testing.assert_array_equal([triangle.vertex_indices for triangle in mesh.triangles], TRIANGLES)
    assert [message.data for _, message in read(bag, "/step")] == ["step 0", "step 1", "step 2"]


def test_the_metadata_tells_types_hashes_qos_counts_and_times(folder):
    with Reader(folder) as bag:
        connections = {connection.topic: connection for connection in bag.connections}
        assert bag.message_count == 10
        assert (bag.start_time, bag.duration) == (START_NS, 40_000_001)  # rosbags counts the last nanosecond
    assert {topic: connection.msgcount for topic, connection in connections.items()} == {
        "/mesh": 1,
        "/points": 3,
        "/marker": 3,
        "/step": 3,
    }
    for connection in connections.values():
        assert connection.digest == find_message_type(connection.msgtype).type_hash
        (qos,) = connection.ext.offered_qos_profiles
        assert qos.reliability is QosReliability.RELIABLE
        latched = connection.topic == "/mesh"
        assert qos.durability is (QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE)
        assert qos.depth == (1 if latched else 5)


def test_an_empty_session_is_a_bag_too(tmp_path):
    with SessionWriter(tmp_path / "empty"):
        pass
    with Reader(tmp_path / "empty") as bag:
        assert bag.message_count == 0
        assert list(bag.messages()) == []
