"""Making a complete bag of a session that was cut off."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from cloth_sim_ros.session.bag import Bag
from cloth_sim_ros.session.errors import SessionError
from cloth_sim_ros.session.reader import SessionReader


@dataclass(frozen=True)
class Recovery:
    """What ``recover`` saved: messages per topic.

    ``lost_bytes`` [B] behind the cut could not be read; ``damaged`` says which records before it could not.
    """

    topics: dict[str, int]
    lost_bytes: int
    damaged: tuple[str, ...]

    @property
    def messages(self) -> int:
        """Messages of all topics."""
        return sum(self.topics.values())


def recover(source: Path | str, destination: Path | str) -> Recovery:
    """Rewrite the session at ``source`` into a new bag folder ``destination`` that every tool reads.

    Everything that can be read is kept: attachments, metadata, messages with their times, types and quality
    of service. ``source`` stays as it is. Raises SessionError when it is no session, or ``destination``
    takes none.
    """
    reader = SessionReader(source)
    folder = Path(destination).absolute()
    bag = Bag(folder, attachments=reader.attachments, metadata=reader.metadata)
    topics: Counter[str] = Counter()
    damaged: list[SessionError] = []
    try:
        for channel, record in reader.entries(on_damage=damaged.append):
            bag.add(channel, record.cdr, record.log_time_ns, record.publish_time_ns)
            topics[channel.topic] += 1
        bag.finish()
    except OSError as error:
        bag.abandon()
        raise SessionError.from_os(folder, "cannot write the recovered session", error) from error
    return Recovery(dict(topics), reader.lost_bytes, tuple(str(error) for error in damaged))
