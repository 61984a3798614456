"""What cloth_replay is told on the command line."""

from __future__ import annotations

import argparse

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


def parser() -> argparse.ArgumentParser:
    """Reads the arguments; what ROS gets is split off before."""
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
    parser.add_argument(
        "--remap", type=_pair, action="append", default=[], metavar="A:=B", help="publish the topic A as B"
    )
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


def _pair(text: str) -> tuple[str, str]:
    before, mark, after = text.partition(":=")
    if not (before and mark and after):
        raise argparse.ArgumentTypeError(f"'{text}' is not of the form A:=B")
    return before, after
