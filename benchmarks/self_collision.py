"""What keeping a cloth off itself comes to: crossings, stretch, and the time of a frame with it and without.

    python benchmarks/self_collision.py                  all scenes at 100 x 100, many minutes
    python benchmarks/self_collision.py --side 30        smaller cloths
    python benchmarks/self_collision.py --scenes folded  some of the scenes

Crossings are pairs of triangles without common vertex, counted every ``--every`` frames by code that has nothing in
common with the solver's. Times are the processor's (one thread with ``NUMBA_NUM_THREADS=1``), medians over the frames
in which more than 1 % of the vertices touch the cloth; those without self-collision are of the same frames of the
scene played without.
"""

from __future__ import annotations

import argparse
import statistics
import time
from dataclasses import dataclass

from layers.crossings import crossing_triangles
from layers.scenes import DT, SCENES

from cloth_core import StepReport


@dataclass
class Played:
    """What a scene came to: ms of each frame, its reports, and crossings by frame."""

    took: list[float]
    reports: list[StepReport]
    crossings: dict[int, int]
    triangles: int


def play(name: str, side: int, on: bool, every: int) -> Played:
    """Play a scene, with self-collision ``on`` or not; count crossings every so many frames, and at the end."""
    stage = SCENES[name](side, on)
    solver, state = stage.solver, stage.state
    solver.prepare(state)
    triangles = solver.mesh.triangles
    played = Played([], [], {}, len(triangles))
    for frame in range(stage.frames()):
        inputs = stage.inputs((frame + 1) * DT)
        began = time.process_time()
        state = solver.step(state, inputs)
        played.took.append(1e3 * (time.process_time() - began))
        played.reports.append(solver.report)
        if frame % every == 0 or frame == stage.frames() - 1:
            played.crossings[frame] = crossing_triangles(state.position, triangles)
    return played


def row(name: str, side: int, every: int) -> str:
    """One line of the table."""
    without, played = (play(name, side, on, every) for on in (False, True))
    dense = [n for n, report in enumerate(played.reports) if report.self_contacts > 0.01 * side * side]
    ours, theirs = (statistics.median(p.took[n] for n in dense or range(len(p.took))) for p in (played, without))
    worst, end = max(played.crossings.values()), list(played.crossings.values())[-1]
    stretch = max(report.max_stretch for report in played.reports)
    usual = max(report.max_stretch for report in without.reports)
    return (
        f"{name:8} {side:4d} {end:6d} {100.0 * worst / played.triangles:8.3f} {worst:6d} {ours:8.1f} {theirs:8.1f} "
        f"{100.0 * (ours / theirs - 1.0):+7.0f} % {stretch:8.3f} {usual:8.3f} {len(dense):7d}"
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--side", type=int, default=100, help="vertices along an edge")
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--every", type=int, default=5, help="frames from one count of crossings to the next")
    options = parser.parse_args()
    print(
        "            crossing pairs: at the end, worst in % and number; ms a frame with, without, more; stretch of both"
    )
    print("scene    side    end  worst %  worst     with  without     more  stretch  without  frames")
    for name in options.scenes:
        print(row(name, options.side, options.every), flush=True)


if __name__ == "__main__":
    main()
