"""cloth_operator: plays a scene's script over the node's topics, as a person or a robot would."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence

from cloth_core import Inputs, SettingError
from cloth_core.scene import Scene
from cloth_core.script import Script
from cloth_sim_ros.command_line import StopFlag, complain, seconds, split_ros_args, stop_on_signals
from cloth_sim_ros.share import load_scene

COMMAND = "cloth_operator"
DESCRIPTION = """\
Play the script of a scene over topics, 100 times a second: poses and closures of the grasps, poses of the
obstacles, wind. It is a process of its own that knows the node by its topics alone, so whatever it does, a
headset, a glove or a robot can do too. Begins when the node subscribes; ends with Ctrl-C, or --duration.
"""
RATE_HZ = 100.0
_LOOK_PERIOD_S = 0.05


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit code."""
    ours, for_ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(ours)
    try:
        scene = load_scene(options.scene, lambda _mended: None)  # the node says it
        if not moves_anything(scene.script):
            raise SettingError("script", f"the scene {options.scene} has none: there is nothing to play")
    except SettingError as error:
        complain(COMMAND, error)
        return 1
    stop = stop_on_signals()
    _play(scene, options, for_ros, stop)
    return 0


def moves_anything(script: Script) -> bool:
    """Whether there is anything to play."""
    return bool(script.grasps or script.obstacles or script.wind)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        COMMAND, description=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scene", required=True, help="name of a scene that comes with the package, or a path")
    parser.add_argument("--namespace", default="/cloth_sim", help="full name of the node (default: %(default)s)")
    parser.add_argument("--frame", default="world", help="frame_id of what is published (default: %(default)s)")
    parser.add_argument("--duration", type=seconds, default=float("inf"), metavar="S", help="end after S seconds")
    return parser


def _play(scene: Scene, options: argparse.Namespace, for_ros: Sequence[str], stop: StopFlag) -> None:
    from cloth_sim_ros.ros.operate import Hands  # here, so that --help and a wrong scene need no ROS

    with Hands(scene.script, options.namespace, options.frame, for_ros) as hands:
        while not hands.are_watched() and not stop.wait(_LOOK_PERIOD_S):
            pass
        play(lambda seconds: scene.script.inputs_at(seconds, scene.inputs), hands.show, stop, options.duration)


def play(inputs_at: Callable[[float], Inputs], show: Callable[[Inputs], None], stop: StopFlag, duration: float) -> None:
    """Show the inputs of every hundredth of a second at its time, for ``duration`` s or until ``stop`` is set.

    A late one is not made up for: the script goes by the time that has passed.
    """
    start = time.monotonic()
    number = 0
    while not stop.is_set():
        seconds = time.monotonic() - start
        if seconds >= duration:
            return
        show(inputs_at(seconds))
        number = max(number + 1, int(seconds * RATE_HZ))
        stop.wait(max(0.0, start + number / RATE_HZ - time.monotonic()))


if __name__ == "__main__":
    sys.exit(main())
