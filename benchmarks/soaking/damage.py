"""Messages with damaged fields, and bytes that are no message, on every input topic."""

from __future__ import annotations

import random
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from marks.row import Row
from rclpy.serialization import serialize_message

from cloth_sim_ros import interfaces
from cloth_sim_ros.ros.qos import profile
from soaking.node import NAME, Node, positions, running
from soaking.scenes import hanging

MESSAGES = 10_000
SIDE = 20
NUMBERS = (float("nan"), float("inf"), -float("inf"), 0.0, -0.0, 1e308, -1e300, 1e-320, 1e6, -1.0, 0.5, 3.0)
TEXTS = ("", "world", "nowhere", "\N{SNOWMAN}" * 40, "a" * 5000, "/", "world\n")
WHOLE = (0, 1, -1, 2**31 - 1, -(2**31), 255)


def rows(folder: Path, seconds: float) -> Iterator[Row]:
    """Ten thousand on every input, well formed or not; the node lives on, and says nothing that is not finite."""
    closures = ["hand ~/joy axis 1", "hand ~/joint_states joint finger"]
    each = MESSAGES if seconds >= 60.0 else MESSAGES // 10
    with running(hanging(folder, SIDE), folder, record="inputs", closures=closures) as node:
        node.keep_clouds = True
        sent = sum(_pour(node, interface, each) for interface in interfaces.INPUTS)
        count = len(node.clouds)
        lives = node.wait(lambda: len(node.clouds) > count + 10)
        bad = sum(not np.isfinite(positions(cloud[3], SIDE * SIDE)).all() for cloud in node.clouds if cloud[3])
        tracebacks = sum("Traceback" in line for line in node.lines)
        size = len(node.lines)
    note = f"{sent} messages, {len(node.clouds)} clouds, {size} lines of log"
    yield Row("damaged messages: crashes", "", 0.0, 0.0, float(not lives), note=note)
    yield Row("damaged messages: outputs that are not finite", "", 0.0, 0.0, float(bad))
    yield Row("damaged messages: tracebacks", "", 0.0, 0.0, float(tracebacks))


def _pour(node: Node, interface: interfaces.Interface, count: int) -> int:
    package, kind, name = interface.type_name.split("/")
    message_class = getattr(import_module(f"{package}.{kind}"), name)
    declared = {"grasps": "hand", "obstacles": "ball", "groups": "top", "fluids": "pool"}.get(
        interface.declared, ""
    )
    topic = interface.named(declared).replace("~", NAME)
    publisher = node.peer.node.create_publisher(message_class, topic, profile(interface.qos))
    node.wait(publisher.get_subscription_count)
    chance = random.Random(interface.name)
    for number in range(count):
        message = message_class()
        _damage(message, chance)
        cdr = serialize_message(message)
        if number % 4 == 0:
            cdr = _broken(cdr, chance)
        publisher.publish(cdr)
        if number % 50 == 0:
            node.spin(0.01)
    node.peer.node.destroy_publisher(publisher)
    return count


def _damage(message: Any, chance: random.Random) -> None:
    """Put odd values into some fields of a message."""
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        if hasattr(value, "get_fields_and_field_types"):
            _damage(value, chance)
        elif kind in ("double", "float") and chance.random() < 0.6:
            setattr(message, name, chance.choice(NUMBERS if kind == "double" else NUMBERS[:5]))
        elif kind == "string" and chance.random() < 0.3:
            setattr(message, name, chance.choice(TEXTS))
        elif kind.startswith("sequence<double") or kind.startswith("sequence<float"):
            numbers = NUMBERS if "double" in kind else NUMBERS[:5]
            setattr(message, name, [chance.choice(numbers) for _ in range(chance.randrange(5))])
        elif kind == "sequence<string>":
            setattr(message, name, chance.sample(("finger", "", "wrist"), chance.randrange(4)))
        elif kind == "double[9]":
            setattr(message, name, [chance.choice(NUMBERS) for _ in range(9)])
        elif kind == "boolean":
            setattr(message, name, chance.random() < 0.5)
        elif kind == "int32":
            setattr(message, name, chance.choice(WHOLE))


def _broken(cdr: bytes, chance: random.Random) -> bytes:
    """Bytes that are cut off, flipped, or none at all."""
    kind = chance.randrange(3)
    if kind == 0:
        return cdr[: chance.randrange(4, len(cdr) + 1)]
    flipped = bytearray(cdr)
    for _ in range(1 + kind * 4):
        flipped[chance.randrange(4, len(flipped))] = chance.randrange(256)
    return bytes(flipped)
