"""Where a step's time goes, how much memory a solver takes, and how long until the first frame.

    python benchmarks/step_time.py                 the table at 20, 50 and 100 vertices a side
    python benchmarks/step_time.py --cold          also the first frame with an empty kernel cache

Every size runs in a process of its own. Times are medians over the frames of a cloth that hangs by two
corners in a light wind and swings into a sphere; read them as ratios, on a machine of which you know the load.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

PARTS = ("forces", "W", "stretch limit", "contacts", "rest")


class Stopwatch:
    """Adds up the time spent in wrapped functions, by part."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)

    def wrap(self, owner: Any, name: str, part: str) -> None:
        """Time every call of ``owner.name`` under ``part``."""
        function = getattr(owner, name)

        def timed(*arguments: Any, **keywords: Any) -> Any:
            began = time.perf_counter()
            try:
                return function(*arguments, **keywords)
            finally:
                self.spent[part] += time.perf_counter() - began

        setattr(owner, name, timed)


def build(side: int, integrator: str) -> tuple[Any, Any, Any]:
    """A cloth of ``side`` x ``side`` vertices beside a sphere; returns solver, state and inputs."""
    from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig, Wind
    from cloth_core.obstacles import Plane, Sphere

    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    obstacles = {"ball": Sphere(radius=0.3, center=(0.0, 0.2, -0.5)), "floor": Plane(center=(0.0, 0.0, -1.2))}
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator), obstacles=obstacles)
    solver.pin(mesh.group("corners")[:2])
    return solver, solver.initial_state(), Inputs(wind=Wind(velocity=(1.0, 2.0, 0.0)))


def measure(side: int, integrator: str, frames: int) -> dict[str, Any]:
    """Medians over ``frames`` steps at one size, in this process."""
    began = time.perf_counter()
    import numpy as np

    solver, state, inputs = build(side, integrator)
    state = solver.step(state, inputs)
    first = time.perf_counter() - began

    whole = []
    for _ in range(frames):
        began = time.perf_counter()
        state = solver.step(state, inputs)
        whole.append(time.perf_counter() - began)
    parts = split(solver, state, inputs, max(20, frames // 4))
    return {
        "vertices": side * side,
        "integrator": integrator,
        "inverse": solver.representation,
        "step_ms": 1e3 * float(np.median(whole)),
        "p99_ms": 1e3 * float(np.percentile(whole, 99)),
        **{part: 1e3 * parts[part] for part in PARTS},
        "first_frame_s": first,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def split(solver: Any, state: Any, inputs: Any, frames: int) -> dict[str, float]:
    """Seconds per step spent in each part; the rest is what no part claims."""
    from cloth_core.kernels import curvature, membrane, springs, surface

    model, watch = solver._model, Stopwatch()
    for name in ("add_elastic_impulses", "add_spring_forces"):
        watch.wrap(springs, name, "forces")
    for name in ("add_membrane_impulses", "add_membrane_forces"):
        watch.wrap(membrane, name, "forces")
    watch.wrap(curvature, "add_bending_forces", "forces")
    for name in ("area_vectors", "add_relative_drag", "add_drag_of_flow"):
        watch.wrap(surface, name, "forces")
    for one in model._filters:
        watch.wrap(one, "solve", "W")
    watch.wrap(model.limit, "sweep", "stretch limit")
    for name in ("begin_step", "begin_substep", "find", "push_out", "apply_friction", "settle_velocity"):
        watch.wrap(model.contacts, name, "contacts")
    step: Callable[..., Any] = solver.step
    began = time.perf_counter()
    for _ in range(frames):
        state = step(state, inputs)
    total = time.perf_counter() - began
    spent = {part: watch.spent[part] / frames for part in PARTS}
    spent["rest"] = total / frames - sum(spent.values())
    return spent


def in_child(side: int, integrator: str, frames: int, cache: str | None = None) -> dict[str, Any]:
    """Measure one size in a process of its own, with its own kernel cache if ``cache`` names a folder."""
    environment = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}
    command = [sys.executable, __file__, "--one", str(side), integrator, "--frames", str(frames)]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def show(rows: list[dict[str, Any]]) -> None:
    """Print the table."""
    print(
        f"{'vertices':>9} {'integrator':15} {'inverse':9} {'step ms':>8} {'p99':>7} "
        + " ".join(f"{p:>13}" for p in PARTS),
        end="",
    )
    print(f" {'first s':>8} {'memory MB':>10}")
    for row in rows:
        print(f"{row['vertices']:9d} {row['integrator']:15} {row['inverse']:9} ", end="")
        print(f"{row['step_ms']:8.2f} {row['p99_ms']:7.2f} ", end="")
        print(
            " ".join(f"{row[part]:13.2f}" for part in PARTS) + f" {row['first_frame_s']:8.2f} {row['memory_mb']:10.0f}"
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sides", type=int, nargs="+", default=[20, 50, 100], help="vertices a side")
    parser.add_argument("--frames", type=int, default=200, help="steps to time")
    parser.add_argument("--cold", action="store_true", help="also time the first frame with an empty kernel cache")
    parser.add_argument("--json", help="write the rows to this file")
    parser.add_argument("--one", nargs=2, metavar=("SIDE", "INTEGRATOR"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(int(options.one[0]), options.one[1], options.frames)))
        return
    in_child(20, "implicit_midpoint", 1)
    in_child(20, "meyer2000", 1)
    both = ("implicit_midpoint", "meyer2000")
    rows = [in_child(side, name, options.frames) for side in options.sides for name in both]
    show(rows)
    if options.cold:
        with tempfile.TemporaryDirectory() as cache:
            row = in_child(50, "implicit_midpoint", 1, cache)
        print(f"first frame at 50 x 50 with an empty kernel cache: {row['first_frame_s']:.1f} s")
    if options.json:
        with open(options.json, "w") as file:
            json.dump(rows, file, indent=1)


if __name__ == "__main__":
    main()
