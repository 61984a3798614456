"""The harness: runs one engine on one scenario in this process, measures it, writes a JSON file.

    python bench_fms.py --n 50 --scenario drape --json out.json

Timed in every frame: pushing the targets, stepping, reading all positions back. What is measured on the positions
is not timed. An engine is a class of the shape of :class:`Engine`, in a file ``bench_<name>.py``.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
import traceback
from typing import Any, ClassVar, Protocol

import metrics
import numpy as np
from record import Record
from workload import ABUSES, FRAME, SCENARIOS, Scene


class Engine(Protocol):
    """What the harness asks of an engine."""

    name: ClassVar[str]
    variants: ClassVar[tuple[str, ...]]

    @staticmethod
    def collides_with_itself(variant: str) -> bool:
        """Whether the variant has self-collision."""

    @staticmethod
    def settings(n: int, scenario: str, variant: str) -> dict[str, Any]:
        """The cheapest settings of its documentation that stay stable, by name."""

    @staticmethod
    def load() -> None:
        """Import what it needs; the time is reported apart."""

    @staticmethod
    def version() -> str:
        """Of the loaded engine."""

    def __init__(self, scene: Scene, settings: dict[str, Any], variant: str) -> None:
        """Build the scene; the time is reported apart."""

    def step(self, targets: np.ndarray | None) -> None:
        """Advance by one frame, the held vertices to ``targets`` (H, 3) m."""

    def positions(self) -> np.ndarray:
        """(V, 3) m, in an order of the engine's own that stays."""


def run(engine: type[Engine], arguments: list[str] | None = None) -> None:
    """Command line of an engine's file. Ends the process: some engines hang or crash in their exit handlers."""
    options = _options(engine, arguments)
    settings = _settings(engine, options)
    scene = Scene(options.scenario, options.n, options.robust, options.frame_dt, options.frames)
    result = dict(
        engine=engine.name, variant=options.variant, n=options.n, scenario=options.scenario, robust=options.robust
    ) | dict(cfg=settings, frame_dt=options.frame_dt, status="ok")
    if scene.self_collision and not engine.collides_with_itself(options.variant):
        result["status"] = "n/a (no self collision)"
    else:
        try:
            _measure(engine, scene, settings, options, result)
        except Exception as error:
            result["status"] = f"error: {type(error).__name__}: {str(error)[:300]}"
            traceback.print_exc()
    if options.json:
        with open(options.json, "w") as file:
            json.dump(result, file, indent=1, default=float)
    _print(result)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)


def _measure(
    kind: type[Engine], scene: Scene, settings: dict[str, Any], options: argparse.Namespace, result: dict[str, Any]
) -> None:
    """Load, build and run the engine; everything found goes into ``result``."""
    began = time.perf_counter()
    kind.load()
    result |= {"import_s": time.perf_counter() - began, "version": kind.version()}
    began = time.perf_counter()
    engine = kind(scene, settings, options.variant)
    result |= {"build_s": time.perf_counter() - began, "rss_build_mb": _memory_mb()}
    order = metrics.canonical_order(scene, engine.positions())
    began = time.perf_counter()
    position = _frame(engine, scene, 0, order)
    result["first_frame_s"] = time.perf_counter() - began

    record = Record(scene)
    position = _play(engine, scene, order, position, record, options.max_wall)
    result |= record.results() | {"rss_mb": _memory_mb(), "finite_end": bool(np.isfinite(position).all())}
    done = result["frames"] + 1
    if done < scene.whole:
        result["truncated_at_s"] = round(done * scene.frame_dt, 3)
    if result["finite_end"]:
        result |= _end(scene, position, done) | {"speed_end": record.speed}
    if options.save:
        np.save(options.save, position)
    if hasattr(engine, "note"):
        result["note"] = engine.note


def _play(
    engine: Engine, scene: Scene, order: np.ndarray, position: np.ndarray, record: Record, max_wall: float
) -> np.ndarray:
    """All frames but the first, until the end, or time is up, or there is nothing left to watch; the last positions."""
    began = time.perf_counter()
    for frame in range(1, scene.frames):
        before = position
        wall, cpu = time.perf_counter(), time.process_time()
        position = _frame(engine, scene, frame, order)
        record.wall.append(time.perf_counter() - wall)
        record.cpu.append(time.process_time() - cpu)
        record.see(frame, before, position)
        lost = scene.abuse is None and frame > 20 and not np.isfinite(position).all()
        if lost or time.perf_counter() - began > max_wall:
            break
    return position


def _frame(engine: Engine, scene: Scene, frame: int, order: np.ndarray) -> np.ndarray:
    engine.step(scene.targets((frame + 1) * scene.frame_dt))
    return np.array(engine.positions(), float)[order]


def _end(scene: Scene, position: np.ndarray, frames: int) -> dict[str, Any]:
    """How the cloth is after the last of ``frames``."""
    stretch = metrics.stretch(scene, position)
    found = dict(
        stretch_end_max=float(stretch.max()),
        stretch_end_p99=float(np.percentile(stretch, 99)),
        stretch_end_mean=float(stretch.mean()),
        compress_end_min=float(stretch.min()),
        extent=float(np.abs(position).max()),
        zmin_end=float(position[:, 2].min()),
    )
    if scene.self_collision or scene.sphere:
        found["self_x"] = metrics.self_crossings(scene, position)
    if scene.held:
        off = position[scene.held] - scene.targets(frames * scene.frame_dt)
        found["grasp_err_m"] = float(np.linalg.norm(off, axis=1).max())
    return found


def _settings(engine: type[Engine], options: argparse.Namespace) -> dict[str, Any]:
    """The engine's own settings, changed by the command line."""
    if options.robust == "stiff":
        options.stiffness *= 1000.0
    if options.robust == "dt01":
        options.frame_dt = 0.1
    if options.threads:
        os.environ["OMP_NUM_THREADS"] = str(options.threads)
    given = {name: getattr(options, name) for name in ("substeps", "iters") if getattr(options, name)}
    own = engine.settings(options.n, options.scenario, options.variant)
    return {**own, **given, "stiffness": options.stiffness, "threads": options.threads}


def _memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _print(result: dict[str, Any]) -> None:
    """One line that says which run it was, one of all its numbers."""
    head = ("engine", "variant", "n", "scenario", "robust", "cfg")
    print(*(result[key] for key in head if result[key] is not None))
    rest = {key: value for key, value in result.items() if key not in (*head, "frame_dt")}
    print(" ", "  ".join(f"{k}={v:.4g}" if isinstance(v, float) else f"{k}={v}" for k, v in rest.items()))


def _options(engine: type[Engine], arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=f"Run {engine.name} on one scenario.")
    parser.add_argument("--n", type=int, default=50, help="vertices along each side (default: %(default)s)")
    parser.add_argument("--scenario", default="drape", choices=SCENARIOS)
    parser.add_argument("--json", default="", help="write the result there")
    parser.add_argument("--variant", default=engine.variants[0], choices=engine.variants)
    parser.add_argument("--substeps", type=int, default=0, help="0: the engine's own at this size")
    parser.add_argument("--iters", type=int, default=0, help="0: the engine's own at this size")
    parser.add_argument("--stiffness", type=float, default=1.0, help="multiplies the material's")
    parser.add_argument("--frame-dt", type=float, default=FRAME, help="s (default: %(default)s)")
    parser.add_argument("--robust", default=None, choices=ABUSES, help="an abuse to survive")
    parser.add_argument("--frames", type=int, default=0, help="stop after so many; 0: the whole scenario")
    parser.add_argument("--max-wall", type=float, default=30.0, help="stop after so many seconds of frames")
    parser.add_argument("--save", default="", help="write the final positions there (.npy)")
    parser.add_argument("--threads", type=int, default=0, help="0: the engine's own")
    return parser.parse_args(arguments)
