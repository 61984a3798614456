"""cloth_replay: a session published again, or simulated again and compared."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

from cloth_sim_ros.command_line import complain, split_ros_args, stop_on_signals
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import Verification, verify
from cloth_sim_ros.session import SessionError

COMMAND = "cloth_replay"
DESCRIPTION = """\
Publish a recorded session again, or simulate it again and compare (--verify).

Published is what was recorded, byte for byte, on the recorded topics with the recorded quality of service
and timing: the inputs, and the outputs if the session has them (record:=outputs or all). Stamps stay as they
were. The session's own bookkeeping (session/step, session/snapshot, session/event) is left out.

--verify needs no ROS. It simulates every step again from the recorded inputs and compares the state bit by
bit: equal is promised on the same machine with the same versions. If not, it names the first step and, where
recorded points or a snapshot show it, the first vertex that differs and by how much.
"""
EXAMPLES = """\
exit code: 0 published or bit-equal, 1 it differs, 2 no such session, or it is damaged

examples:
  cloth_replay ~/.ros/cloth_sessions/2026-01-01_12-00-00_scarf
  cloth_replay my_session --rate 0.25 --loop --namespace /yesterday
  cloth_replay my_session --verify
"""


def main(argv: Sequence[str] | None = None) -> int:
    """The command; returns its exit code."""
    ours, for_ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    options = _parser().parse_args(ours)
    try:
        session = RecordedSession(options.session)
        if not session.complete:
            print(f"{COMMAND}: {session.path} was cut off; going as far as it goes", file=sys.stderr)
        return _verify(session) if options.verify else _publish(session, options, for_ros)
    except SessionError as error:
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
    parser.add_argument("--verify", action="store_true", help="simulate again and compare, instead of publishing")
    parser.add_argument("--rate", type=_rate, default=1.0, metavar="R", help="speed, 1 is as recorded (0.01 .. 100)")
    parser.add_argument("--loop", action="store_true", help="begin again at the end, until Ctrl-C")
    parser.add_argument("--namespace", metavar="NS", help="publish below NS instead of the recorded node's name")
    parser.add_argument("--wait", action="store_true", help="begin when somebody subscribes to one of the topics")
    return parser


def _rate(text: str) -> float:
    rate = float(text)
    if not 0.01 <= rate <= 100.0:
        raise argparse.ArgumentTypeError(f"{text} is not 0.01 .. 100")
    return rate


def _publish(session: RecordedSession, options: argparse.Namespace, for_ros: Sequence[str]) -> int:
    try:
        from cloth_sim_ros.ros.republish import Republisher
    except ImportError as error:
        complain(COMMAND, f"publishing needs rclpy, which cannot be imported: {error}. --verify works without it.")
        return 1
    stop = stop_on_signals()
    with Republisher(session, options.namespace, for_ros) as publisher:
        print(f"{COMMAND}: {session.path}: {len(publisher.topics)} topics; Ctrl-C ends it")
        if session.about.get("record") == "inputs":
            print(f"{COMMAND}: it holds inputs alone; a cloth node that runs is driven by them again")
        if options.wait:
            publisher.wait_for_subscriber(stop)
        publisher.play(stop, rate=options.rate)
        while options.loop and not stop.is_set():
            publisher.play(stop, rate=options.rate)
        print(f"{COMMAND}: {publisher.published} messages published")
    return 0


def _verify(session: RecordedSession) -> int:
    for name, (then, now) in session.changed_versions().items():
        print(f"note: recorded with {name} {then}, this is {now}: bit-equality is not promised")
    dt = session.scene.solver.dt
    progress = _Progress(dt) if sys.stdout.isatty() else None
    result = verify(session, progress)
    if progress:
        progress.clear()
    print(_verdict(result))
    return 0 if result.bit_equal else 1


def _verdict(result: Verification) -> str:
    speed = f"{result.realtime_factor:.2f} times as fast as real time"
    if result.bit_equal:
        return f"bit-equal: {result.steps} steps and {result.snapshots} snapshots, {speed}"
    return f"differs at {result.first_difference}; {result.steps} steps simulated, {speed}"


class _Progress:
    """One line on the terminal that updates in place, ten times a second."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._next = 0.0

    def __call__(self, steps: int, seconds: float) -> None:
        if time.monotonic() >= self._next:
            self._next = time.monotonic() + 0.1
            simulated = steps * self._dt
            print(f"\r{simulated:8.1f} s simulated, {simulated / seconds:5.2f} x real time", end="", flush=True)

    def clear(self) -> None:
        """Leave an empty line for what comes next."""
        print("\r\033[K", end="", flush=True)


if __name__ == "__main__":
    sys.exit(main())
