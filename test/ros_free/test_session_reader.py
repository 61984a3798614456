"""A reader takes every bag, gives all that is whole in a broken one, and says what is wrong with the rest."""

from __future__ import annotations

import pytest
from mcap.writer import CompressionType, Writer

from cloth_sim_ros.messages import cdr
from cloth_sim_ros.session import Channel, Qos, SessionError, SessionReader, find_message_type
from cloth_sim_ros.session.bag import Bag

STRING = "std_msgs/msg/String"


def texts(reader: SessionReader) -> list[str]:
    return [cdr.decode_string(record.cdr) for record in reader.messages()]


def write_bag(path, words, *, encoding="cdr", **options):
    """A bag file as other tools write them: schemas and channels wherever the options put them."""
    with open(path, "wb") as stream:
        writer = Writer(stream, **options)
        writer.start(profile="ros2")
        schema = writer.register_schema(STRING, "ros2msg", b"string data\n")
        channel = writer.register_channel("/text", encoding, schema)
        for n, word in enumerate(words):
            writer.add_message(channel, n, cdr.encode_string(word), n)
        writer.finish()


@pytest.fixture(scope="module")
def session_bytes(tmp_path_factory) -> bytes:
    """A session with an attachment, metadata and a chunk for each of its twelve messages."""
    pytest.importorskip("std_msgs", reason="no ROS message definitions are installed")
    folder = tmp_path_factory.mktemp("whole") / "s"
    bag = Bag(folder, attachments={"scene.yaml": b"a: 1"}, metadata={"run": {"seed": "7"}})
    channel = Channel("/text", find_message_type(STRING), Qos().to_yaml())
    for n in range(12):
        bag.add(channel, cdr.encode_string(str(n)), n, n)
        bag.flush()
    bag.finish()
    return (folder / "s_0.mcap").read_bytes()


def test_a_session_cut_at_any_byte_gives_the_messages_before_the_cut(session_bytes, tmp_path):
    path = tmp_path / "cut.mcap"
    counts = []
    for size in range(8, len(session_bytes)):
        path.write_bytes(session_bytes[:size])
        reader = SessionReader(path)
        found = texts(reader)
        assert found == [str(n) for n in range(len(found))], f"cut at byte {size}"
        assert not reader.complete, f"cut at byte {size}"
        if found:
            assert reader.attachments == {"scene.yaml": b"a: 1"} and reader.metadata == {"run": {"seed": "7"}}
        counts.append(len(found))
    assert counts == sorted(counts)
    assert counts[0] == 0 and counts[-1] == 12
    assert len(set(counts)) == 13, "a cut inside the file must leave the chunks before it"


def test_a_session_with_any_one_byte_changed_is_read_or_refused_in_words(session_bytes, tmp_path):
    """Messages are guarded by a checksum: a changed byte may cost messages, never change one."""
    path = tmp_path / "changed.mcap"
    whole = {str(n) for n in range(12)}
    refused = 0
    for offset in range(len(session_bytes)):
        changed = bytearray(session_bytes)
        changed[offset] ^= 0xFF
        path.write_bytes(changed)
        try:
            assert set(texts(SessionReader(path))) <= whole, f"byte {offset}"
        except SessionError as error:
            assert str(path) in str(error)
            refused += 1
    assert refused > 100


def test_space_that_was_never_filled_ends_the_session(session_bytes, tmp_path):
    path = tmp_path / "zeros.mcap"
    path.write_bytes(session_bytes[:-200] + bytes(5000))
    reader = SessionReader(path)
    assert not reader.complete and reader.lost_bytes > 4900
    assert texts(reader) == [str(n) for n in range(12)]


@pytest.mark.parametrize(
    "options",
    [
        {"use_chunking": False},
        {"compression": CompressionType.NONE},
        {"compression": CompressionType.ZSTD},
        {"compression": CompressionType.ZSTD, "chunk_size": 1},
        {"enable_crcs": False, "repeat_channels": False, "repeat_schemas": False},
    ],
)
def test_bags_of_other_writers_are_read(tmp_path, options):
    write_bag(tmp_path / "theirs.mcap", ["a", "b", "c"], **options)
    reader = SessionReader(tmp_path / "theirs.mcap")
    assert reader.complete
    assert texts(reader) == ["a", "b", "c"]


def test_a_bag_split_into_files_is_read_in_the_order_its_metadata_gives(tmp_path):
    write_bag(tmp_path / "bag_1.mcap", ["third"])
    write_bag(tmp_path / "bag_0.mcap", ["first", "second"])
    write_bag(tmp_path / "bag_10.mcap", ["fourth"])
    reader = SessionReader(tmp_path)
    assert texts(reader) == ["first", "second", "third", "fourth"]
    assert not reader.complete, "without metadata.yaml other tools refuse the folder"

    names = "".join(f"  - bag_{n}.mcap\n" for n in (10, 0, 1))
    (tmp_path / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n  relative_file_paths:\n{names}")
    reader = SessionReader(tmp_path)
    assert texts(reader) == ["fourth", "first", "second", "third"]
    assert reader.complete


def test_a_topic_in_another_encoding_is_refused_by_name_unless_not_asked_for(tmp_path):
    write_bag(tmp_path / "json.mcap", ["{}"], encoding="json")
    reader = SessionReader(tmp_path / "json.mcap")
    with pytest.raises(SessionError, match=r"json\.mcap: /text is encoded as json/ros2msg, not as cdr/ros2msg"):
        list(reader.messages())
    assert list(reader.messages({"/other"})) == []


@pytest.mark.parametrize(
    ("files", "reason"),
    [
        ({}, "not a session: it holds no .mcap file"),
        ({"bag.db3": b""}, "it holds an sqlite3 bag, convert it with 'ros2 bag convert'"),
        ({"s.mcap": b""}, r"s\.mcap: not a session: the file does not begin as MCAP files do"),
        ({"s.mcap": b"#ROSBAG V2.0\n"}, r"s\.mcap: not a session: the file does not begin as MCAP files do"),
        ({"metadata.yaml": b"a: [", "s.mcap": b""}, "metadata.yaml: not the description of a bag"),
        ({"metadata.yaml": b"a: 1", "s.mcap": b""}, "metadata.yaml: not the description of a bag"),
        (
            {"metadata.yaml": b"rosbag2_bagfile_information: {relative_file_paths: [gone.mcap]}"},
            r"gone\.mcap: cannot read the session: No such file or directory",
        ),
    ],
)
def test_what_is_no_session_is_refused_with_the_reason(tmp_path, files, reason):
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    with pytest.raises(SessionError, match=f"{tmp_path}.*{reason}"):
        SessionReader(tmp_path)


def test_a_path_where_nothing_is_is_refused(tmp_path):
    with pytest.raises(SessionError, match="nowhere: no such session: there is neither a folder nor a file"):
        SessionReader(tmp_path / "nowhere")
