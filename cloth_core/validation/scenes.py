"""Small helpers that the scenes of the laws share."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.inputs import Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.solver import ClothSolver
from cloth_core.state import State

GRAVITY = 9.81
NO_GRAVITY = Inputs(gravity=(0.0, 0.0, 0.0))
# Long enough that the limit never speaks: laws of elasticity and momentum are tried without it.
UNLIMITED = 10.0


def fine(integrator: str, **changes: object) -> SolverConfig:
    """Steps of 20 ms in ten substeps, in vacuum: the same 2 ms for both integrators."""
    return SolverConfig(**{"integrator": integrator, "dt": 0.02, "substeps": 10, "air_density": 0.0, **changes})  # type: ignore[arg-type]


def hanging_strip(length: float, rows: int) -> tuple[ClothMesh, np.ndarray]:
    """A narrow strip in the plane x = 0 that hangs down from z = 0, and its vertices at the top."""
    flat = ClothMesh.grid(width=0.1 * length, height=length, columns=2, rows=rows)
    x, y, _ = flat.rest_position.T
    position = np.stack([np.zeros_like(x), x, y - 0.5 * length], axis=1)
    return ClothMesh.from_triangles(position, flat.triangles, warp=(0.0, 0.0, 1.0)), flat.group("top")


def moving(solver: ClothSolver, velocity: np.ndarray) -> State:
    """The cloth in its rest shape with a ``velocity`` (3,) or (V, 3) m/s."""
    at_rest = solver.initial_state()
    speeds = np.array(np.broadcast_to(np.asarray(velocity, float), at_rest.position.shape))
    return State(at_rest.position, speeds, obstacles=at_rest.obstacles)


def states(solver: ClothSolver, state: State, inputs: Inputs, duration: float) -> Iterator[State]:
    """The state after every step of ``duration`` s."""
    for _ in range(round(duration / solver.config.dt)):
        state = solver.step(state, inputs)
        yield state


def last(solver: ClothSolver, state: State, inputs: Inputs, duration: float) -> State:
    """The state after ``duration`` s."""
    return deque(states(solver, state, inputs, duration), maxlen=1)[0]


def tumbling_sheet(integrator: str) -> tuple[ClothSolver, State]:
    """A free sheet, stretch limit off, thrown so that it spins, crumples and flies on."""
    mesh = ClothMesh.grid(width=1.0, height=0.7, columns=13, rows=10)
    solver = ClothSolver(mesh, Material(stretch_limit=UNLIMITED), SolverConfig(integrator=integrator, air_density=0.0))
    x, y, _ = mesh.rest_position.T
    spin = np.cross([1.0, 2.0, 3.0], mesh.rest_position)
    crumple = np.stack([np.sin(5 * y), np.cos(4 * x), np.sin(6 * x * y + 3 * x)], axis=1)
    return solver, moving(solver, spin + 0.5 * crumple + [0.5, -0.2, 1.0])


def angular_momentum(state: State, mass: np.ndarray) -> np.ndarray:
    """(3,) kg m^2/s about the centre of mass."""
    center = mass @ state.position / mass.sum()
    return mass @ np.cross(state.position - center, state.velocity)


def period(times: np.ndarray, swing: np.ndarray) -> float:
    """s: twice the mean distance of the zero crossings of ``swing``, each found by linear interpolation.

    Infinite for what crosses zero less than twice.
    """
    at = np.flatnonzero(swing[:-1] * swing[1:] < 0)
    crossing = times[at] + (times[at + 1] - times[at]) * swing[at] / (swing[at] - swing[at + 1])
    return 2.0 * float(np.diff(crossing).mean()) if len(crossing) > 1 else float("inf")
