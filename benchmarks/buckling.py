"""How true a cloth falls on a ball, where its threads are pressed and must give way across themselves.

    python benchmarks/buckling.py

A square metre is let fall 25 cm onto a ball of 25 cm; mean heights of 0.6 s as shipped and with fewer or more substeps,
against 100 substeps a frame with two iterations each. About two minutes.
"""

from __future__ import annotations

import numpy as np

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig
from cloth_core.obstacles import Obstacle, Plane, Sphere

SECONDS, FRAME = 0.6, 0.02


def main() -> None:
    """Print the table."""
    print(f"{'vertices':>10} {'substeps':>9} {'largest error, mm':>18} {'rms, mm':>8}")
    for side in (20, 30, 40, 60):
        true = fall(side, substeps=100, iterations=2)
        for substeps in (0, 5, 16):
            error = 1000.0 * (fall(side, substeps) - true)
            name = substeps or "shipped"
            print(f"{side:>4} x {side:<3} {name:>9} {np.abs(error).max():18.1f} {np.sqrt(np.mean(error**2)):8.1f}")


def fall(side: int, substeps: int = 0, iterations: int = 0) -> np.ndarray:
    """Mean height, m, at the end of every frame."""
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    obstacles: dict[str, Obstacle] = {"ball": Sphere(radius=0.25, center=(0.0, 0.0, 0.25)), "floor": Plane()}
    config = SolverConfig(dt=FRAME, substeps=substeps, iterations=iterations)
    solver = ClothSolver(mesh, Material(), config, obstacles=obstacles)
    state, height = solver.initial_state(Pose((0.03, 0.02, 0.75))), []
    for _ in range(round(SECONDS / FRAME)):
        state = solver.step(state, Inputs())
        height.append(state.position[:, 2].mean())
    return np.array(height)


if __name__ == "__main__":
    main()
