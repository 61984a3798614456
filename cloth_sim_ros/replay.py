"""cloth_replay: a session published again, or simulated again and compared, or made whole."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from cloth_core import ClothError, SettingError
from cloth_sim_ros.command_line import complain, split_ros_args, stop_on_signals
from cloth_sim_ros.progress import ProgressBar
from cloth_sim_ros.recording.from_bag import simulate
from cloth_sim_ros.recording.recorded import ForeignBag, RecordedSession, open_recording
from cloth_sim_ros.recording.verify import Verification, verify
from cloth_sim_ros.recording.what_if import parse_changes, report, what_if
from cloth_sim_ros.session import SessionError, SessionReader, recover
from cloth_sim_ros.share import load_scene
from cloth_sim_ros.simulation.closures import mappings

COMMAND = "cloth_replay"
DESCRIPTION = """\
Publish a recorded session again, or simulate it again and compare (--verify, --what-if).

Published is what was recorded, byte for byte, on the recorded topics with the recorded quality of service
and timing: the inputs, and the outputs if the session has them (record:=outputs or all). Stamps stay as they
were. The session's own bookkeeping (session/step, session/snapshot, session/event) is left out. Bags that
something else recorded are published as well: --remap leads their topics to those that a cloth node reads.

--verify needs no ROS. It simulates every step again from the recorded inputs and compares the state bit by
bit: equal is promised on the same machine with the same versions. If not, it names the first step and, where
recorded points or a snapshot show it, the first vertex that differs and by how much.

--simulate takes the inputs of any bag to a scene, and writes a session that can be shown and verified in turn.

--what-if simulates the recorded inputs twice, as it was and with other parameters, and says how far the two
come apart.
"""
EXAMPLES = """\
exit code: 0 published, bit-equal, compared or recovered; 1 it differs; 2 no such session, or it is damaged

examples:
  cloth_replay ~/.ros/cloth_sessions/2026-01-01_12-00-00_scarf
  cloth_replay my_session --rate 0.25 --loop --namespace /yesterday --from 12 --to 20
  cloth_replay teleoperation_bag --remap /q2r_right_hand_pose:=/cloth_sim/grasp/hand/pose
  cloth_replay teleoperation_bag --remap /q2r_right_hand_pose:=/cloth_sim/grasp/hand/pose --simulate scarf
  cloth_replay my_session --verify
  cloth_replay my_session --what-if material.friction=0.8 --what-if solver.integrator=meyer2000
  cloth_replay my_session --recover
"""


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit code."""
    ours, for_ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(ours)
    try:
        if options.recover is not None:
            return _recover(options)
        if options.simulate is not None:
            return _simulate(options)
        simulates = options.verify or options.what_if
        session = RecordedSession(options.session) if simulates else open_recording(options.session)
        if not session.complete:
            print(f"{COMMAND}: {session.path} was cut off; going as far as it goes", file=sys.stderr)
        window = _window(session, options)
        if isinstance(session, RecordedSession) and simulates:
            session.window_ns = window
            return _verify(session) if options.verify else _what_if(session, options)
        return _publish(session, options, window, for_ros)
    except (SessionError, ClothError) as error:
        complain(COMMAND, error)
        return 2
    except KeyboardInterrupt:
        complain(COMMAND, "interrupted")
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        COMMAND, description=DESCRIPTION, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("session", help="folder of the session, or its .mcap file")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--verify", action="store_true", help="simulate again and compare, instead of publishing")
    instead.add_argument(
        "--what-if", action="append", metavar="KEY=VALUE", help="simulate with another parameter beside what was"
    )
    instead.add_argument(
        "--recover", nargs="?", const="", metavar="FOLDER", help="make a complete bag of one that was cut off"
    )
    instead.add_argument("--simulate", metavar="SCENE", help="simulate a scene with the inputs of this bag")
    parser.add_argument("--output", metavar="FOLDER", help="of --simulate (default: the bag's name with the scene's)")
    parser.add_argument("--transform", action="append", default=[], metavar="T", help="as in static_transforms")
    parser.add_argument("--closure", action="append", default=[], metavar="C", help="as in closures")
    parser.add_argument("--from", type=_seconds, dest="begin", metavar="S", help="begin S seconds into the recording")
    parser.add_argument("--to", type=_seconds, dest="end", metavar="S", help="end S seconds into the recording")
    parser.add_argument("--rate", type=_rate, default=1.0, metavar="R", help="speed, 1 is as recorded (0.01 .. 100)")
    parser.add_argument("--loop", action="store_true", help="begin again at the end, until Ctrl-C")
    parser.add_argument("--namespace", metavar="NS", help="publish below NS instead of the recorded node's name")
    parser.add_argument("--remap", action="append", default=[], metavar="A:=B", help="publish the topic A as B")
    parser.add_argument("--wait", action="store_true", help="begin when somebody subscribes to one of the topics")
    return parser


def _rate(text: str) -> float:
    rate = float(text)
    if not 0.01 <= rate <= 100.0:
        raise argparse.ArgumentTypeError(f"{text} is not 0.01 .. 100")
    return rate


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.0 <= seconds <= 1e9:
        raise argparse.ArgumentTypeError(f"{text} is not 0 .. 1e9 s")
    return seconds


def _window(session: RecordedSession | ForeignBag, options: argparse.Namespace) -> tuple[int, int] | None:
    """Log times in ns that were asked for; None for all of it."""
    if options.begin is None and options.end is None:
        return None
    first, last = session.reader.times_ns
    begin = first + round(1e9 * (options.begin or 0.0))
    end = last if options.end is None else first + round(1e9 * options.end)
    if begin > last or end < begin:
        length = (last - first) * 1e-9
        raise SessionError(f"{session.path}: nothing is between --from and --to: it is {length:.2f} s long")
    return begin, end


def _length(session: RecordedSession | ForeignBag, window: tuple[int, int] | None) -> float:
    """s that are gone through."""
    first, last = window or session.reader.times_ns
    return (last - first) * 1e-9


def _publish(
    session: RecordedSession | ForeignBag,
    options: argparse.Namespace,
    window: tuple[int, int] | None,
    for_ros: Sequence[str],
) -> int:
    try:
        from cloth_sim_ros.ros.republish import Republisher
    except ImportError as error:
        complain(COMMAND, f"publishing needs rclpy, which cannot be imported: {error}. --verify works without it.")
        return 1
    stop = stop_on_signals()
    remaps = [word for remap in options.remap for word in ("-r", remap)]
    ros_arguments = [*(["--ros-args", *remaps, "--"] if remaps else []), *for_ros]
    with Republisher(session, options.namespace, ros_arguments) as publisher:
        print(f"{COMMAND}: {session.path}: {len(publisher.topics)} topics; Ctrl-C ends it")
        if session.about.get("record") == "inputs":
            print(f"{COMMAND}: it holds inputs alone; a cloth node that runs is driven by them again")
        if options.wait:
            publisher.wait_for_subscriber(stop)
        bar = ProgressBar(_length(session, window), "s")
        again = True
        while again and not stop.is_set():
            publisher.play(stop, rate=options.rate, window_ns=window, on_progress=bar.show)
            again = options.loop
        bar.clear()
        print(f"{COMMAND}: {publisher.published} messages published")
    return 0


def _verify(session: RecordedSession) -> int:
    for name, (then, now) in session.changed_versions().items():
        print(f"note: recorded with {name} {then}, this is {now}: bit-equality is not promised")
    dt = session.scene.solver.dt
    bar = ProgressBar(_length(session, session.window_ns), "s")
    result = verify(session, lambda steps, s: bar.show(steps * dt, f", {steps * dt / s:.2f} x real time"))
    bar.clear()
    print(_verdict(result))
    return 0 if result.bit_equal else 1


def _verdict(result: Verification) -> str:
    speed = f"{result.realtime_factor:.2f} times as fast as real time"
    if result.bit_equal:
        return f"bit-equal: {result.steps} steps and {result.snapshots} snapshots, {speed}"
    return f"differs at {result.first_difference}; {result.steps} steps simulated, {speed}"


def _what_if(session: RecordedSession, options: argparse.Namespace) -> int:
    changes = parse_changes(options.what_if)
    dt = session.scene.solver.dt
    bar = ProgressBar(_length(session, session.window_ns), "s")
    moments = what_if(session, changes, lambda steps, _time: bar.show(steps * dt))
    bar.clear()
    print(f"{session.path} with {', '.join(f'{key} = {value}' for key, value in changes.items())}")
    print(report(moments))
    return 0


def _simulate(options: argparse.Namespace) -> int:
    try:
        from rclpy.serialization import deserialize_message

        from cloth_sim_ros.ros.messages import interface_class
    except ImportError as error:
        complain(COMMAND, f"reading the messages of a bag needs rclpy, which cannot be imported: {error}")
        return 1
    reader = SessionReader(options.session)
    scene = load_scene(options.simulate, lambda mended: print(f"{COMMAND}: {mended}", file=sys.stderr))
    path = options.session.rstrip("/").removesuffix(".mcap")
    folder = Path(options.output or f"{path}_{scene.name}")
    first, last = reader.times_ns
    bar = ProgressBar((last - first) * 1e-9, "s")
    outcome = simulate(
        reader,
        scene,
        folder,
        lambda cdr, type_name: deserialize_message(cdr, interface_class(type_name)),
        remap=dict(_pair(text) for text in options.remap),
        closures=mappings(options.closure, scene.inputs.grasps),
        transforms=options.transform,
        on_progress=bar.show,
    )
    bar.clear()
    for topic, count in outcome.used.items():
        print(f"{COMMAND}: {topic}: {count} messages used")
    for cause, count in outcome.refused.items():
        print(f"{COMMAND}: {cause}: {count} messages not used", file=sys.stderr)
    if outcome.unused:
        print(f"{COMMAND}: no input of the scene: {', '.join(outcome.unused)}")
    print(f"{COMMAND}: {folder}: {outcome.steps} steps")
    return 0


def _pair(text: str) -> tuple[str, str]:
    before, mark, after = text.partition(":=")
    if not (before and mark and after):
        raise SettingError("--remap", f"'{text}' is not of the form A:=B")
    return before, after


def _recover(options: argparse.Namespace) -> int:
    path = options.session.rstrip("/")
    destination = options.recover or f"{path.removesuffix('.mcap')}_recovered"
    result = recover(path, destination)
    for problem in result.damaged:
        print(f"{COMMAND}: {problem}", file=sys.stderr)
    lost = f"; {result.lost_bytes} bytes behind the cut are lost" if result.lost_bytes else ""
    print(f"{COMMAND}: {destination}: {result.messages} messages of {len(result.topics)} topics{lost}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
