"""Solvers of other parameters come when they are made, the newest wish last."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, MeshError
from cloth_sim_ros.simulation.tuning import Tuning


@pytest.fixture
def kit():
    ready = threading.Semaphore(0)
    solver = ClothSolver(ClothMesh.grid(width=0.4, height=0.4, columns=5, rows=5))
    tuning = Tuning(solver, ready.release)
    yield solver, tuning, lambda: ready.acquire(timeout=60.0)
    tuning.close()


def test_a_wish_becomes_a_solver_that_takes_up_the_state(kit):
    solver, tuning, wait = kit
    state = solver.step(solver.initial_state(), Inputs())
    heavy = replace(solver.material, areal_density=1.0)
    tuning.want(heavy, solver.config)
    assert tuning.wish == (heavy, solver.config)
    assert wait()
    made = tuning.take()
    assert made.material == heavy
    assert made.step(state, Inputs()).step_index == 2
    assert tuning.take() is None


def test_a_wish_for_what_is_in_force_changes_no_bit(kit):
    solver, tuning, wait = kit
    tuning.want(replace(solver.material, friction=0.9), solver.config)
    tuning.want(Material(), solver.config)
    assert wait()
    made = tuning.take()
    if made is None or made.material != Material():  # the first was made before the second was wished for
        assert wait()
        made = tuning.take()
    state = solver.initial_state()
    assert made.step(state, Inputs()).digest == solver.step(state, Inputs()).digest


def test_many_wishes_end_with_the_last_one(kit):
    solver, tuning, wait = kit
    for friction in np.linspace(0.0, 1.0, 40):
        tuning.want(replace(solver.material, friction=float(friction)), solver.config)
    newest = None
    while newest is None or newest.material.friction < 1.0:
        assert wait()
        newest = tuning.take() or newest
    assert tuning.wish[0].friction == 1.0


def test_a_wish_that_cannot_be_made_says_why_and_is_forgotten():
    ready = threading.Semaphore(0)
    solver = ClothSolver(ClothMesh.grid(width=0.001, height=0.001, columns=5, rows=5))
    tuning = Tuning(solver, ready.release)
    impossible = replace(solver.material, areal_density=0.001, bend=1000.0)
    tuning.want(impossible, replace(solver.config, substeps=1))
    assert ready.acquire(timeout=60.0)
    with pytest.raises(MeshError, match="too light"):
        tuning.take()
    assert tuning.wish == (solver.material, solver.config)
    tuning.close()
