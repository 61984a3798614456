"""A ball that spins under a draped cloth: how far threads are stretched, and whether all stays finite.

It starts within two seconds and goes on for a minute; what it throws off falls to the ground around it.

    python benchmarks/spin.py --speed 20 --speed 100
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator

import numpy as np

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig, State
from cloth_core.obstacles import Plane, Sphere

START = 2.0
"""s, in which the ball comes up to its speed."""


def spun(speed: float, side: int, seconds: float) -> Iterator[tuple[ClothSolver, State]]:
    """Every step of a cloth of 1 m, ``side`` x ``side`` vertices, on a ball of 0.3 m that spins at ``speed`` rad/s."""
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    ball, ground = Sphere(radius=0.3, center=(0.0, 0.0, 0.35)), Plane()
    config = SolverConfig(max_obstacle_speed=max(10.0, 2.0 * speed * ball.radius))
    solver = ClothSolver(mesh, Material(friction=0.5), config, obstacles={"ball": ball, "ground": ground})
    state = solver.initial_state(Pose((0.0, 0.0, 0.66)))
    for _ in range(round(seconds / config.dt)):
        time = state.time + config.dt
        angle = speed * (0.5 * time * time / START if time < START else time - 0.5 * START)
        turn = Pose(ball.center, (0.0, 0.0, math.sin(0.5 * angle), math.cos(0.5 * angle)))
        state = solver.step(state, Inputs(obstacles={"ball": turn}))
        yield solver, state


def main() -> None:
    """Print one line for each speed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--speed", type=float, action="append", help="rad/s; 20 and 100 by default")
    parser.add_argument("--side", type=int, default=30, help="vertices along an edge; 30 by default")
    parser.add_argument("--seconds", type=float, default=60.0, help="simulated; 60 by default")
    options = parser.parse_args()
    for speed in options.speed or (20.0, 100.0):
        stretch, undone, fastest = 1.0, 0, 0.0
        for solver, state in spun(speed, options.side, options.seconds):
            stretch, undone = max(stretch, solver.report.max_stretch), undone + solver.report.recovered
            fastest = max(fastest, float(np.abs(state.velocity).max()))
        limit = solver.material.stretch_limit
        print(
            f"{speed:g} rad/s, {options.seconds:g} s: stretch at most {stretch:.3f} (limit {limit:g} + 0.05), "
            f"fastest {fastest:.1f} m/s, steps undone {undone}"
        )


if __name__ == "__main__":
    main()
