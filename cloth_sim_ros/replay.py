"""cloth_replay: a session published again, or simulated again and compared, or made whole."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from cloth_core import ClothError
from cloth_sim_ros.command_line import complain, split_ros_args, stop_on_signals
from cloth_sim_ros.progress import ProgressBar
from cloth_sim_ros.recording.from_bag import simulate
from cloth_sim_ros.recording.recorded import ForeignBag, RecordedSession, open_recording
from cloth_sim_ros.recording.verify import Verification, verify
from cloth_sim_ros.recording.what_if import parse_changes, report, what_if
from cloth_sim_ros.replay_arguments import COMMAND, parser
from cloth_sim_ros.session import SessionError, SessionReader, recover
from cloth_sim_ros.share import load_scene
from cloth_sim_ros.simulation.closures import mappings


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit code."""
    ours, for_ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = parser().parse_args(ours)
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
    remaps = [word for remap in options.remap for word in ("-r", ":=".join(remap))]
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
        remap=dict(options.remap),
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
