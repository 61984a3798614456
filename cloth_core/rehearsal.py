"""A rehearsal: everything that may happen to a cloth happens to a small one, before it counts.

numba compiles a kernel when it is called for the first time, or loads it if it is cached: seconds or tens of
milliseconds that a running simulation does not have when a hand closes, or a thread is about to tear. What is compiled
depends on the types of the arguments alone. So a handful of steps of a miniature of the same kind does it beforehand,
whatever the size of the cloth, and through the same code that will call the kernels later.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.fields import Compound
from cloth_core.fluids import Fluid
from cloth_core.inputs import Grasp, Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere
from cloth_core.pose import Pose
from cloth_core.report import StepReport
from cloth_core.state import State

SIDE = {False: 6, True: 20}
"""Vertices along an edge, by whether panels shall be large enough for single precision."""
SPACING = 0.02
"""m between neighbours."""
OBSTACLES: dict[str, Obstacle] = {
    "plane": Plane(center=(0.0, 0.0, -0.02)),
    "sphere": Sphere(radius=0.02),
    "box": Box(extents=(0.02, 0.02, 0.02), center=(0.03, 0.0, 0.0)),
    "capsule": Capsule(radius=0.01, length=0.02, center=(0.0, 0.03, 0.0)),
    "ellipsoid": Ellipsoid(radii=(0.02, 0.01, 0.01), center=(0.03, 0.03, 0.0)),
}
FIELD_OBSTACLE = Compound(
    parts={"block": Box(extents=(0.03, 0.02, 0.02))},
    voxel=0.005,
    center=(-0.02, -0.02, 0.0),
    orientation=(0.0, 0.3, 0.0, 0.9),
)
PATIENCE = {"one": 0.0, "other": 10.0}
"""The hands, and how far from the cloth's end each may be before it loses it, m: one slips, the other is held back."""


@dataclass(frozen=True)
class Act:
    """One step: how far the hands are ``away`` to either side, m, whether ``closed``, what happens to the cloth.

    It may be ``torn`` to twice its size, or laid together, ``crossed`` or not, and ``thrown`` upon itself, m/s.
    """

    away: float
    closed: bool
    torn: bool = False
    thrown: float = 0.0
    crossed: bool = False


ACTS = (Act(0.0, False), Act(0.0, True), Act(5.0, True), Act(5.0, True, torn=True), Act(5.0, False))
LAYERED = (*ACTS, Act(0.0, False, thrown=2.0), Act(0.0, False, thrown=400.0), Act(0.0, False, thrown=1.0, crossed=True))


@dataclass(frozen=True)
class Kind:
    """All that decides which types kernels meet.

    Args:
        integrator: by name.
        cloth: ``grid`` (springs of a flat sheet), ``sheet`` (triangles) or ``net`` (springs of anything else).
        single: whether W is kept in single precision.
        fields: whether obstacles are distance fields.
        layered: whether the cloth collides with itself.
    """

    integrator: str
    cloth: str
    single: bool
    fields: bool = False
    layered: bool = False


def kinds(
    mesh: ClothMesh, material: Material, config: SolverConfig, precisions: frozenset[np.dtype], fields: bool
) -> Iterator[Kind]:
    """What a solver has to rehearse: one kind for each of the ``precisions`` that its operators are kept in."""
    cloth = "sheet" if mesh.is_membrane(material) else "grid" if len(mesh.triangle_slope) else "net"
    for single in sorted(precision == np.float32 for precision in precisions):
        yield Kind(config.integrator, cloth, single, fields, config.self_collision)


@functools.cache
def rehearse(kind: Kind, build: Callable[..., Any]) -> tuple[StepReport, ...]:
    """Play the miniature of a ``kind``, once in a process; ``build`` is :class:`~cloth_core.solver.ClothSolver`.

    A wind blows, water stands, obstacles move through the cloth, two hands close and go off too far and too fast: one
    loses it, the other is held back. The cloth is torn to twice its size, and the hand opens.

    Returns:
        What each step reported.
    """
    mesh = _miniature(kind)
    config = SolverConfig(
        integrator=kind.integrator, dt=0.005, iterations=2, dense_limit=5000, self_collision=kind.layered
    )
    around = {**OBSTACLES, "field": FIELD_OBSTACLE} if kind.fields else OBSTACLES
    solver = build(mesh, Material(friction=0.4), config, obstacles=around)
    solver.pin([0, 1])  # neighbours: the thread between them is what nothing but a weld can keep from tearing
    state, reports = solver.initial_state(), []
    ends = mesh.rest_position[-1], mesh.rest_position[SIDE[kind.single] - 1]
    for number, act in enumerate(LAYERED if kind.layered else ACTS):
        if act.torn:
            state = replace(state, position=2.0 * state.position)
        if act.thrown:
            state = _thrown(solver.initial_state(), act)
        state = solver.step(state, _inputs(act, ends, around, 1e-3 * number))
        reports.append(solver.report)
    return tuple(reports)


def _inputs(act: Act, ends: tuple[np.ndarray, ...], around: Mapping[str, Obstacle], shift: float) -> Inputs:
    """What an ``act`` wants of hands at the ``ends`` of the cloth; what is ``around`` is ``shift`` m from its place."""
    poses = [
        Pose(tuple(end)).shifted(np.array([0.0, way, 0.0]))
        for end, way in zip(ends, (act.away, -act.away), strict=True)
    ]
    grasps = {
        name: Grasp(pose=pose, closure=float(act.closed), slip_distance=slip)
        for (name, slip), pose in zip(PATIENCE.items(), poses, strict=True)
    }
    wind = Wind(velocity=(1.0, 0.0, 0.0), gust_intensity=0.1)
    obstacles = {name: shape.pose.shifted(np.array([shift, 0.0, 0.0])) for name, shape in around.items()}
    fluids = {"water": Fluid(shape=Box(extents=(0.02, 0.02, 0.02), center=(-0.03, 0.0, 0.0)))}
    return Inputs(grasps=grasps, wind=wind, fluids=fluids, obstacles=obstacles)


def _thrown(state: State, act: Act) -> State:
    """A cloth laid together whose upper half flies down, or has one end in the other half already."""
    place, velocity = state.position.copy(), state.velocity.copy()
    upper = place[:, 0] > 0.0
    place[upper] += (0.0, 0.3 * SPACING, 0.1 * SPACING)
    place[upper, 0] *= -1.0
    place[upper, 2] += act.crossed * 0.5 * place[upper, 1]
    velocity[upper, 2] = -act.thrown
    return replace(state, position=place, velocity=velocity)


def _miniature(kind: Kind) -> ClothMesh:
    side = SIDE[kind.single]
    grid = ClothMesh.grid(width=SPACING * side, height=SPACING * side, columns=side, rows=side)
    if kind.cloth == "grid":
        return grid
    if kind.cloth == "net":
        return ClothMesh.from_springs(
            grid.rest_position, grid.spring_vertex, stiffness=100.0, mass=1e-4, triangles=grid.triangles
        )
    bowed = grid.rest_position.copy()  # so that ways over its surface are longer than straight ones
    bowed[:, 2] = bowed[:, 0] ** 2 / (SPACING * side)
    return ClothMesh.from_triangles(bowed, grid.triangles)
