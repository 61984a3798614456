"""W along threads and inertia across them: kernels against linear algebra, and cloth that buckles as finer steps do."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, SolverConfig
from cloth_core.obstacles import Obstacle, Plane, Sphere
from cloth_core.physics.along import AlongThreads
from cloth_core.physics.membrane import Membrane
from cloth_core.physics.springs import Springs
from cloth_core.pose import Pose

SEEDS = st.integers(0, 2**32 - 1)
SCALE = 1e-6
"""s^2"""


def crumpled(random: np.random.Generator, mesh: ClothMesh) -> np.ndarray:
    """(V, 3) m, stretched here and pressed there."""
    return mesh.rest_position * random.uniform(0.9, 1.2) + random.normal(0.0, 0.004, mesh.rest_position.shape)


def sheet(seed: int, *, woven: bool) -> tuple[np.random.Generator, ClothMesh, Springs | Membrane, np.ndarray]:
    """Of springs or triangles, and a tension of each limit."""
    random = np.random.default_rng(seed)
    mesh = ClothMesh.grid(width=0.15, height=0.12, columns=5, rows=4)
    material = Material(stretch_warp=random.uniform(100.0, 2000.0))
    if not woven:
        made, count = Springs(mesh, material), len(mesh.spring_rest)
        return random, mesh, made, random.uniform(0.0, 20.0, count) * (random.random(count) < 0.5)
    mesh = ClothMesh.from_triangles(mesh.rest_position, mesh.triangles)
    shape = len(mesh.triangles), 2
    return random, mesh, Membrane(mesh, material), random.uniform(0.0, 0.01, shape) * (random.random(shape) < 0.5)


@settings(max_examples=10, deadline=None)
@given(SEEDS, st.booleans())
def test_what_resists_is_more_than_how_forces_change_and_along_threads_no_more(seed, woven):
    """Of what a move of the cloth changes in its forces. What is pressed helps it along, and counts as if it pulled."""
    random, mesh, made, tension = sheet(seed, woven=woven)
    x = crumpled(random, mesh)
    vertices = mesh.vertex_count
    along, across = np.zeros((vertices, 6)), np.zeros(vertices)
    made.add_resistance(x, tension, SCALE, along, across)

    def force(place: np.ndarray) -> np.ndarray:
        pushed, apart = np.zeros_like(x), 0.0
        made.add_impulses(place, place, tension, apart, SCALE, pushed)
        return pushed

    for _ in range(5):
        v, way = random.integers(vertices), random.normal(size=3)
        way /= np.linalg.norm(way)
        moved = np.zeros_like(x)
        moved[v] = 1e-7 * way
        needed = (force(x - moved) - force(x + moved))[v] @ way / 2e-7
        borne = way @ twins.tensors(along)[v] @ way
        assert needed <= (borne + across[v]) * (1.0 + 1e-4)
    moved = 1e-7 * random.normal(size=x.shape)
    needed = np.sum((force(x - moved) - force(x + moved)) * moved) / 2.0
    # The stiffness along threads is that of each vertex alone; of a move of all of them it is at most so many times.
    borne = (3 if woven else 2) * np.einsum("va,vab,vb->", moved, twins.tensors(along), moved)
    assert needed <= (borne + across @ (moved**2).sum(axis=1)) * (1.0 + 1e-4)


@settings(max_examples=10, deadline=None)
@given(SEEDS, st.booleans())
def test_threads_are_pushed_through_w_and_across_them_against_their_inertia(seed, woven):
    random, mesh, made, tension = sheet(seed, woven=woven)
    x, mass = crumpled(random, mesh), random.uniform(1e-4, 1e-3, mesh.vertex_count)
    half = random.normal(size=(len(mass), len(mass)))
    w = np.linalg.inv(np.diag(mass) + 1e-3 * half @ half.T)

    def solve(push: np.ndarray, result: np.ndarray) -> None:
        result[:] = w @ push

    spread = AlongThreads(made, mass, solve)
    spread.look(x, tension, SCALE)
    push, found = random.normal(size=x.shape), np.zeros_like(x)

    along, across = np.zeros((len(mass), 6)), np.zeros(len(mass))
    made.add_resistance(x, tension, SCALE, along, across)
    expected = twins.spread_along(lambda push: w @ push, push, twins.tensors(along), across, mass)
    way = np.linalg.norm(expected, axis=1)
    farthest = np.median(way)
    expected *= np.minimum(1.0, farthest / way)[:, None]
    spread.solve(push, found, farthest)
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())


def heights(columns: int, substeps: int, seconds: float) -> np.ndarray:
    """Mean height, m, at the end of every frame, of a square metre that falls on a ball from 25 cm above it."""
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=columns, rows=columns)
    obstacles: dict[str, Obstacle] = {"ball": Sphere(radius=0.25, center=(0.0, 0.0, 0.25)), "floor": Plane()}
    solver = ClothSolver(mesh, Material(), SolverConfig(substeps=substeps), obstacles=obstacles)
    state, found = solver.initial_state(Pose((0.03, 0.02, 0.75))), []
    for _ in range(round(seconds / 0.02)):
        state = solver.step(state, Inputs())
        found.append(state.position[:, 2].mean())
    return np.array(found)


@pytest.mark.parametrize("columns", [20, 40])
def test_cloth_that_falls_on_a_ball_buckles_at_once(columns):
    """Flat, it would store the blow in its threads and spring back; a hundred substeps a frame tell what is true."""
    shipped, true = heights(columns, 0, 0.6), heights(columns, 100, 0.6)
    assert np.abs(shipped - true).max() < 0.055
    assert np.sqrt(np.mean((shipped - true) ** 2)) < 0.025
