"""A recording holds what it was given, never holds up its caller, and survives a disk that fails."""

from __future__ import annotations

import errno
import os
import threading

import pytest

from cloth_sim_ros.messages import cdr
from cloth_sim_ros.session import Health, Qos, Record, SessionError, SessionReader, SessionWriter

pytest.importorskip("std_msgs", reason="no ROS message definitions are installed")

STRING = "std_msgs/msg/String"
OCTETS = "std_msgs/msg/UInt8MultiArray"
MEBIBYTE = 1024 * 1024


def texts(path) -> list[str]:
    return [cdr.decode_string(record.cdr) for record in SessionReader(path).messages()]


def octets(size: int, fill: int = 0) -> bytes:
    """A serialised message of exactly ``size`` bytes."""
    return cdr.encode_octets(bytes([fill]) * (size - len(cdr.encode_octets(b""))))


class GatedFile:
    """A real file whose writes wait for ``gate``."""

    def __init__(self, path):
        self.gate = threading.Event()
        self.gate.set()
        self._file = open(path, "xb", buffering=0)

    def write(self, data):
        self.gate.wait()
        return self._file.write(data)

    def __getattr__(self, name):
        return getattr(self._file, name)


class SmallDisk(GatedFile):
    """A real file on a disk with room for ``room`` bytes, which writes part of the data before it fails."""

    room = 2 * MEBIBYTE

    def write(self, data):
        left = self.room - self._file.tell()
        if left == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._file.write(data[:left])


def test_what_goes_in_comes_out_in_order(tmp_path):
    folder = tmp_path / "deep" / "session"
    attachments = {"scene.yaml": b"cloth: {}\n", "empty": b""}
    metadata = {"versions": {"numpy": "2", "cloth": "0"}, "none": {}}
    expected = []
    with SessionWriter(folder, attachments=attachments, metadata=metadata) as writer:
        for n in range(300):
            topic, type_name, data = (
                ("/text", STRING, cdr.encode_string(str(n))) if n % 3 else ("/data", OCTETS, octets(9000, n % 256))
            )
            assert writer.write(topic, type_name, data, 1000 + n, n, expendable=n % 2 == 0)
            expected.append(Record(topic, type_name, data, 1000 + n, n))
    health = writer.health
    assert health == Health(folder, 300, (folder / "session_0.mcap").stat().st_size, 0, None)

    reader = SessionReader(folder)
    assert reader.complete and reader.lost_bytes == 0
    assert reader.attachments == attachments
    assert reader.metadata == metadata
    assert list(reader.messages()) == expected
    assert list(reader.messages({"/data"})) == expected[::3]
    assert list(SessionReader(folder / "session_0.mcap").messages()) == expected


def test_the_publish_time_is_the_log_time_unless_it_is_given(tmp_path):
    with SessionWriter(tmp_path / "s") as writer:
        writer.write("/a", STRING, cdr.encode_string(""), 7)
    assert [record.publish_time_ns for record in SessionReader(tmp_path / "s").messages()] == [7]


def test_many_threads_may_write_and_each_keeps_its_order(tmp_path):
    with SessionWriter(tmp_path / "s") as writer:

        def record(topic):
            for n in range(200):
                writer.write(topic, STRING, cdr.encode_string(str(n)), n)

        threads = [threading.Thread(target=record, args=(f"/thread_{k}",)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    reader = SessionReader(tmp_path / "s")
    for k in range(4):
        assert [record.log_time_ns for record in reader.messages({f"/thread_{k}"})] == list(range(200))


def test_closing_twice_changes_nothing_and_a_late_message_is_counted(tmp_path):
    writer = SessionWriter(tmp_path / "s")
    writer.write("/a", STRING, cdr.encode_string("in time"), 1)
    first = writer.close()
    files = {path: path.read_bytes() for path in (tmp_path / "s").iterdir()}
    assert writer.close() == first
    assert writer.write("/a", STRING, cdr.encode_string("late"), 2) is False
    assert writer.health.dropped == 1
    assert {path: path.read_bytes() for path in (tmp_path / "s").iterdir()} == files
    assert texts(tmp_path / "s") == ["in time"]


def test_a_full_queue_drops_expendable_messages_only(tmp_path):
    files = []

    def open_file(path):
        files.append(GatedFile(path))
        return files[0]

    writer = SessionWriter(tmp_path / "s", queue_bytes=4 * MEBIBYTE, open_file=open_file)
    files[0].gate.clear()
    # A message of this size fills a chunk, so the writing thread stops at the gate with the first of them.
    taken = [writer.write("/out", OCTETS, octets(MEBIBYTE, n), n, expendable=True) for n in range(7)]
    assert taken == [True] * 4 + [False] * 3
    assert [writer.write("/in", OCTETS, octets(MEBIBYTE, n), n) for n in range(3)] == [True] * 3
    assert writer.health.dropped == 3 and writer.health.error is None
    files[0].gate.set()
    assert writer.close().messages == 7

    reader = SessionReader(tmp_path / "s")
    assert [record.log_time_ns for record in reader.messages({"/out"})] == [0, 1, 2, 3]
    assert [record.log_time_ns for record in reader.messages({"/in"})] == [0, 1, 2]


def test_a_full_disk_ends_the_recording_and_keeps_what_fitted(tmp_path):
    writer = SessionWriter(tmp_path / "s", open_file=SmallDisk)
    for n in range(100):
        writer.write("/out", OCTETS, octets(MEBIBYTE // 8, n), n)
    # Compressed, a run of equal bytes would need no room at all.
    for n in range(100, 140):
        writer.write("/out", OCTETS, cdr.encode_octets(os.urandom(MEBIBYTE // 8)), n)
    health = writer.close()

    path = tmp_path / "s" / "s_0.mcap"
    assert health.error == f"{path}: recording stopped: No space left on device"
    assert 100 <= health.messages < 140
    assert health.messages + health.dropped == 140
    assert writer.write("/out", OCTETS, octets(100), 1) is False

    reader = SessionReader(tmp_path / "s")
    assert not reader.complete and reader.lost_bytes == 0
    assert [record.log_time_ns for record in reader.messages()] == list(range(health.messages))
    assert not (tmp_path / "s" / "metadata.yaml").exists()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full here")
def test_a_disk_that_is_full_from_the_start_is_refused(tmp_path):
    def open_file(_path):
        return open("/dev/full", "wb", buffering=0)

    with pytest.raises(SessionError, match=r"s_0\.mcap: cannot begin a session: No space left on device"):
        SessionWriter(tmp_path / "s", open_file=open_file)


def test_a_session_that_is_deleted_under_way_is_reported(tmp_path):
    writer = SessionWriter(tmp_path / "s")
    writer.write("/a", STRING, cdr.encode_string("lost"), 1)
    (tmp_path / "s" / "s_0.mcap").unlink()
    health = writer.close()
    assert health.error == f"{tmp_path / 's' / 's_0.mcap'}: recording stopped: No such file or directory"
    assert (health.messages, health.dropped) == (0, 1)


def test_metadata_that_cannot_be_written_is_reported_and_the_messages_stay(tmp_path):
    writer = SessionWriter(tmp_path / "s")
    writer.write("/a", STRING, cdr.encode_string("kept"), 1)
    (tmp_path / "s" / "metadata.yaml").mkdir()
    health = writer.close()
    assert "recording stopped: Is a directory" in health.error
    assert (health.messages, health.dropped) == (1, 0)
    assert texts(tmp_path / "s" / "s_0.mcap") == ["kept"]


def test_a_folder_that_holds_something_is_refused_and_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(SessionError, match=f"{tmp_path}: cannot write a session here: the folder is not empty"):
        SessionWriter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_an_empty_folder_is_taken(tmp_path):
    with SessionWriter(tmp_path):
        pass
    assert SessionReader(tmp_path).complete
    assert list(SessionReader(tmp_path).messages()) == []


@pytest.mark.parametrize(
    ("place", "reason"), [("file", "File exists"), ("file/s", "Not a directory"), ("/proc/s", "No such file")]
)
def test_a_path_that_cannot_be_written_is_refused_with_the_reason(tmp_path, place, reason):
    (tmp_path / "file").touch()
    folder = tmp_path / place
    with pytest.raises(SessionError, match=f"{folder}: cannot write a session here: {reason}"):
        SessionWriter(folder)


def test_an_unknown_type_costs_its_topic_and_not_the_session(tmp_path):
    writer = SessionWriter(tmp_path / "s")
    for n in range(3):
        writer.write("/odd", "no_msgs/msg/Odd", b"", n)
        writer.write("/text", STRING, cdr.encode_string(str(n)), n)
    health = writer.close()
    assert health.error.startswith("/odd is not recorded: no_msgs/msg/Odd: no share/no_msgs/msg/Odd.msg")
    assert (health.messages, health.dropped) == (3, 3)
    assert SessionReader(tmp_path / "s").complete
    assert texts(tmp_path / "s") == ["0", "1", "2"]


def test_what_cannot_be_recorded_is_refused_on_the_spot(tmp_path):
    with SessionWriter(tmp_path / "s") as writer:
        with pytest.raises(TypeError, match="/a: a message is recorded as bytes, not bytearray"):
            writer.write("/a", STRING, bytearray(8), 0)
        with pytest.raises(ValueError, match="/a: log_time_ns is -1, allowed is 0 to"):
            writer.write("/a", STRING, b"", -1)
        with pytest.raises(ValueError, match="/a: publish_time_ns is 18446744073709551616, allowed is 0 to"):
            writer.write("/a", STRING, b"", 0, 2**64)
    assert writer.health.error is None


def test_a_flush_period_that_is_not_positive_is_refused(tmp_path):
    with pytest.raises(ValueError, match="flush_period_s is 0 s, allowed is more than 0 s"):
        SessionWriter(tmp_path / "s", flush_period_s=0)
    assert not (tmp_path / "s").exists()


def test_a_qos_is_kept_in_the_words_of_rosbag2(tmp_path):
    with SessionWriter(tmp_path / "s") as writer:
        latched = Qos(durability="transient_local", depth=1)
        writer.write("/latched", STRING, cdr.encode_string(""), 0, qos=latched)
    (entry,) = SessionReader(tmp_path / "s").entries()
    assert entry.channel.qos_profiles == latched.to_yaml()
    assert entry.channel.to_mapping()["offered_qos_profiles"][0]["durability"] == "transient_local"
