"""What a step tells of itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Slip:
    """How a grasp lost the cloth.

    Args:
        name: of the grasp.
        beyond: m by which its hand was ahead of what the cloth gave, if that is why; else 0.
        load: N that it had to bear, if that is why; else 0.
    """

    name: str
    beyond: float = 0.0
    load: float = 0.0


def moment(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """(3,) N m, the sum of all products of ``arm`` (K, 3) m and ``force`` (K, 3) N."""
    both = np.einsum("ka,kb->ab", arm, force)
    return np.array([both[1, 2] - both[2, 1], both[2, 0] - both[0, 2], both[0, 1] - both[1, 0]])


@dataclass(frozen=True)
class Wrench:
    """A force and its moment, in the world's axes.

    Args:
        force: N.
        torque: N m, about the point that is said where the wrench stands.
    """

    force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    torque: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, force: np.ndarray, arm: np.ndarray) -> Wrench:
        """The resultant of forces (K, 3) N whose ``arm`` (K, 3) m is the way to them from the point of reference."""
        return cls(tuple(force.sum(axis=0).tolist()), tuple(moment(arm, force).tolist()))


@dataclass(frozen=True)
class StepReport:
    """What the last step did.

    Args:
        sweeps: passes over stretch limit and contacts, per substep; give them to ``step`` to repeat it exactly.
        residual: worst excess over the stretch limit met in the very last pass (a ratio).
        max_stretch: largest length over rest length of the limited springs. An edge that runs across the threads counts
            as if they had turned against each other as far as they can: it may be sqrt(1 + |sin 2a|) as long, at an
            angle a to the warp, on threads that are not stretched at all. 1 where no spring has a limit.
        contacts: pairs of vertex and obstacle in touch at the end.
        self_contacts: pairs of vertex and triangle, or of edges, of the cloth in touch in one of the substeps, at most.
        crossings: places where the cloth crossed itself at the beginning, twice for an edge of two triangles.
        held: vertices pinned or grasped.
        out_of_time: the caller's clock cut the passes short.
        wind_capped: the wind was faster than ``max_wind_speed``.
        teleported: obstacles that moved faster than ``max_obstacle_speed``.
        slowed: grasps, and groups as ``group/`` and their name, that moved faster than they are followed.
        taut: those that are not followed because the cloth between them and the next is at its limit.
        slips: grasps that lost the cloth in this step, for they asked for more of it than there is, or had to bear
            more than ``max_grasp_force``.
        empty: grasps that closed in this step and had no vertex within their radius.
        grasp_wrenches: what the cloth did to each hand, as a mean over the step: at rest the weight that it carries.
            Torques are about the origin of the pose that the grip has at the end; an empty hand feels nothing.
        pin_wrench: the same of all pins together, about the world's origin.
        obstacle_wrenches: what the cloth did to each obstacle, about the origin of the obstacle's frame.
        restrained: vertices that would have torn their threads, and moved with their neighbours instead.
        recovered: the result was not finite, or beyond all bounds, and was replaced by the state before, at rest.
    """

    sweeps: tuple[int, ...] = ()
    residual: float = 0.0
    max_stretch: float = 1.0
    contacts: int = 0
    self_contacts: int = 0
    crossings: int = 0
    held: int = 0
    out_of_time: bool = False
    wind_capped: bool = False
    teleported: tuple[str, ...] = ()
    slowed: tuple[str, ...] = ()
    taut: tuple[str, ...] = ()
    slips: tuple[Slip, ...] = ()
    empty: tuple[str, ...] = ()
    grasp_wrenches: Mapping[str, Wrench] = field(default_factory=dict)
    pin_wrench: Wrench = Wrench()
    obstacle_wrenches: Mapping[str, Wrench] = field(default_factory=dict)
    restrained: int = 0
    recovered: bool = False

    @property
    def slipped(self) -> tuple[str, ...]:
        """Names of the grasps that lost the cloth in this step, sorted."""
        return tuple(slip.name for slip in self.slips)
