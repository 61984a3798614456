"""Message definitions are found, and completed with what they depend on, without ROS running."""

from __future__ import annotations

import pytest

from cloth_sim_ros.session import SessionError, find_message_type

pytest.importorskip("sensor_msgs", reason="no ROS message definitions are installed")


def sections(definition: str) -> list[str]:
    """The names of the types that a schema text defines behind the first."""
    separator, *_ = [line for line in definition.splitlines() if line.startswith("====")] or ["="]
    return [part.split("\n", 1)[0] for part in definition.split(f"{separator}\nMSG: ")[1:]]


def test_a_definition_carries_everything_it_depends_on_once():
    found = find_message_type("visualization_msgs/msg/Marker")
    assert found.name == "visualization_msgs/msg/Marker"
    assert "int32 TRIANGLE_LIST=11" in found.definition
    names = sections(found.definition)
    assert len(names) == len(set(names))
    assert set(names) == {
        "std_msgs/Header",
        "geometry_msgs/Pose",
        "geometry_msgs/Vector3",
        "std_msgs/ColorRGBA",
        "builtin_interfaces/Duration",
        "geometry_msgs/Point",
        "sensor_msgs/CompressedImage",
        "visualization_msgs/UVCoordinate",
        "visualization_msgs/MeshFile",
        "builtin_interfaces/Time",
        "geometry_msgs/Quaternion",
    }


def test_a_definition_without_dependencies_is_its_file_alone():
    found = find_message_type("std_msgs/msg/Float64")
    assert sections(found.definition) == []
    assert "float64 data" in found.definition


@pytest.mark.parametrize(
    "name",
    [
        "sensor_msgs/msg/PointCloud2",
        "visualization_msgs/msg/MarkerArray",
        "diagnostic_msgs/msg/DiagnosticArray",
        "rcl_interfaces/msg/ParameterEvent",
        "rcl_interfaces/msg/ParameterDescriptor",
        "shape_msgs/msg/Mesh",
        "std_msgs/msg/UInt8MultiArray",
    ],
)
def test_the_hash_is_the_one_that_another_implementation_computes(name):
    stores = pytest.importorskip("rosbags.typesys", reason="rosbags is not installed: no second opinion")
    found = find_message_type(name)
    definitions = stores.get_types_from_msg(found.definition, name)
    typestore = stores.get_typestore(stores.Stores.EMPTY)
    typestore.register(definitions)
    assert found.type_hash == typestore.hash_rihs01(name)


def test_the_short_form_of_a_name_means_the_same():
    assert find_message_type("std_msgs/String") == find_message_type("std_msgs/msg/String")


def test_ament_prefix_path_comes_first(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "cloth_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Fold.msg").write_text("float64[<=3] axis # std_msgs/Nowhere\nEdge[2] edges\n", encoding="utf-8")
    (folder / "Edge.msg").write_text("string<=8 name\nuint32 A=1\ngeometry_msgs/Point[] at\n", encoding="utf-8")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}:/nowhere")
    found = find_message_type("cloth_msgs/msg/Fold")
    assert sections(found.definition) == ["cloth_msgs/Edge", "geometry_msgs/Point"]
    assert found.type_hash == ""


@pytest.mark.parametrize("name", ["std_msgs/msg/Nothing", "no_msgs/msg/String"])
def test_an_unknown_type_is_refused_with_the_places_searched(name):
    package, _, short = name.split("/")
    with pytest.raises(SessionError, match=f"{name}: no share/{package}/msg/{short}.msg below any of: /"):
        find_message_type(name)


@pytest.mark.parametrize("name", ["", "String", "std_msgs/srv/Trigger", "../msg/String", "std_msgs/msg/a/b"])
def test_what_is_no_type_name_is_refused(name):
    with pytest.raises(SessionError, match="is not the name of a message type"):
        find_message_type(name)
