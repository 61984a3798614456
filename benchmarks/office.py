"""What standing furniture costs: a cloth on a desk, alone, and in an office of 30 things.

    python benchmarks/office.py
    python benchmarks/office.py --side 100 --steps 200

The office stands around the desk as 30 obstacles of their own, and as one compound, whose field is asked as one thing
(paper, 4.2.3). Wanted of the 30: at most 1.3 times the frame with the desk alone, better 1.05.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping

import numpy as np
from voxels.furniture import desk, office

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, State
from cloth_core.fields import Compound
from cloth_core.obstacles import Obstacle


def staged(obstacles: Mapping[str, Obstacle], side: int) -> tuple[ClothSolver, State]:
    """A cloth of 1 m just above the desk, which hangs over its edges."""
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    solver = ClothSolver(mesh, Material(damping=1.0), obstacles=obstacles)
    solver.prepare()
    return solver, solver.initial_state(Pose((0.43, 0.2, 0.78)))


def frames(scenes: Mapping[str, Mapping[str, Obstacle]], side: int, steps: int) -> dict[str, np.ndarray]:
    """ms of the steps of each scene, which take turns, so that what else the machine does hits all alike."""
    solvers, states, taken = {}, {}, {name: [] for name in scenes}
    for name, obstacles in scenes.items():
        solvers[name], states[name] = staged(obstacles, side)
    for _ in range(steps):
        for name, solver in solvers.items():
            began = time.perf_counter()
            states[name] = solver.step(states[name], Inputs())
            taken[name].append(1e3 * (time.perf_counter() - began))
    return {name: np.array(each) for name, each in taken.items()}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--side", type=int, default=50, help="vertices a side (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=150, help="of each scene (default: %(default)s)")
    parser.add_argument("--voxel", type=float, default=0.02, help="m, of the compounds (default: %(default)s)")
    options = parser.parse_args()
    things = office()
    scenes: dict[str, Mapping[str, Obstacle]] = {
        "desk": desk(),
        "30 obstacles": things,
        "desk, a field": {"desk": Compound(parts=desk(), voxel=options.voxel)},
        "30 in one field": {"office": Compound(parts=things, voxel=options.voxel)},
    }
    taken = frames(scenes, options.side, options.steps)
    print(f"{options.side} x {options.side} vertices, {len(things)} things, {options.steps} steps")
    for name, each in taken.items():
        alone = taken["desk" if "field" not in name else "desk, a field"]
        ratio = np.median(each) / np.median(alone)
        print(
            f"  {name}: median {np.median(each):.2f} ms, least {each.min():.2f}; "
            f"of the desk alone {ratio:.2f}, step by step {np.median(each / alone):.2f}"
        )


if __name__ == "__main__":
    main()
