"""What a step tells of itself."""

from __future__ import annotations

from dataclasses import dataclass


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
        slowed: grasps that moved faster than they are followed.
        taut: grasps that are not followed because the cloth between them and the next is at its limit.
        slips: grasps that lost the cloth in this step, for they asked for more of it than there is, or had to bear
            more than ``max_grasp_force``.
        empty: grasps that closed in this step and had no vertex within their radius.
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
    restrained: int = 0
    recovered: bool = False

    @property
    def slipped(self) -> tuple[str, ...]:
        """Names of the grasps that lost the cloth in this step, sorted."""
        return tuple(slip.name for slip in self.slips)
