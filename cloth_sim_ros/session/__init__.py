"""Sessions: what a run saw and did, as a ROS 2 bag folder that rosbags, mcap and Foxglove read.

``SessionWriter`` records without ever holding up its caller, ``SessionReader`` reads bags, cut-off ones
included, ``recover`` rewrites a cut-off one. Nothing in here needs rclpy.
"""

from cloth_sim_ros.session.channel import Channel, Qos
from cloth_sim_ros.session.errors import SessionError
from cloth_sim_ros.session.reader import Record, SessionReader
from cloth_sim_ros.session.recover import Recovery, recover
from cloth_sim_ros.session.schemas import MessageType, find_message_type
from cloth_sim_ros.session.writer import Health, SessionWriter

__all__ = [
    "Channel",
    "Health",
    "MessageType",
    "Qos",
    "Record",
    "Recovery",
    "SessionError",
    "SessionReader",
    "SessionWriter",
    "find_message_type",
    "recover",
]
