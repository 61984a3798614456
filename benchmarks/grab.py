"""What closing and opening hands costs, what a held cloth costs, and what a change of material made meanwhile costs.

    python benchmarks/grab.py                      50, 71 and 100 vertices a side, 64 of them in one hand, then in eight
    python benchmarks/grab.py --sides 100 --repeats 60

A step is a function of state and inputs, so the same state is stepped with hands that stay open and with hands that
close: the difference is the grab. Wanted at 100 x 100: 25 ms at the most, better 8, and no more than 1.3 times an
ordinary step, better 1.1, while they hold. Slots are those of 50 Hz on absolute deadlines, missed if a step ends after
its own; read those missed with hands, or while a material changes, against those missed with hands open.
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, State

SLOT = 0.02
GRABBED = 64
HOLD = 8
"""Steps that hands stay closed: the first ones have to stop what they caught, which takes further iterations."""


@dataclass
class Times:
    """ms of steps, of the same states in the same order."""

    free: list[float] = field(default_factory=list)
    grab: list[float] = field(default_factory=list)
    release: list[float] = field(default_factory=list)
    held: list[float] = field(default_factory=list)
    """Of ``HOLD`` steps after each grab."""
    beside: list[float] = field(default_factory=list)
    """Of as many without hands, from the same states on."""


@dataclass
class Slots:
    """ms of the steps that ran in 50 Hz slots, and how many of them ended too late."""

    took: list[float] = field(default_factory=list)
    missed: int = 0

    def __str__(self) -> str:
        return f"{self.missed:3d} of {len(self.took)} missed, longest {max(self.took):6.1f} ms"


def swinging(side: int) -> tuple[ClothSolver, State]:
    """A cloth of ``side`` x ``side`` vertices that hangs by two corners and swings."""
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=side, rows=side)
    solver = ClothSolver(mesh, Material())
    solver.pin(mesh.group("corners")[:2])
    state = solver.initial_state()
    for _ in range(10):
        state = solver.step(state, Inputs())
    return solver, state


def hands(state: State, count: int, closure: float) -> Inputs:
    """``count`` hands where the cloth is, each around its share of the vertices."""
    share, total = GRABBED // count, len(state.position)
    grasps = {}
    for number in range(count):
        middle = state.position[(2 * number + 1) * total // (2 * count) + total // 200]
        apart = np.sort(np.linalg.norm(state.position - middle, axis=1))
        radius = float(0.5 * (apart[share - 1] + apart[share]))
        grasps[f"hand {number}"] = Grasp(pose=Pose(tuple(middle)), closure=closure, radius=radius)
    return Inputs(grasps=grasps)


def timed(solver: ClothSolver, state: State, inputs: Inputs) -> tuple[State, float]:
    """The state after a step, and the ms that it took."""
    began = time.perf_counter()
    state = solver.step(state, inputs)
    return state, 1e3 * (time.perf_counter() - began)


def compare(solver: ClothSolver, state: State, count: int, repeats: int) -> tuple[Times, int]:
    """Steps that grab, hold and release beside those that do not; the number of vertices held."""
    times = Times()
    for _ in range(repeats):
        open_, closed = hands(state, count, 0.0), hands(state, count, 1.0)
        solver.step(state, open_)
        free, took = timed(solver, state, open_)
        times.free.append(took)
        held, took = timed(solver, state, closed)
        times.grab.append(took)
        number = solver.report.held - len(solver.pinned)
        times.release.append(timed(solver, held, open_)[1])
        state = _go_on(solver, free, open_, times.beside)
        _go_on(solver, held, closed, times.held)
    return times, number


def _go_on(solver: ClothSolver, state: State, inputs: Inputs, times: list[float]) -> State:
    """``HOLD`` steps more; that which sets the hands is not timed."""
    solver.step(state, inputs)
    for _ in range(HOLD):
        state, took = timed(solver, state, inputs)
        times.append(took)
    return state


def in_slots(solver: ClothSolver, state: State, given: Callable[[int, State], Inputs], frames: Iterator[int]) -> Slots:
    """Step in slots of 50 Hz as long as there are ``frames``; a late step takes whole slots."""
    slots, begin = Slots(), time.perf_counter()
    for number in frames:
        inputs = given(number, state)
        began = time.perf_counter()
        begin += SLOT * max(0, int((began - begin) / SLOT))
        state = solver.step(state, inputs)
        ended = time.perf_counter()
        slots.took.append(1e3 * (ended - began))
        slots.missed += ended > begin + SLOT
        begin += SLOT
        time.sleep(max(0.0, begin - time.perf_counter()))
    return slots


def grabbing(count: int) -> Callable[[int, State], Inputs]:
    """Hands that close and open every tenth of a second; where they close, the cloth is."""
    last: list[Inputs] = []

    def given(number: int, state: State) -> Inputs:
        if number % 10 == 0:
            last[:] = [hands(state, count, 1.0)]
        grasps = {name: replace(grasp, closure=float(number % 10 < 5)) for name, grasp in last[0].grasps.items()}
        return Inputs(grasps=grasps)

    return given


def changed_meanwhile(solver: ClothSolver, state: State, denim: Material) -> tuple[float, Slots]:
    """ms that a second thread takes to make the solver of another material, and the slots of the first meanwhile."""
    took: list[float] = []

    def change() -> None:
        began = time.perf_counter()
        solver.changed(material=denim)
        took.append(1e3 * (time.perf_counter() - began))

    worker = threading.Thread(target=change)

    def while_it_runs() -> Iterator[int]:
        worker.start()
        number = 0
        while worker.is_alive():
            yield number
            number += 1

    slots = in_slots(solver, state, lambda *_: Inputs(), while_it_runs())
    worker.join()
    return took[0], slots


def show(side: int, repeats: int) -> None:
    """Measure and print one size."""
    solver, state = swinging(side)
    print(f"{side} x {side} vertices, W {solver.representation}")
    for count in (1, 8):
        compare(solver, state, count, 2)  # compiles and touches everything once
        times, number = compare(solver, state, count, repeats)
        free, grab, release = np.array(times.free), np.array(times.grab), np.array(times.release)
        ratio = np.median(np.divide(times.held, times.beside))
        print(
            f"  {number} vertices in {count} hand{'s' * (count > 1)}: ordinary step {np.median(free):.1f} ms;"
            f" grab {np.median(grab - free):+.1f} ms, release {np.median(release - free):+.1f} ms,"
            f" a step with them held {ratio:.2f} x"
        )
    frames = 10 * repeats
    print(f"  slots, hands open:     {in_slots(solver, state, lambda *_: Inputs(), iter(range(frames)))}")
    print(f"  slots, 64 in and out:  {in_slots(solver, state, grabbing(1), iter(range(frames)))}")
    denim = Material.preset("denim")
    solver.changed(material=denim)
    rebuilt = [changed_meanwhile(solver, state, denim) for _ in range(max(3, repeats // 10))]
    together = Slots([ms for _, slots in rebuilt for ms in slots.took], sum(slots.missed for _, slots in rebuilt))
    print(f"  slots, change meanwhile: {together}; a change takes {np.median([ms for ms, _ in rebuilt]):.0f} ms")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sides", type=int, nargs="+", default=[50, 71, 100], help="vertices a side")
    parser.add_argument("--repeats", type=int, default=30, help="states to compare at")
    options = parser.parse_args()
    for side in options.sides:
        show(side, options.repeats)


if __name__ == "__main__":
    main()
