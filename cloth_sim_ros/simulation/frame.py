"""What the node shows of the cloth after a step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cloth_core import ClothMesh, Inputs, State, StepReport
from cloth_core.kernels import surface
from cloth_core.physics.rest_scale import RestShape
from cloth_core.physics.strain import vertex_strain


@dataclass(frozen=True, eq=False)
class Frame:
    """The cloth after one step.

    Args:
        step_index: steps since the start of the episode.
        time: s of simulated time.
        position: (V, 3) m.
        normal: (V, 3), unit, area-weighted; zero where there is no surface.
        strain: (V,) largest strain of the springs at the vertex.
        report: what the step did.
        inputs: what drove it.
        step_seconds: how long it took.
        state: the whole state.
        stale: grasps whose pose is older than the timeout; they are held where they were.
        pins: (P,) vertices that are pinned from this step on, if that was changed before it.
    """

    step_index: int
    time: float
    position: np.ndarray
    normal: np.ndarray
    strain: np.ndarray
    report: StepReport
    inputs: Inputs
    step_seconds: float
    state: State
    stale: tuple[str, ...] = ()
    pins: np.ndarray | None = None

    @property
    def digest(self) -> str:
        """Equal if and only if positions and velocities are bit-equal."""
        return self.state.digest

    @classmethod
    def of(
        cls,
        mesh: ClothMesh,
        state: State,
        report: StepReport,
        inputs: Inputs,
        seconds: float,
        rest: RestShape | None = None,
        **more: Any,
    ) -> Frame:
        """The frame of a ``state``, with its normals, and its strain over ``rest`` lengths; others are its fields."""
        area, normal = np.empty_like(state.position), np.empty_like(state.position)
        surface.area_vectors(state.position, mesh.triangles, area)
        surface.normals(area, normal)
        return cls(
            step_index=state.step_index,
            time=state.time,
            position=state.position,
            normal=normal,
            strain=vertex_strain(mesh, state.position, rest),
            report=report,
            inputs=inputs,
            step_seconds=seconds,
            state=state,
            **more,
        )
