"""The rows, measured by the other benchmarks in their quick forms."""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from math import nan
from typing import Any

import grab
import mannequin
import mesh_independence
import start
from comparison import plan, process
from comparison.gate import stopped_early
from comparison.report import FASTER_SCENARIOS, FRAME_MS, STRETCH_AT_REST, STRETCH_LIMIT, WORST_STRETCH
from motion import measure, reference
from motion.cloth import release_test
from motion.report import TEN

from cloth_core import Inputs
from marks.row import Row

GRAB_SIDE, GRABS = 100, 20


def motion(sizes: list[int]) -> Iterator[Row]:
    """The release test, with ten solves a frame and as the solver comes."""
    heights, _ = reference.read()
    for solves, split, how in ((TEN, (TEN, 1), ""), (0, (0, 0), " of its own")):
        score = measure.score_of_solver(solves, heights)
        for k, (bar, aim) in measure.BARS.items():
            number = measure.solves_of_solver(release_test(k), *split)
            what = f"release test, {k} N/m, {number:g} solves a frame{how}: rms"
            yield Row(what, "m", bar, aim, score.error[k])


def peers_work(sizes: list[int]) -> Iterator[Row]:
    """Stretch over the limit and time of a frame, on the work that the peers are given."""
    for n in sizes:
        for scenario in WORST_STRETCH:
            yield from rows_of_result(process.play(plan.Job(plan.OURS, scenario, n), max_wall=120.0))


def rows_of_result(result: dict[str, Any]) -> Iterator[Row]:
    """The rows of one run in the peers' harness."""
    scenario, n = result["scenario"], result["n"]
    where = f"{scenario} {n} x {n}"
    note = result["status"] if result["status"] != "ok" else "stopped early" if stopped_early(result) else ""
    yield Row(f"{where}: stretch, worst", "", *WORST_STRETCH[scenario], _over(result, "stretch_max_run"), note=note)
    if scenario in STRETCH_AT_REST:
        at_rest = nan if note else _over(result, "stretch_end_max")
        yield Row(f"{where}: stretch, at the end", "", *STRETCH_AT_REST[scenario], at_rest, note=note)
    if scenario in FASTER_SCENARIOS and n in FRAME_MS:
        took = (result.get(key, nan) for key in ("ms_median", "ms_min"))
        yield Row(f"{where}: frame", "ms", *FRAME_MS[n], *took, note=note)


def _over(result: dict[str, Any], key: str) -> float:
    """By how much the longest edge exceeds the limit; of an edge that got shorter than that, nothing."""
    return max(0.0, result[key] - STRETCH_LIMIT) if key in result else nan


def hands(sizes: list[int]) -> Iterator[Row]:
    """64 vertices in one hand, of 10,000."""
    solver, state = grab.swinging(GRAB_SIDE)
    grab.compare(solver, state, 1, 2)  # touches everything once
    times, held = grab.compare(solver, state, 1, GRABS)
    where, shortest = f"{held} of {GRAB_SIDE**2:,} vertices", min(times.free)
    for what, taken in (("grabbed", times.grab), ("released", times.release)):
        more = statistics.median(one - free for one, free in zip(taken, times.free, strict=True))
        yield Row(f"{where} {what}: more than a frame", "ms", 25.0, 8.0, more, min(taken) - shortest)
    ratio = statistics.median(one / free for one, free in zip(times.held, times.beside, strict=True))
    yield Row(f"{where} held: frame against none held", "x", 1.3, 1.1, ratio, min(times.held) / min(times.beside))
    frames = 5 * GRABS
    idle = grab.in_slots(solver, state, lambda *_: Inputs(), iter(range(frames)))
    busy = grab.in_slots(solver, state, grab.grabbing(1), iter(range(frames)))
    note = f"of {frames} of 20 ms; {idle.missed} without hands"
    yield Row(f"{where} in and out: slots missed", "", 0.0, 0.0, float(busy.missed), note=note)


def first_frame(sizes: list[int]) -> Iterator[Row]:
    """From the start of Python, with kernels on disk and without."""
    for name, taken, bar, aim in (("warm", start.warm(5), 3.0, 1.5), ("empty", start.cold(1), 60.0, 25.0)):
        took = [one["first_frame_s"] for one in taken]
        what = f"first frame, {start.SIDE} x {start.SIDE}, {name} cache"
        yield Row(what, "s", bar, aim, statistics.median(took), min(took))


def memory(sizes: list[int]) -> Iterator[Row]:
    """Of a process that runs the solver and nothing else."""
    for scene, taken in start.memory().items():
        what = f"resident memory, {scene} {start.SIDE_OF_MEMORY} x {start.SIDE_OF_MEMORY}"
        yield Row(what, "MB", 400.0, 250.0, taken["peak_mb"])


def mesh(sizes: list[int]) -> Iterator[Row]:
    """How far jittered triangles and a finer grid are from the grid."""
    for row in mesh_independence.rows(quick=True):
        if row.judged:
            worst = mesh_independence.compare(row, range(3)).worst
            yield Row(f"mesh independence, {row.name}", "", mesh_independence.BAR, mesh_independence.AIM, worst)


def body(sizes: list[int]) -> Iterator[Row]:
    """All that a frame may have: a body, self-collision, wind and its shadow."""
    scene = mannequin.variants()[mannequin.WHOLE]
    taken = mannequin.medians(5.0, {mannequin.WHOLE: scene})[mannequin.WHOLE][:, 0]
    what = f"{scene.mesh.vertex_count:,} vertices on a human body, self-collision, wind with shadow: frame"
    yield Row(what, "ms", mannequin.BAR, mannequin.AIM, float(statistics.median(taken)), float(taken.min()))


PARTS = {
    "motion": motion,
    "peers": peers_work,
    "grab": hands,
    "start": first_frame,
    "memory": memory,
    "mesh": mesh,
    "body": body,
}
"""What can be asked for, in the order of the table; each is given the vertices a side that are wanted."""
