"""cloth_run: the whole thing at once: the node, a scripted operator beside it, and one line that says how it goes."""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cloth_core import SettingError
from cloth_core.scene import Scene
from cloth_sim_ros.command_line import StopFlag, complain, free_domain, seconds, split_ros_args, stop_on_signals
from cloth_sim_ros.launcher.children import Child
from cloth_sim_ros.launcher.status_line import StatusLine, describe, shortened
from cloth_sim_ros.operator import moves_anything
from cloth_sim_ros.share import load_scene, scene_names

if TYPE_CHECKING:
    from cloth_sim_ros.ros.listen import DiagnosticsListener

COMMAND = "cloth_run"
DESCRIPTION = """\
Start the cloth node on a scene and, beside it, an operator that plays the scene's script over topics; show in
one line how it goes (simulated time, rate, step time, stretch, what is held, lag and missed slots, where the
session is logged). Ctrl-C ends all of it and says how to replay the session.

Nodes are found on this machine only, unless ROS_AUTOMATIC_DISCOVERY_RANGE says otherwise. Arguments from
--ros-args on go to the node.
"""
EXAMPLES = """\
examples:
  cloth_run --scene scarf
  cloth_run --scene flag --duration 60
  cloth_run --scene my_scene.yaml --domain free --ros-args -p record:=all
"""
_LOOK_PERIOD_S = 0.2
_SILENT_AFTER_S = 3.0
_REPEAT_PERIOD_S = 10.0
_STAMP = re.compile(r"(?<=\]) \[\d+\.\d+\]")  # of a ROS log line
_SAID_BY_NODE = ("[WARN]", "[ERROR]", "[FATAL]")
_PROGRESS = re.compile(r"compiling kernel \d+ .*")


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit code."""
    ours, for_ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(ours)
    try:
        scene = load_scene(options.scene, lambda _mended: None)  # the node will say it
        from cloth_sim_ros.ros.listen import DiagnosticsListener  # here, so that --help needs no ROS
    except (SettingError, ImportError) as error:
        complain(COMMAND, error)
        return 1
    _choose_graph(options.domain)
    stop = stop_on_signals()
    with DiagnosticsListener() as listener:
        return _Run(options, for_ros, scene, listener, stop).go()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        COMMAND, description=DESCRIPTION, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    shipped = ", ".join(scene_names())
    parser.add_argument("--scene", default="scarf", help=f"a path, or one of {shipped} (default: %(default)s)")
    parser.add_argument("--duration", type=seconds, metavar="S", help="end by itself after running for S seconds")
    parser.add_argument("--domain", metavar="N", help="ROS domain, or 'free' for one that nobody uses here")
    return parser


def _choose_graph(domain: str | None) -> None:
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if domain is not None:
        os.environ["ROS_DOMAIN_ID"] = str(free_domain()) if domain == "free" else domain


class _Run:
    """One run: the children, and what is known of them."""

    def __init__(
        self,
        options: argparse.Namespace,
        for_ros: Sequence[str],
        scene: Scene,
        listener: DiagnosticsListener,
        stop: StopFlag,
    ) -> None:
        self._scene_given = options.scene
        self._duration = options.duration
        self._for_node = list(for_ros)
        self._scripted = moves_anything(scene.script)
        self._listener = listener
        self._stop = stop
        self._status = StatusLine()
        self._silent_until: dict[str, float] = {}  # monotonic s, by text of the node
        self._started: float | None = None  # monotonic s when the first step was reported

    def go(self) -> int:
        """Run until told to stop; returns the exit code."""
        print(
            f"Starting the cloth node on scene {self._scene_given}; the first start compiles kernels (half a minute)."
        )
        node = Child("node", [*_module("node"), *self._node_arguments()], self._node_said)
        children = [node]
        if self._scripted:
            command = [*_module("operator"), "--scene", self._scene_given]
            children.insert(0, Child("operator", command, lambda _line: None))  # stops first
        try:
            self._watch(node, children)
        finally:
            alive = node.exit_code is None
            for child in children:
                child.stop()
            self._status.finish()
        if not alive:
            self._explain(node)
            return 1
        self._tell_where(node)
        return 0 if node.exit_code == 0 else 1

    def _node_arguments(self) -> list[str]:
        own = ["--ros-args", "-p", f"scene:={json.dumps(self._scene_given, ensure_ascii=False)}"]
        return [*own, *(["--", *self._for_node] if self._for_node else [])]

    def _watch(self, node: Child, children: list[Child]) -> None:
        heard = time.monotonic()
        while not self._stop.is_set() and node.exit_code is None and not self._is_over():
            if self._listener.wait(_LOOK_PERIOD_S):
                heard = time.monotonic()
                self._show_values()
            elif self._started is not None and time.monotonic() - heard > _SILENT_AFTER_S:
                heard = time.monotonic()
                self._status.show(f"The node has not reported for {_SILENT_AFTER_S:.0f} s.")
            for child in [c for c in children if c is not node and c.exit_code is not None]:
                children.remove(child)
                self._status.say(f"The {child.name} has ended: {' '.join(child.last_lines[-1:])}")

    def _show_values(self) -> None:
        values = self._listener.values
        if self._started is None and float(values.get("rate_hz", 0.0)) > 0.0:
            self._started = time.monotonic()
            self._status.say(f"Recording to {shortened(values.get('session_folder', 'none'))}")
        if self._started is not None:
            self._status.show(describe(values))

    def _is_over(self) -> bool:
        if self._duration is None or self._started is None:
            return False
        return time.monotonic() - self._started >= self._duration

    def _node_said(self, line: str) -> None:
        """Show the progress of its start; pass warnings and errors on, each text at most every few seconds."""
        if self._started is None and (progress := _PROGRESS.search(line)):
            self._status.show(progress.group().capitalize())
        text = _STAMP.sub("", line)
        now = time.monotonic()
        if text.startswith(_SAID_BY_NODE) and now >= self._silent_until.get(text, 0.0):
            self._silent_until[text] = now + _REPEAT_PERIOD_S
            self._status.say(text)

    def _explain(self, node: Child) -> None:
        complain(COMMAND, f"the node ended by itself, exit code {node.exit_code}. Its last lines:")
        for line in node.last_lines:
            print(f"  {line}", file=sys.stderr)

    def _tell_where(self, node: Child) -> None:
        if node.exit_code != 0:
            complain(COMMAND, f"the node did not end as it should, exit code {node.exit_code}")
        folder = Path(self._listener.values.get("session_folder", "none"))
        if not folder.is_dir():
            print("No session was recorded.")
            return
        size = sum(file.stat().st_size for file in folder.iterdir())
        print(f"Session: {shortened(folder)} ({size / 1e6:.1f} MB)")
        print(f"Replay:  cloth_replay {shortened(folder)}   (--verify simulates it again and compares)")


def _module(name: str) -> list[str]:
    return [sys.executable, "-m", f"cloth_sim_ros.{name}"]


if __name__ == "__main__":
    sys.exit(main())
