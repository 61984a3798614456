"""Definitions of ROS message types, as MCAP files carry them.

A definition is found where every ROS installation, and the wheels, put it: ``<prefix>/share/<package>/msg``.
Schema text: the .msg file, then for each type it needs a line of ``=``, a line ``MSG: package/Type`` and
that type's file. Source: MCAP specification, well-known schema encodings, ``ros2msg``.
"""

from __future__ import annotations

import functools
import json
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from cloth_sim_ros.session.errors import SessionError

_NAME = re.compile(r"([A-Za-z]\w*)/(?:msg/)?([A-Za-z]\w*)")
_PRIMITIVES = frozenset(
    "bool byte char float32 float64 int8 uint8 int16 uint16 int32 uint32 int64 uint64 string wstring".split()
)
_SEPARATOR = "=" * 80


@dataclass(frozen=True)
class MessageType:
    """A message type: its ``name`` (``sensor_msgs/msg/PointCloud2``), schema text and type hash.

    ``type_hash`` is the RIHS01 hash of REP 2011, empty where it is not known.
    """

    name: str
    definition: str
    type_hash: str


def find_message_type(name: str) -> MessageType:
    """The message type called ``name``, such as ``sensor_msgs/msg/PointCloud2``.

    Looks below each entry of AMENT_PREFIX_PATH, then below ``sys.prefix``. Raises SessionError when the name
    is not of that form, or when the definition, or one that it needs, is in none of these places.
    """
    prefixes = [entry for entry in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if entry]
    return _load(name, (*prefixes, sys.prefix))


@functools.cache
def _load(name: str, prefixes: tuple[str, ...]) -> MessageType:
    package, short = _split(name)
    path = _find(package, short, prefixes)
    definitions = {(package, short): _read(path)}
    pending = [(package, short)]
    while pending:
        current = pending.pop(0)
        for needed in _dependencies(current[0], definitions[current]):
            if needed not in definitions:
                definitions[needed] = _read(_find(*needed, prefixes))
                pending.append(needed)
    first, *others = definitions.items()
    parts = [first[1], *(f"{_SEPARATOR}\nMSG: {key[0]}/{key[1]}\n{text}" for key, text in others)]
    full_name = f"{package}/msg/{short}"
    return MessageType(full_name, "\n".join(parts), _type_hash(path.with_suffix(".json"), full_name))


def _split(name: str) -> tuple[str, str]:
    match = _NAME.fullmatch(name)
    if match is None:
        raise SessionError(
            f"{name!r} is not the name of a message type; one looks like 'std_msgs/msg/String'"
        )
    return match[1], match[2]


def _find(package: str, short: str, prefixes: tuple[str, ...]) -> Path:
    for prefix in prefixes:
        path = Path(prefix, "share", package, "msg", f"{short}.msg")
        if path.is_file():
            return path
    places = ", ".join(prefixes)
    raise SessionError(f"{package}/msg/{short}: no share/{package}/msg/{short}.msg below any of: {places}")


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _dependencies(package: str, definition: str) -> list[tuple[str, str]]:
    """The message types that the fields of ``definition`` use; one without a package is from ``package``."""
    found = []
    for line in definition.splitlines():
        words = line.partition("#")[0].split()
        if not words:
            continue
        base = re.split(r"<=|\[", words[0])[0]
        if base not in _PRIMITIVES:
            found.append(_split(base if "/" in base else f"{package}/{base}"))
    return found


def _type_hash(path: Path, full_name: str) -> str:
    """The hash that a ROS installation keeps beside the definition, from Iron on."""
    try:
        hashes = json.loads(path.read_text(encoding="utf-8"))["type_hashes"]
    except FileNotFoundError:
        return ""
    return next((entry["hash_string"] for entry in hashes if entry["type_name"] == full_name), "")
