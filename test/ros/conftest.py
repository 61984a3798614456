"""Real nodes in processes of their own, over real DDS on a domain that no other test uses."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed: pip install -e '.[ros]'")

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from small_scene import SMALL_SCENE

PATIENCE = 60.0
"""s after which something that has not happened never will; a discovery may take 3 s, a busy machine longer."""
COMPILED = 300.0
"""s for a start that compiles all kernels first: once after each change of one of them."""


def _claim_domain() -> tuple[int, socket.socket]:
    """A ROS domain that no other test run on this machine has, and the socket that says so."""
    for domain in range(1, 102):
        claim = socket.socket()
        try:
            claim.bind(("127.0.0.1", 22119 + domain))
            return domain, claim
        except OSError:
            claim.close()
    raise RuntimeError("no ROS domain is free")


@pytest.fixture(scope="session", autouse=True)
def ros_environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Tests of this process and its children meet each other and nobody else."""
    domain, claim = _claim_domain()
    with pytest.MonkeyPatch.context() as patch, claim:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        patch.setenv("ROS_LOG_DIR", str(tmp_path_factory.mktemp("ros_log")))
        patch.setenv("CLOTH_SESSIONS", str(tmp_path_factory.mktemp("sessions")))
        patch.setenv("RCUTILS_COLORIZED_OUTPUT", "0")
        yield


class NodeProcess:
    """``cloth_node`` in a process of its own; everything that it prints is kept."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "cloth_sim_ros.node", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            start_new_session=True,
        )
        self._lines: list[str] = []
        self._changed = threading.Condition()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def output(self) -> str:
        """All that it has printed so far."""
        with self._changed:
            return "".join(self._lines)

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    def wait_for(self, text: str, patience: float = PATIENCE) -> str:
        """Block until a line with ``text`` was printed; returns the line."""
        with self._changed:
            self._changed.wait_for(lambda: self._find(text) or not self._reader.is_alive(), patience)
            found = self._find(text)
        assert found, f"no line with {text!r} in:\n{self.output}"
        return found

    def send(self, number: signal.Signals) -> None:
        """Send a signal to the process and all that it started."""
        os.killpg(self._process.pid, number)

    def wait(self, patience: float = PATIENCE) -> int:
        """Block until it has ended; returns the exit code."""
        code = self._process.wait(patience)
        self._reader.join(patience)
        return code

    def stop(self) -> int:
        """End it as Ctrl-C would, or with SIGKILL if that does not help; returns the exit code."""
        if self.alive:
            self.send(signal.SIGINT)
        try:
            return self.wait()
        except subprocess.TimeoutExpired:
            self.send(signal.SIGKILL)
            return self.wait()
        finally:
            self._process.stdout.close()

    def _find(self, text: str) -> str:
        return next((line for line in self._lines if text in line), "")

    def _read(self) -> None:
        for line in self._process.stdout:
            with self._changed:
                self._lines.append(line)
                self._changed.notify_all()
        with self._changed:
            self._changed.notify_all()


class Peer:
    """A node in the test's own process that talks to the node under test."""

    def __init__(self, namespace: str = "/cloth_sim") -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = Node("peer", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.namespace = namespace
        # Kept, for meeting another process takes up to 3 s each time.
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self._listeners: dict[str, list[Callable[[Any], None]]] = {}

    def topic(self, name: str) -> str:
        """``name`` below the node under test, unless it is absolute."""
        return name if name.startswith("/") else f"{self.namespace}/{name}"

    def listen(self, kind: Any, name: str, qos: QoSProfile | int = 50) -> list[Any]:
        """The messages of a topic from now on, in a list that grows while the peer waits for something."""
        messages: list[Any] = []
        if isinstance(qos, QoSProfile):  # latched, for example: what was sent before counts too
            self.node.create_subscription(kind, self.topic(name), messages.append, qos)
            return messages
        if name not in self._listeners:
            listeners = self._listeners[name] = []
            self.node.create_subscription(
                kind, self.topic(name), lambda message: [listener(message) for listener in listeners], qos
            )
        self._listeners[name].append(messages.append)
        return messages

    def speak(self, kind: Any, name: str, qos: QoSProfile | int = 10) -> Callable[[Any], None]:
        """A function that publishes to a topic, once somebody listens there."""
        if name not in self._publishers:
            self._publishers[name] = self.node.create_publisher(kind, self.topic(name), qos)
        publisher = self._publishers[name]
        self.wait_until(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {name}")
        return publisher.publish

    def forget(self) -> None:
        """Feed no list any longer."""
        for listeners in self._listeners.values():
            listeners.clear()

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """The answer of a service."""
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, self.topic(name))
        client = self._clients[name]
        self.wait_until(client.service_is_ready, f"the service {name}")
        future = client.call_async(request)
        self.wait_until(future.done, f"an answer of {name}")
        return future.result()

    def wait_until(
        self, condition: Callable[[], Any], what: str, *, meanwhile: Callable[[], None] | None = None
    ) -> Any:
        """Spin until ``condition`` holds, calling ``meanwhile`` at about 100 Hz; returns what it holds."""
        deadline = time.monotonic() + PATIENCE
        while not (found := condition()):
            assert time.monotonic() < deadline, f"waited in vain for {what}"
            if meanwhile is not None:
                meanwhile()
            self.executor.spin_once(timeout_sec=0.01)
        return found

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


@pytest.fixture(scope="module")
def small_scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene that computes in no time: 81 vertices, a ball, a floor, a hand."""
    file = tmp_path_factory.mktemp("scene") / "small.yaml"
    file.write_text(SMALL_SCENE + "pins: [bottom_left]\n")
    return file


@pytest.fixture(scope="module")
def start_node(ros_environment: None, small_scene: Path) -> Iterator[Callable[..., NodeProcess]]:
    """Starts nodes: ``start_node(*ros_arguments, scene=..., ready=True)``; the module's end ends them."""
    with contextlib.ExitStack() as running:

        def start(*ros_arguments: str, scene: Path | str = small_scene, ready: bool = True) -> NodeProcess:
            process = NodeProcess(["--ros-args", "-p", f"scene:={scene}", *ros_arguments])
            running.callback(process.stop)
            if ready:
                process.wait_for("recording to", COMPILED)
            return process

        yield start


@pytest.fixture(scope="module")
def module_peer(ros_environment: None) -> Iterator[Peer]:
    peer = Peer()
    yield peer
    peer.close()


@pytest.fixture
def peer(module_peer: Peer) -> Iterator[Peer]:
    """A node of the module's own; what it listens to ends with the test."""
    yield module_peer
    module_peer.forget()
