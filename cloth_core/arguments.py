"""What a step may be given: refused where it makes no sense, and brought into the one form that kernels know."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from cloth_core.errors import InputError
from cloth_core.inputs import Inputs
from cloth_core.state import State


def check_arguments(
    state: State,
    inputs: Inputs,
    sweeps: Sequence[int] | None,
    vertex_count: int,
    obstacles: Collection[str],
    substeps: int,
) -> None:
    """Refuse what :meth:`ClothSolver.step` cannot use.

    Args:
        state: of the cloth.
        inputs: of the step.
        sweeps: passes to repeat, one number for every substep, or None.
        vertex_count: of the cloth.
        obstacles: the names that there are.
        substeps: in a step.

    Raises:
        InputError: naming the vertices, the obstacles or the numbers.
    """
    if state.position.shape != (vertex_count, 3) or state.velocity.shape != state.position.shape:
        raise InputError(f"the state has {len(state.position)} vertices, this cloth {vertex_count}")
    wrong = np.flatnonzero(~(np.isfinite(state.position) & np.isfinite(state.velocity)).all(axis=1))
    if len(wrong):
        raise InputError(f"the state is not finite at vertices {wrong[:8].tolist()}")
    lost = set(obstacles) - state.obstacles.keys()
    if lost:
        names = ", ".join(sorted(lost))
        raise InputError(f"the state does not say where {names} stands: begin with initial_state()")
    unknown = inputs.obstacles.keys() - set(obstacles)
    if unknown:
        known = ", ".join(obstacles) or "none"
        raise InputError(f"no obstacle {', '.join(sorted(unknown))}; this scene has {known}")
    if sweeps is not None and len(sweeps) != substeps:
        raise InputError(f"{len(sweeps)} sweep counts for {substeps} substeps")
    if sweeps is not None and not all(isinstance(count, (int, np.integer)) and count >= 1 for count in sweeps):
        raise InputError(f"sweep counts {list(sweeps)[:8]} must be whole numbers of at least 1")


def with_plain_arrays(state: State) -> State:
    """The same state; positions and velocities that are not float64, row by row and writable are copied.

    Read-only arrays are another type to numba: a step from them would compile every kernel anew.
    """
    position, velocity = (np.require(array, np.float64, "CAW") for array in (state.position, state.velocity))
    if position is state.position and velocity is state.velocity:
        return state
    return replace(state, position=position, velocity=velocity)
