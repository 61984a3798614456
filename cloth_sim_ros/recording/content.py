"""What a session holds beside the topics of the graph, each thing with its way to bytes and back.

Three topics below the node's name, in standard message types so that every ROS tool reads the file:
``session/step`` and ``session/event`` (std_msgs/String, JSON), ``session/snapshot``
(std_msgs/UInt8MultiArray, an .npz archive). Numbers survive the JSON bit by bit.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from cloth_core import ClothSolver, Inputs
from cloth_sim_ros.messages.cdr import decode_octets, decode_string, encode_octets, encode_string


@dataclass(frozen=True)
class Step:
    """One step of the solver: all that it takes to do it again, and how to tell that it came out the same.

    Args:
        index: number of the step, the ``step_index`` of the state after it.
        inputs: what acted on the cloth, resolved.
        sweeps: passes used per substep.
        digest: digest of the state after the step.
    """

    topic: ClassVar[str] = "session/step"
    type_name: ClassVar[str] = "std_msgs/msg/String"

    index: int
    inputs: Inputs
    sweeps: tuple[int, ...]
    digest: str

    def encode(self) -> bytes:
        """As a serialised message."""
        sweeps = [int(count) for count in self.sweeps]
        content = {"step": int(self.index), "inputs": self.inputs.as_mapping(), "sweeps": sweeps, "digest": self.digest}
        return encode_string(json.dumps(content, separators=(",", ":")))

    @classmethod
    def decode(cls, cdr: bytes) -> Step:
        """Raises ValueError (ClothError and JSON errors are such) or KeyError when it is none."""
        content = json.loads(decode_string(cdr))
        inputs = Inputs.from_mapping(content["inputs"])
        return cls(content["step"], inputs, tuple(content["sweeps"]), content["digest"])


@dataclass(frozen=True)
class Snapshot:
    """All that the solver needs to go on from a step, bit-equal.

    Args:
        index: the state's ``step_index``.
        arrays: what ``ClothSolver.snapshot`` gave.
    """

    topic: ClassVar[str] = "session/snapshot"
    type_name: ClassVar[str] = "std_msgs/msg/UInt8MultiArray"

    index: int
    arrays: Mapping[str, np.ndarray]

    def encode(self) -> bytes:
        """As a serialised message."""
        return encode_octets(pack({**self.arrays, "step": np.array(self.index)}))

    @classmethod
    def decode(cls, cdr: bytes) -> Snapshot:
        """Raises ValueError or KeyError when it is none."""
        arrays = unpack(decode_octets(cdr))
        return cls(int(arrays.pop("step")), arrays)


@dataclass(frozen=True)
class Event:
    """Something other than a step happened to the simulation.

    Args:
        kind: ``reset``, ``restore``, ``snapshot``, ``pause``, ``resume``; ``parameters``, whose details are those of
            :func:`in_force`; ``pins``, whose detail ``vertices`` are those that are pinned from then on.
        index: steps done when it happened.
        details: whatever else there is to say, in JSON's types.
    """

    topic: ClassVar[str] = "session/event"
    type_name: ClassVar[str] = "std_msgs/msg/String"

    kind: str
    index: int
    details: Mapping[str, Any] = field(default_factory=dict)

    def encode(self) -> bytes:
        """As a serialised message."""
        return encode_string(json.dumps({"step": int(self.index), "kind": self.kind, "details": dict(self.details)}))

    @classmethod
    def decode(cls, cdr: bytes) -> Event:
        """Raises ValueError or KeyError when it is none."""
        content = json.loads(decode_string(cdr))
        return cls(content["kind"], content["step"], content["details"])


def in_force(solver: ClothSolver) -> dict[str, dict[str, Any]]:
    """What ``solver`` computes with, in JSON's types."""
    return {"material": solver.material.as_mapping(), "solver": solver.config.as_mapping()}


def pack(arrays: Mapping[str, np.ndarray]) -> bytes:
    """Named arrays as an .npz archive, uncompressed: floats hardly shrink."""
    archive = io.BytesIO()
    np.savez(archive, **arrays)
    return archive.getvalue()


def unpack(data: bytes) -> dict[str, np.ndarray]:
    """The named arrays of an .npz archive. Raises ValueError when ``data`` is none."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except Exception as error:  # zip, zlib, header and pickle errors have no common base
        raise ValueError(f"not an .npz archive: {error}") from error
