"""Laws of motion: free fall, both momenta, and what swings."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import j0, jn_zeros

from cloth_core.config import SolverConfig
from cloth_core.inputs import Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.solver import ClothSolver
from cloth_core.state import State
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import (
    GRAVITY,
    NO_GRAVITY,
    UNLIMITED,
    angular_momentum,
    fine,
    hanging_strip,
    last,
    period,
    states,
    tumbling_sheet,
)

OVERDAMPED = "its viscosity k dt (v_j - v_i) resists turning as well as stretching: the swing is overdamped"


def free_fall(integrator: str) -> Measurement:
    """In a time t the cloth falls by g t^2 / 2, or g h^2 n (n + 1) / 2 in n steps of the paper.

    The midpoint rule is exact for a constant g; the paper's step takes up the speed before it moves, and falls
    further by g t h / 2. The vertex measured is the farthest off.
    """
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=9, rows=9)
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator, air_density=0.0))
    start = solver.initial_state()
    drop = last(solver, start, Inputs(), 1.0).position[:, 2] - start.position[:, 2]
    n = 50 * solver.substeps
    expected = -0.5 * GRAVITY * (1.0 + 1.0 / n if integrator == "meyer2000" else 1.0)
    return Measurement(expected, float(drop[np.argmax(np.abs(drop - expected))]), 1e-9, "m")


def linear_momentum(integrator: str) -> Measurement:
    """Without external forces the momentum stays: its largest change in a step, over the sum of m |v|, is 0."""
    solver, state = tumbling_sheet(integrator)
    mass = solver.mesh.vertex_mass(solver.material)
    worst = 0.0
    for after in states(solver, state, NO_GRAVITY, 2.0):
        size = mass @ np.linalg.norm(after.velocity, axis=1)
        worst = max(worst, float(np.linalg.norm(mass @ (after.velocity - state.velocity)) / size))
        state = after
    return Measurement(0.0, worst, 1e-12)


def angular_momentum_kept(integrator: str) -> Measurement:
    """Without external forces |L| about the centre of mass stays, here over 2 s of tumbling.

    The midpoint rule keeps it for its own velocity, half a substep ahead of the mean one that is read here; so the
    bound is that of a second-order reading.
    """
    solver, state = tumbling_sheet(integrator)
    mass = solver.mesh.vertex_mass(solver.material)
    before = angular_momentum(state, mass)
    after = [angular_momentum(s, mass) for s in states(solver, state, NO_GRAVITY, 2.0)]
    farthest = after[int(np.argmax([np.linalg.norm(a - before) for a in after]))]
    size = float(np.linalg.norm(before))
    bound = 1e-9 if integrator == "meyer2000" else 1e-4
    return Measurement(size, size + float(np.linalg.norm(farthest - before)), bound, "kg m^2/s")


def plate_swing(integrator: str) -> Measurement:
    """A stiff plate of length L hinged on an edge swings with T = 2 pi sqrt(2 L / 3 g).

    At an amplitude a, T is 1 + a^2 / 16 times longer.
    """
    length, amplitude, rows = 0.4, 0.1, 13
    flat = ClothMesh.grid(width=0.1, height=length, columns=4, rows=rows)
    solver = ClothSolver(flat, Material(bend=10.0, stretch_limit=UNLIMITED), fine(integrator, iterations=20))
    solver.pin(flat.group("top"))
    down = flat.rest_position - [0.0, 0.5 * length, 0.0]
    position = np.stack([down[:, 1] * -math.sin(amplitude), down[:, 0], down[:, 1] * math.cos(amplitude)], axis=1)
    state = State(np.ascontiguousarray(position), np.zeros_like(position))
    bottom = flat.group("bottom")[0]
    run = [(s.time, s.position[bottom, 0]) for s in states(solver, state, Inputs(), 4.0)]
    expected = 2 * math.pi * math.sqrt(2 * length / (3 * GRAVITY)) * (1 + amplitude**2 / 16)
    return Measurement(expected, period(*np.array(run).T), 0.003, "s")


def _strip_swing(integrator: str, mode: int, *, rows: int, iterations: int, bound: float) -> Measurement:
    length = 1.0
    mesh, top = hanging_strip(length, rows)
    solver = ClothSolver(mesh, Material(bend=0.0, stretch_limit=UNLIMITED), fine(integrator, iterations=iterations))
    solver.pin(top)
    zero = jn_zeros(0, mode)[-1]
    start = solver.initial_state()
    height = 1.0 + start.position[:, 2] / length
    shape = j0(zero * np.sqrt(np.clip(height, 0.0, None)))
    start.position[:, 0] = 0.02 * length / mode * shape
    weight = solver.mesh.vertex_mass(solver.material) * shape
    run = [(s.time, weight @ s.position[:, 0]) for s in states(solver, start, Inputs(), 6.0 / mode)]
    expected = 2 * math.pi / (0.5 * zero * math.sqrt(GRAVITY / length))
    return Measurement(expected, period(*np.array(run).T), bound, "s")


def strip_swing_1(integrator: str) -> Measurement:
    """A hanging strip swings with T = 2 pi / ((z / 2) sqrt(g / L)), z = 2.4048 the first zero of J0.

    The hanging chain of Daniel Bernoulli; started in the shape of the mode, read as the mode's coordinate.
    """
    return _strip_swing(integrator, 1, rows=41, iterations=20, bound=1e-3)


def strip_swing_2(integrator: str) -> Measurement:
    """Its second mode swings with T = 2 pi / ((z / 2) sqrt(g / L)), z = 5.5201 the second zero of J0.

    W holds threads as stiff across as along, a thousand times what their tension does, and only iterations undo
    that: each one brings the free end, where the mode is steepest, closer to the rule. Twenty leave a per cent.
    """
    return _strip_swing(integrator, 2, rows=61, iterations=100, bound=3e-3)


LAWS = (
    Law("free fall", free_fall),
    Law("linear momentum", linear_momentum),
    Law("angular momentum", angular_momentum_kept),
    Law("plate swing", plate_swing, exempt={"meyer2000": OVERDAMPED}),
    Law("strip swing 1", strip_swing_1, exempt={"meyer2000": OVERDAMPED}),
    Law("strip swing 2", strip_swing_2, exempt={"meyer2000": OVERDAMPED}),
)
