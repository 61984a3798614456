"""The benchmark of grabs: it holds what it says it holds, and counts late slots."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from cloth_core import Inputs

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "grab.py"


@pytest.fixture(scope="module")
def grab():
    spec = importlib.util.spec_from_file_location("benchmark_grab", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("count", [1, 8])
def test_its_hands_take_64_vertices_and_give_them_back(grab, count):
    solver, state = grab.swinging(24)
    times, number = grab.compare(solver, state, count, 3)
    assert number == grab.GRABBED
    counts = {name: len(series) for name, series in vars(times).items()}
    assert counts == {"free": 3, "grab": 3, "release": 3, "held": 3 * grab.HOLD, "beside": 3 * grab.HOLD}
    assert min(min(series) for series in vars(times).values()) > 0.0
    solver.step(state, grab.hands(state, count, 0.0))
    assert solver.report.held == len(solver.pinned)


def test_it_counts_the_slots_that_end_too_late(grab, monkeypatch):
    """On a clock of its own: steps of 5 ms, and one of 50 ms, which takes three slots."""

    class Clock:
        now = 0.0

        def perf_counter(self):
            return self.now

        def sleep(self, seconds):
            self.now += seconds

    class Solver:
        def __init__(self):
            self.taken = iter([0.005, 0.005, 0.05, 0.005, 0.005])

        def step(self, state, inputs):
            clock.now += next(self.taken)
            return state

    clock = Clock()
    monkeypatch.setattr(grab, "time", clock)
    slots = grab.in_slots(Solver(), None, lambda *_: Inputs(), iter(range(5)))
    assert slots.missed == 1
    np.testing.assert_allclose(slots.took, [5.0, 5.0, 50.0, 5.0, 5.0])
    # Two slots, then one from 0.04 to 0.09 s, then those that begin at 0.08 s (late by 10 ms) and 0.1 s.
    assert clock.now == pytest.approx(0.12)


def test_it_changes_the_material_in_another_thread_while_slots_go_on(grab):
    solver, state = grab.swinging(24)
    took, slots = grab.changed_meanwhile(solver, state, solver.material)
    assert took > 0.0 and len(slots.took) >= 1
