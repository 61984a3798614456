"""Nothing passes through what is thin, however fast: plates, rods and needles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig
from cloth_core.fields import Compound
from cloth_core.obstacles import Box, Capsule, Obstacle

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
ALONG_X = (0.0, 0.5**0.5, 0.0, 0.5**0.5)
PLATE = Box(extents=(1.0, 0.3, 0.01))
ROD = Capsule(radius=0.002, length=1.2, orientation=ALONG_X)
NEEDLE = Capsule(radius=0.0005, length=0.4, center=(0.004, 0.007, -0.2))
FIELD_PLATE = Compound(parts={"plate": PLATE}, voxel=0.01)
FIELD_ROD = Compound(parts={"rod": replace(ROD, orientation=UPRIGHT)}, voxel=0.004, orientation=ALONG_X)
CONFIG = SolverConfig(air_density=0.0, max_obstacle_speed=100.0)


def stage(shape: Obstacle, integrator: str) -> ClothSolver:
    mesh = ClothMesh.grid(width=0.6, height=0.6, columns=30, rows=30)
    return ClothSolver(mesh, Material(), replace(CONFIG, integrator=integrator), obstacles={"it": shape})


def crossed(x: np.ndarray, triangles: np.ndarray, begin: np.ndarray, end: np.ndarray) -> int:
    """Triangles that a straight line from ``begin`` to ``end`` passes through (Moeller and Trumbore 1997)."""
    corner, along = x[triangles], end - begin
    one, two, off = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0], begin - corner[:, 0]
    across = np.cross(np.broadcast_to(along, two.shape), two)
    volume = (one * across).sum(axis=1)
    volume[np.abs(volume) < 1e-300] = np.inf
    up = np.cross(off, one)
    u, v, t = (off * across).sum(axis=1) / volume, up @ along / volume, (two * up).sum(axis=1) / volume
    return int(((u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1) & np.isfinite(volume)).sum())


def pierced(solver: ClothSolver, x: np.ndarray, pose: Pose) -> int:
    """Triangles that the core of the obstacle passes through: the axis of a rod, the long diagonals of a plate."""
    shape = solver.obstacles["it"]
    if isinstance(shape, Compound):
        (shape,) = shape.parts.values()
    if isinstance(shape, Capsule):
        half = np.array([[0.0, 0.0, 0.5 * shape.length]])
        lines = [(-half, half)]
    else:
        half = 0.5 * np.array(shape.extents) * [1.0, 1.0, 0.0]
        lines = [(-half[None], half[None]), (half[None] * [-1.0, 1.0, 1.0], half[None] * [1.0, -1.0, 1.0])]
    triangles = solver.mesh.triangles
    return sum(crossed(x, triangles, pose.apply(begin)[0], pose.apply(end)[0]) for begin, end in lines)


@pytest.mark.parametrize(
    ("shape", "integrator"),
    [
        pytest.param(PLATE, "implicit_midpoint", id="plate"),
        pytest.param(ROD, "implicit_midpoint", id="rod"),
        pytest.param(NEEDLE, "implicit_midpoint", id="needle"),
        pytest.param(PLATE, "meyer2000", id="plate-meyer2000"),
        pytest.param(FIELD_PLATE, "implicit_midpoint", id="field-plate"),
        pytest.param(FIELD_ROD, "implicit_midpoint", id="field-rod"),
        pytest.param(FIELD_PLATE, "meyer2000", id="field-plate-meyer2000"),
    ],
)
def test_a_cloth_thrown_at_10_m_s_stays_on_its_side(shape, integrator):
    """It travels 25 mm in a substep of the default, 200 mm in one of the paper's, and its cells measure 20 mm."""
    solver = stage(shape, integrator)
    state = solver.initial_state(Pose((0.0, 0.0, 0.3)))
    state = replace(state, velocity=np.tile([0.0, 0.0, -10.0], (solver.mesh.vertex_count, 1)))
    touched = 0
    for _ in range(20):
        state = solver.step(state, Inputs(gravity=(0.0, 0.0, 0.0)))
        touched = max(touched, solver.report.contacts)
        assert pierced(solver, state.position, state.obstacles["it"]) == 0
    assert touched > 0


@pytest.mark.parametrize(
    ("shape", "speed"),
    [
        pytest.param(ROD, 10.0, id="rod-10"),
        pytest.param(ROD, 30.0, id="rod-30"),
        pytest.param(PLATE, 10.0, id="plate-10"),
        pytest.param(PLATE, 30.0, id="plate-30"),
        pytest.param(FIELD_ROD, 10.0, id="field-rod-10"),
        pytest.param(FIELD_ROD, 30.0, id="field-rod-30"),
    ],
)
def test_what_is_swung_at_a_hanging_cloth_takes_it_along(shape, speed):
    solver = stage(shape, "implicit_midpoint")
    solver.pin(solver.mesh.group("top"))
    state = solver.initial_state(Pose((0.0, 0.0, 0.3)))
    lifted = 0.0
    for n in range(1, 21):
        pose = Pose((0.0, 0.0, min(speed * 0.02 * n, 0.6)), shape.orientation)
        state = solver.step(state, Inputs(gravity=(0.0, 0.0, 0.0), obstacles={"it": pose}))
        lifted = max(lifted, state.position[:, 2].max() - 0.3)
        assert pierced(solver, state.position, pose) == 0
    assert lifted > 0.01 or speed > 20.0  # through all of the cloth within a frame; it may be let through


def test_edges_of_the_cloth_rest_on_edges_of_a_table():
    """Between two vertices on either side of a table's edge it would cut 5 mm deep."""
    table = Box(extents=(0.3, 0.3, 0.2))
    mesh = ClothMesh.grid(width=0.6, height=0.6, columns=20, rows=20)
    config = SolverConfig()
    solver = ClothSolver(mesh, Material(damping=2.0), config, obstacles={"table": table})
    state = solver.initial_state(Pose((0.007, 0.004, 0.12)))
    for _ in range(100):
        state = solver.step(state, Inputs())
    corner = state.position[mesh.triangles]
    middles = 0.5 * (corner + np.roll(corner, 1, axis=1)).reshape(-1, 3)
    depth = (0.5 * np.array(table.extents) - np.abs(middles)).min(axis=1)
    assert depth.max() < 5e-4
    assert depth.max() > -1.01 * config.contact_shell  # it lies there
    assert state.position[:, 2].min() < 0.0  # and hangs over the edge
