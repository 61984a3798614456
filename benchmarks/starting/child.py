"""What is measured inside a process of its own: run as ``python -m starting.child WHAT ...``, it prints one JSON line.

first SIDE BEGAN    the seconds from BEGAN, of the monotonic clock that all processes share, to the first frame
memory SIDE SCENE   the memory after 100 frames of hang or drape
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

FRAMES = 100


def memory_mb(status: str) -> dict[str, float]:
    """Resident memory now and at its peak, MB (2^20 bytes), from the text of a process's ``/proc/PID/status``.

    Raises:
        ValueError: a line is missing, as for a process that has ended.
    """
    found = dict(line.split(":", 1) for line in status.splitlines() if ":" in line)
    missing = {"VmRSS", "VmHWM"} - found.keys()
    if missing:
        raise ValueError(f"no {' and '.join(sorted(missing))} in the status of a process of {len(found)} lines")
    resident, peak = (float(found[name].removesuffix("kB")) / 1024.0 for name in ("VmRSS", "VmHWM"))
    return {"resident_mb": resident, "peak_mb": peak}


def first_frame(side: int, began: float) -> dict[str, Any]:
    """Import, build and step a cloth of ``side`` x ``side`` vertices with a pin, a hand, an obstacle and wind."""
    started = time.monotonic()
    from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Pose, Wind, compiling
    from cloth_core.obstacles import Sphere

    imported = time.monotonic()
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    solver = ClothSolver(mesh, obstacles={"ball": Sphere(radius=0.3, center=(0.0, 0.0, -0.295))})
    solver.pin(mesh.group("corners")[:2])
    corner = Pose(tuple(mesh.rest_position[mesh.group("corners")[3]]))
    hand = Grasp(pose=corner, closure=1.0, radius=2.5 / (side - 1))
    compiled: list[str] = []
    with compiling.told(lambda _number, name: compiled.append(name)):
        solver.step(solver.initial_state(), Inputs(wind=Wind(velocity=(1.0, 2.0, 0.0)), grasps={"hand": hand}))
    ended = time.monotonic()
    return {
        "first_frame_s": ended - began,
        "python_s": started - began,
        "import_s": imported - started,
        "step_s": ended - imported,
        "held": solver.report.held,
        "contacts": solver.report.contacts,
        "compiled": len(compiled),
        **memory_mb(Path("/proc/self/status").read_text()),
    }


def memory(side: int, scene: str) -> dict[str, Any]:
    """Play the first ``FRAMES`` frames of ``hang`` (two corners pinned) or ``drape`` (onto a ball and the ground)."""
    from cloth_core import ClothMesh, ClothSolver, Inputs, Pose
    from cloth_core.obstacles import Plane, Sphere

    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    ball = {"ball": Sphere(radius=0.3, center=(0.0, 0.0, 0.3)), "ground": Plane()}
    solver = ClothSolver(mesh, obstacles=ball if scene == "drape" else {})
    if scene == "hang":
        solver.pin(mesh.group("corners")[:2])
    state = solver.initial_state(Pose((0.0, 0.0, 0.75)))
    for _ in range(FRAMES):
        state = solver.step(state, Inputs())
    return {**memory_mb(Path("/proc/self/status").read_text()), "contacts": solver.report.contacts}


def main(what: str, side: str, more: str) -> None:
    """Measure and print."""
    result = first_frame(int(side), float(more)) if what == "first" else memory(int(side), more)
    print(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
