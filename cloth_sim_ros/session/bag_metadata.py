"""metadata.yaml of a ROS 2 bag folder, version 9 (Jazzy)."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path

from cloth_sim_ros.session.channel import Channel
from cloth_sim_ros.session.yaml_text import dump

FILE_NAME = "metadata.yaml"


@dataclass
class Tally:
    """Messages counted per channel, and the log times [ns] they span."""

    counts: dict[Channel, int] = field(default_factory=dict)
    start_ns: int | None = None
    end_ns: int = 0

    def add(self, channel: Channel, log_time_ns: int) -> None:
        """Count one message."""
        self.counts[channel] = self.counts.get(channel, 0) + 1
        self.start_ns = log_time_ns if self.start_ns is None else min(self.start_ns, log_time_ns)
        self.end_ns = max(self.end_ns, log_time_ns)

    @property
    def total(self) -> int:
        """Messages of all channels."""
        return sum(self.counts.values())


def write_bag_metadata(folder: Path, file_name: str, tally: Tally) -> None:
    """Write ``folder``/metadata.yaml for the one file ``file_name`` in it. Raises OSError."""
    start_ns = tally.start_ns or 0
    extent = {
        "starting_time": {"nanoseconds_since_epoch": start_ns},
        "duration": {"nanoseconds": tally.end_ns - start_ns},
        "message_count": tally.total,
    }
    information = {
        "version": 9,
        "storage_identifier": "mcap",
        **extent,
        "topics_with_message_count": [
            {"topic_metadata": channel.to_mapping(), "message_count": count}
            for channel, count in tally.counts.items()
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [{"path": file_name, **extent}],
        "custom_data": None,
        "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
    }
    # A reader that finds the file must find all of it, also when the disk fills up just now.
    unfinished = folder / f".{FILE_NAME}"
    unfinished.write_text(dump({"rosbag2_bagfile_information": information}), encoding="utf-8")
    unfinished.replace(folder / FILE_NAME)
