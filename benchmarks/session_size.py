"""How large the session of a scripted run is, and how fast it is simulated again, bit for bit.

python benchmarks/session_size.py --seconds 60 --scene scarf
"""

from __future__ import annotations

import argparse
import collections
import subprocess
import sys
import tempfile
from pathlib import Path

from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify


def main() -> int:
    """Record, verify, print; exit code 1 unless it is bit-equal."""
    options = _options()
    with tempfile.TemporaryDirectory() as folder:
        parameters = ["-p", f"session_folder:={folder}", "-p", f"record:={options.record}"]
        duration = ["--duration", str(options.seconds), "--domain", "free"]
        command = [sys.executable, "-m", "cloth_sim_ros.run", "--scene", options.scene, *duration]
        subprocess.run([*command, "--ros-args", *parameters], check=True, stdout=subprocess.DEVNULL)
        (path,) = Path(folder).iterdir()
        session = RecordedSession(path)
        _print_size(session, options.record)
        result = verify(session)
    print(f"  verify: {'bit-equal' if result.bit_equal else f'differs at {result.first_difference}'}", end="")
    print(f", {result.steps} steps and {result.snapshots} snapshots,", end=" ")
    print(f"{result.realtime_factor:.2f} times as fast as real time")
    return 0 if result.bit_equal else 1


def _print_size(session: RecordedSession, record: str) -> None:
    about = session.about
    size = sum(file.stat().st_size for file in session.path.iterdir())
    messages: collections.Counter[str] = collections.Counter()
    content: collections.Counter[str] = collections.Counter()
    for message in session.reader.messages():
        messages[message.topic] += 1
        content[message.topic] += len(message.cdr)
    seconds = messages[f"{session.namespace}/session/step"] * float(about["dt"])
    print(f"scene {about['scene']}: {about['vertices']} vertices, {seconds:.1f} s of simulated time, record {record}")
    print(f"  file: {size / 1e6:.2f} MB, {size / 1e6 / seconds * 60:.2f} MB a minute (compressed)")
    for topic, count in content.most_common():
        if count >= 0.005 * content.total():
            print(f"  {topic:<36} {messages[topic]:>6} messages {count / 1e6:>8.2f} MB before compression")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the run (default: %(default)s)")
    parser.add_argument("--scene", default="scarf", help="name or path (default: %(default)s)")
    parser.add_argument("--record", default="inputs", choices=("inputs", "outputs", "all"))
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
