"""What brings a cloth upon itself: folded, crumpled, twisted, pulled through a ring."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig, State
from cloth_core.obstacles import Capsule, Obstacle, Plane, Sphere
from cloth_core.state import Grip

SIZE = 1.0
"""m, of the square cloth."""
DT = 0.02


@dataclass(frozen=True)
class Stage:
    """A scene ready to play.

    Args:
        solver: of the cloth.
        state: where it starts.
        inputs: at a time in s.
        duration: s.
    """

    solver: ClothSolver
    state: State
    inputs: Callable[[float], Inputs]
    duration: float

    def frames(self) -> int:
        """Steps in the scene."""
        return round(self.duration / DT)


def _solver(
    side: int, on: bool, obstacles: Mapping[str, Obstacle], height: float = SIZE, **material: float
) -> ClothSolver:
    mesh = ClothMesh.grid(width=SIZE, height=height, columns=side, rows=side)
    return ClothSolver(mesh, Material(**material), SolverConfig(dt=DT, self_collision=on), obstacles=obstacles)


def folded(side: int, on: bool) -> Stage:
    """One half lies on the floor, the other stands above it in a bow and falls."""
    solver, radius = _solver(side, on, {"floor": Plane()}, bend=1e-5), 0.05
    flat = solver.mesh.rest_position
    way = flat[:, 0] + 0.02  # along the cloth from the crease, which no line of vertices shall meet exactly
    turn = np.clip(way / radius, 0.0, math.pi)
    beyond = np.maximum(way - math.pi * radius, 0.0)
    place = flat.copy()
    place[:, 0] = np.where(way < 0.0, -way, beyond - radius * np.sin(turn))
    place[:, 2] = radius * (1.0 - np.cos(turn)) + 0.0051
    return Stage(solver, replace(solver.initial_state(), position=place), lambda time: Inputs(), 3.0)


def dropped(side: int, on: bool) -> Stage:
    """Over a ball that stands on the floor."""
    ball = Sphere(radius=0.15, center=(0.03, 0.02, 0.15))
    solver = _solver(side, on, {"ball": ball, "floor": Plane()})
    return Stage(solver, solver.initial_state(Pose((0.0, 0.0, 0.4))), lambda time: Inputs(), 3.0)


def twisted(side: int, on: bool) -> Stage:
    """A strip whose short edges are turned against each other, four turns in all, while they come closer."""
    solver = _solver(side, on, {}, height=0.3)
    state, mesh = solver.initial_state(), solver.mesh
    grips = {}
    for name in ("left", "right"):
        vertex = np.sort(mesh.group(name)).astype(np.int32)
        pose = Pose((float(mesh.rest_position[vertex[0], 0]), 0.0, 0.0))
        grips[name] = Grip(pose, True, vertex, pose.inverse_apply(mesh.rest_position[vertex]))

    def inputs(time: float) -> Inputs:
        turns, nearer = 2.0 * min(1.0, max(0.0, time - 1.0) / 4.0), min(0.1, 0.1 * time)
        nearer += 0.06 * min(4.0, max(0.0, time - 1.0))
        hands = {}
        for name, sign in (("left", -1.0), ("right", 1.0)):
            half = sign * math.pi * turns
            place = (sign * (0.5 * SIZE - nearer), 0.0, 0.0)
            hands[name] = Grasp(pose=Pose(place, (math.sin(half), 0.0, 0.0, math.cos(half))), closure=1.0, radius=0.01)
        return Inputs(grasps=hands)

    return Stage(solver, replace(state, grips=grips), inputs, 6.0)


def pulled(side: int, on: bool) -> Stage:
    """Grasped in the middle and pulled down through a ring of 16 capsules."""
    count, radius, thick = 16, 0.12, 0.02
    ring = {}
    for n in range(count):
        turn = 2.0 * math.pi * n / count
        half = 0.5 * (turn + 0.5 * math.pi)  # the axis of a capsule is z: laid over, then turned along the ring
        laid, around = math.sqrt(0.5), (math.cos(half), math.sin(half))
        ring[f"piece_{n}"] = Capsule(
            radius=thick,
            length=2.0 * radius * math.tan(math.pi / count),
            center=(radius * math.cos(turn), radius * math.sin(turn), 0.0),
            orientation=(-around[1] * laid, around[0] * laid, around[1] * laid, around[0] * laid),
        )
    solver = _solver(side, on, ring)

    def inputs(time: float) -> Inputs:
        place = (0.0, 0.0, 0.05 - 0.25 * max(0.0, time - 0.2))
        return Inputs(grasps={"hand": Grasp(pose=Pose(place), closure=1.0, radius=0.03)})

    return Stage(solver, solver.initial_state(Pose((0.0, 0.0, 0.05))), inputs, 4.0)


SCENES: dict[str, Callable[[int, bool], Stage]] = {
    "folded": folded,
    "dropped": dropped,
    "twisted": twisted,
    "pulled": pulled,
}
