"""Whatever a user does, the cloth stays finite and comes back."""

from __future__ import annotations

import numpy as np
import pytest
from busy import OBSTACLES

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Grasp,
    Inputs,
    Material,
    Pose,
    SolverConfig,
    Wind,
)

BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])


def teleported(n: int) -> Inputs:
    place = (0.3 + 10.0 * (n % 2), -0.25 - 10.0 * (n % 3), 5.0 * (n > 0))
    return Inputs(grasps={"hand": Grasp(pose=Pose(place), closure=1.0, radius=0.3)})


def chatter(n: int) -> Inputs:
    hands = {
        name: Grasp(pose=Pose((x, -0.25, 0.1)), closure=float(n % 2), radius=0.3)
        for name, x in (("a", 0.3), ("b", -0.3))
    }
    return Inputs(grasps=hands)


def tugged(n: int) -> Inputs:
    """Two hands that pull far apart what holds together."""
    hands = {
        name: Grasp(pose=Pose((s * (0.3 + 0.1 * n), -0.25, 0.0)), closure=1.0, radius=0.1)
        for name, s in (("a", 1), ("b", -1))
    }
    return Inputs(grasps=hands)


def spun(n: int) -> Inputs:
    half = 0.5 * 20.0 * 0.02 * n
    return Inputs(obstacles={"ball": Pose((0.05, 0.0, -0.2 + 0.05 * (n % 2)), (0.0, np.sin(half), 0.0, np.cos(half)))})


def stormy(n: int) -> Inputs:
    return Inputs(wind=Wind(velocity=(1e6 * (-1) ** n, 1e6, -1e6), gust_intensity=1.0))


def jumping(n: int) -> Inputs:
    return Inputs(
        obstacles={"ball": Pose((0.1 * (-1) ** n, 0.0, -0.1)), "floor": Pose((0.0, 0.0, -0.5 + 0.4 * (n % 2)))}
    )


ADVERSARIES = (teleported, chatter, tugged, spun, stormy, jumping)
SETUPS = {
    "as shipped": ({}, {}),
    "dt 1 ms": ({"dt": 0.001}, {}),
    "dt 0.1 s": ({"dt": 0.1}, {}),
    "stiffness x 1000": ({}, {"stretch_warp": 2e6, "stretch_weft": 2e6, "shear": 4e5, "bend": 0.05}),
    "no iterations to spare": ({"substeps": 1, "iterations": 1, "stretch_sweeps": 1}, {}),
}


# Eq. (5) knows the wind alone: meyer2000 has nothing that keeps a free cloth from outrunning it.
# The default may be as fast as the air: 40 m/s at most on the mean, and gusts of the same strength in three directions.
FASTEST = {"implicit_midpoint": 150.0, "meyer2000": 3000.0}


@BOTH
@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("adversary", ADVERSARIES, ids=lambda f: f.__name__)
def test_no_user_breaks_it(integrator, setup, adversary):
    """Finite throughout, no state replaced, no speed beyond what drives it; calmer and whole once left alone."""
    config, fabric = SETUPS[setup]
    mesh = ClothMesh.grid(width=0.6, height=0.5, columns=12, rows=10)
    material = Material(**{"friction": 0.4, "damping": 2.0, **fabric})
    solver = ClothSolver(mesh, material, SolverConfig(integrator=integrator, **config), obstacles=OBSTACLES)
    state = solver.initial_state()
    for n in range(30):
        state = solver.step(state, adversary(n))
        assert np.isfinite(state.position).all() and np.isfinite(state.velocity).all()
        assert not solver.report.recovered
        assert np.linalg.norm(state.velocity, axis=1).max() < FASTEST[integrator]
    if solver.config.dt < 0.01:
        return  # it would take thousands of steps to come to rest
    for _ in range(round(4.0 / solver.config.dt)):
        state = solver.step(state, Inputs())
        assert not solver.report.recovered
    # Relative to the whole: what a storm has thrown up may still be falling.
    assert np.linalg.norm(state.velocity - state.velocity.mean(axis=0), axis=1).max() < 3.0
    if setup != "no iterations to spare":  # friction holds what a single pass leaves stretched
        excess = {"implicit_midpoint": 0.05, "meyer2000": 0.08}[integrator]
        assert solver.report.max_stretch < material.stretch_limit + excess
