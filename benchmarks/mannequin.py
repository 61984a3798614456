"""What a whole frame costs: the scene ``mannequin``, with all that it has and without parts of it, and who takes it.

    python benchmarks/mannequin.py
    python benchmarks/mannequin.py --seconds 2 --threads 1

2,484 vertices on a human body that turns, self-collision, wind with its shadow. Wanted on two cores: 12 ms a frame,
better 6. The variants take turns, so that what else the machine does hits all alike; each plays its own cloth.
"""

from __future__ import annotations

import argparse
import cProfile
import os
import pstats
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numba
import numpy as np

from cloth_core import ClothSolver, State
from cloth_core.inputs import Wind
from cloth_core.scene import Scene
from cloth_sim_ros.share import find_scene

BAR, AIM = 12.0, 6.0  # ms
SKIPPED = 0.5  # s of free fall
LISTED = 12
WHOLE = "whole frame"


@dataclass
class Playing:
    """A variant of the scene, as far as it has been played."""

    scene: Scene
    solver: ClothSolver
    state: State
    taken: list[tuple[float, float]]
    """ms of each frame: of the clock, and of the processor, all threads together."""

    def step(self) -> None:
        """One frame, timed."""
        inputs = self.scene.script.inputs_at(self.state.time, self.scene.inputs)
        began, busy = time.perf_counter(), time.process_time()
        self.state = self.solver.step(self.state, inputs)
        self.taken.append((1e3 * (time.perf_counter() - began), 1e3 * (time.process_time() - busy)))


def begun(scene: Scene) -> Playing:
    """At its start, everything compiled."""
    solver, state = scene.build()
    solver.prepare(state)
    return Playing(scene, solver, state, [])


def variants() -> dict[str, Scene]:
    """The scene, and what it is without one thing at a time."""
    scene = Scene.load(find_scene("mannequin"))
    apart = replace(scene.solver, self_collision=False)
    still = replace(scene, script=replace(scene.script, wind=()), inputs=replace(scene.inputs, wind=Wind()))
    return {
        WHOLE: scene,
        "without self-collision": replace(scene, solver=apart),
        "without wind": still,
    }


def medians(seconds: float, scenes: Mapping[str, Scene]) -> dict[str, np.ndarray]:
    """ms of the frames of each after the free fall, by the clock and of the processor."""
    playing = {name: begun(scene) for name, scene in scenes.items()}
    for _ in range(round(seconds / 0.02)):
        for each in playing.values():
            each.step()
    return {name: np.array(each.taken[round(SKIPPED / 0.02) :]) for name, each in playing.items()}


def profile(scene: Scene, start: float, frames: int) -> list[tuple[str, float]]:
    """Who takes how many ms of a frame, from ``start`` s on, by function; the most first."""
    playing = begun(scene)
    while playing.state.time < start:
        playing.step()
    watch = cProfile.Profile()
    watch.enable()
    for _ in range(frames):
        playing.step()
    watch.disable()
    found = pstats.Stats(watch).stats.items()  # type: ignore[attr-defined]
    taken = [(f"{Path(file).stem}.{name}", 1e3 * own / frames) for (file, _, name), (_, _, own, _, _) in found]
    return sorted(taken, key=lambda each: -each[1])


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0, help="of each variant (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=min(2, os.cpu_count() or 1), help="(default: %(default)s)")
    options = parser.parse_args()
    numba.set_num_threads(options.threads)
    scenes = variants()
    count = scenes[WHOLE].mesh.vertex_count
    print(f"{count} vertices, {options.threads} threads; wanted {BAR:g} ms, better {AIM:g}")
    for name, taken in medians(options.seconds, scenes).items():
        (p50, busy), (p99, _) = np.percentile(taken, [50, 99], axis=0)
        least = taken[:, 0].min()
        print(f"  {name}: median {p50:.1f} ms, 99 in 100 below {p99:.1f}, least {least:.1f}; processor {busy:.1f} ms")
    print("ms of a frame at rest on the body, profiled:")
    for name, own in profile(scenes[WHOLE], 2.0, 50)[:LISTED]:
        print(f"  {own:6.2f}  {name}")


if __name__ == "__main__":
    main()
