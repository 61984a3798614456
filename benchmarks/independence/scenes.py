"""What is measured: sag between two held edges, period of a swing, drape coefficient, a vibrating strip."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import eigh

from cloth_core import ClothSolver, Inputs, Material, SolverConfig, State
from cloth_core.linear import bending_matrix
from cloth_core.validation.scenes import GRAVITY, last, period, states
from independence.meshes import Mesher, mean_over_area, on_edge, spacing
from independence.shadow import shadow_area

FABRIC = dict(stretch_warp=1000.0, stretch_weft=400.0, shear=60.0, bend=5e-5, areal_density=0.2)
VACUUM = SolverConfig(air_density=0.0)
SQUARE, PEDESTAL = 0.30, 0.09
"""m: side of the draped cloth, radius of the pedestal."""
NOISE = 1e-3
"""m, by which the cloth that is let go to drape is uneven."""


def sag(mesher: Mesher, seed: int, held_axis: int = 0) -> float:
    """Mean depth, m, of 1 m x 0.5 m held along two opposite edges at their distance at rest."""
    mesh = mesher(*((1.0, 0.5) if held_axis == 0 else (0.5, 1.0)), seed)
    solver = ClothSolver(mesh, Material(**FABRIC, damping=4.0, stretch_limit=1.2), VACUUM)
    solver.pin(np.concatenate([on_edge(mesh, held_axis, side) for side in (-1.0, 1.0)]))
    state = last(solver, solver.initial_state(), Inputs(), 4.0)
    return -mean_over_area(mesh, state.position[:, 2])


def warp_sag(mesher: Mesher, seed: int) -> float:
    """The same, with the warp from edge to edge."""
    return sag(mesher, seed, held_axis=1)


def sag_of_a_ribbon(stiffness: float, span: float = 1.0) -> float:
    """Mean depth, m, in closed form: a parabola as taut as it is longer than the span (a per cent)."""
    load = FABRIC["areal_density"] * GRAVITY
    return 2.0 / 3.0 * (3.0 * load * span**4 / (64.0 * stiffness)) ** (1.0 / 3.0)


def swing(mesher: Mesher, seed: int) -> float:
    """Period, s, of 0.5 m x 1 m that hangs by its short upper edge and was let go 0.05 rad off the vertical."""
    mesh = mesher(0.5, 1.0, seed)
    solver = ClothSolver(mesh, Material(**FABRIC, stretch_limit=1.2), VACUUM)
    solver.pin(on_edge(mesh, 1, 1.0))
    x, y, _ = mesh.rest_position.T
    down = y - y.max()
    start = np.ascontiguousarray(np.stack([x, -0.05 * down, down * math.cos(0.05)], axis=1))
    run = states(solver, State(start, np.zeros_like(start)), Inputs(), 6.0)
    times, across = np.array([(s.time, mean_over_area(mesh, s.position[:, 1])) for s in run]).T
    return period(times, across)


def drape(mesher: Mesher, seed: int) -> float:
    """Drape coefficient after Cusick, of a square: the share of what overhangs that its shadow still covers.

    Vertices above the pedestal are held; where the cloth lies on it, up to half a cell, and how uneven it is at first
    are drawn. As in the laboratory it is bounced until its folds have settled: else it may rest in shapes with fewer
    of them, which are in equilibrium too.
    """
    mesh = mesher(SQUARE, SQUARE, seed)
    solver = ClothSolver(mesh, Material(**FABRIC, damping=3.0, stretch_limit=1.2), VACUUM)
    random = np.random.default_rng(seed)
    flat = mesh.rest_position[:, :2]
    center = random.uniform(-0.5, 0.5, 2) * spacing(mesh)
    solver.pin(np.flatnonzero(np.linalg.norm(flat - center, axis=1) < PEDESTAL))
    state = solver.initial_state()
    free = np.setdiff1d(np.arange(mesh.vertex_count), solver.pinned)
    wave, phase = random.uniform(-60.0, 60.0, (8, 2)), random.uniform(0.0, 2.0 * math.pi, 8)
    state.position[free, 2] += NOISE * np.sin(flat[free] @ wave.T + phase).mean(axis=1)
    beat = random.uniform(0.0, 2.0 * math.pi, 3)
    while state.time < 4.0:
        state = solver.step(state, Inputs(gravity=_bouncing(state.time, beat)))
    covered, disc = shadow_area(state.position, mesh.triangles), math.pi * PEDESTAL**2
    return (covered - disc) / (SQUARE**2 - disc)


def _bouncing(time: float, beat: np.ndarray) -> tuple[float, float, float]:
    """m/s^2: gravity felt on a pedestal that is shaken, up and down above all, ever less for two seconds."""
    fading = GRAVITY * max(0.0, 1.0 - time / 2.0)
    x, y, z = np.sin(2.0 * math.pi * np.array([2.3, 3.1, 4.1]) * time + beat)
    return fading * x, fading * y, 2.0 * fading * z - GRAVITY


def strip_frequency(mesher: Mesher, seed: int) -> float:
    """Hz of the lowest mode, mostly a parabola along x, of a free strip of 0.6 m x 0.15 m that only bends."""
    mesh, material = mesher(0.6, 0.15, seed), Material(**FABRIC)
    mass, x = mesh.vertex_mass(material), mesh.rest_position[:, 0]
    square, shapes = eigh(bending_matrix(mesh, material).toarray(), np.diag(mass), subset_by_index=[0, 9])
    parabola = x**2 - mass @ x**2 / mass.sum()
    share = (mass * parabola @ shapes) ** 2 / (mass @ parabola**2)
    return float(np.sqrt(square[np.argmax(share > 0.8)])) / (2.0 * math.pi)


def frequency_of_a_beam(length: float = 0.6) -> float:
    """Hz, in closed form: 22.373 sqrt(B / sigma) / L^2."""
    return 22.373 * math.sqrt(FABRIC["bend"] / FABRIC["areal_density"]) / length**2 / (2.0 * math.pi)
