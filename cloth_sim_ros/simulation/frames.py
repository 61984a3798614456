"""Frames of reference: from whatever frame a message is in to the cloth's."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cloth_core import InputError, Pose, SettingError
from cloth_sim_ros.messages.conversions import RefusedError

Lookup = Callable[[str, str], "Pose | None"]
"""(target, source) -> pose of the source frame in the target frame, or None if it is not known (yet)."""

FORM = "'parent child x y z qx qy qz qw' (m, quaternion)"


class FrameTree:
    """Poses of frames in the cloth's frame, from tf where there is one and from static transforms otherwise.

    Args:
        cloth_frame: the frame that the cloth is simulated and published in.
        transforms: texts ``parent child x y z qx qy qz qw``, each the pose of child in parent (m).
        lookup: asks tf; its answer goes before the static transforms.

    Raises:
        SettingError: a transform is malformed, gives a frame a second parent, or closes a ring.
    """

    def __init__(self, cloth_frame: str, transforms: Sequence[str] = (), lookup: Lookup | None = None) -> None:
        if not cloth_frame:
            raise SettingError("frame_id", "'' is empty: the frame that the cloth is published in needs a name")
        self.cloth_frame = cloth_frame
        self._lookup = lookup
        self._parent: dict[str, tuple[str, Pose]] = {}
        for text in transforms:
            if text.strip():
                self._add(text)
        self._cloth_root, self._cloth_in_root = self._climb(cloth_frame)

    @property
    def known(self) -> list[str]:
        """The frames that the static transforms connect with the cloth's, it included."""
        frames = {self.cloth_frame, *self._parent, *(parent for parent, _ in self._parent.values())}
        return sorted(frame for frame in frames if self._climb(frame)[0] == self._cloth_root)

    def to_cloth(self, frame_id: str) -> Pose:
        """The pose of ``frame_id`` in the cloth's frame; an empty name means the cloth's frame itself.

        Raises:
            RefusedError: nothing says where the frame is; the message names those that are known.
        """
        frame = frame_id.lstrip("/")  # ROS 1 wrote a leading slash
        if frame in ("", self.cloth_frame):
            return Pose()
        found = self._lookup(self.cloth_frame, frame) if self._lookup else None
        if found is not None:
            return found
        root, in_root = self._climb(frame)
        if root != self._cloth_root:
            tf = "; tf does not know it either" if self._lookup else ""
            raise RefusedError(
                "header.frame_id",
                f"= '{frame_id}' is not connected with the cloth's frame '{self.cloth_frame}': known are "
                f"{', '.join(self.known)} (parameter static_transforms){tf}",
            )
        return inverse(self._cloth_in_root).compose(in_root)

    def _add(self, text: str) -> None:
        words = text.split()
        if len(words) != 9:
            raise SettingError("static_transforms", f"'{text}' has {len(words)} words, not the 9 of {FORM}")
        parent, child = (word.lstrip("/") for word in words[:2])
        try:
            numbers = [float(word) for word in words[2:]]
            pose = Pose(tuple(numbers[:3]), tuple(numbers[3:]))  # type: ignore[arg-type]
        except InputError as error:
            raise SettingError("static_transforms", f"'{text}': {error}") from None
        except ValueError:
            raise SettingError("static_transforms", f"'{text}' is not of the form {FORM}") from None
        if child in self._parent:
            raise SettingError(
                "static_transforms", f"'{text}': {child} already has the parent {self._parent[child][0]}"
            )
        if self._climb(parent)[0] == child:
            raise SettingError("static_transforms", f"'{text}' closes a ring of frames")
        self._parent[child] = (parent, pose)

    def _climb(self, frame: str) -> tuple[str, Pose]:
        """The topmost frame above ``frame``, and the pose of ``frame`` in it."""
        pose = Pose()
        while frame in self._parent:
            frame, step = self._parent[frame]
            pose = step.compose(pose)
        return frame, pose


def inverse(pose: Pose) -> Pose:
    """The pose of the outer frame in the inner one."""
    x, y, z, w = pose.orientation
    return Pose(tuple(pose.inverse_apply(np.zeros((1, 3)))[0]), (-x, -y, -z, w))
