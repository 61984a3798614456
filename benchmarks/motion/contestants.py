"""Who is compared: an integrator, a way to spend the solves of a substep, and how many there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from motion.integrators import Integrator, bdf2, implicit_euler, midpoint, sdirk2, trapezoidal
from motion.minimisers import anderson, chebyshev, lbfgs, local_global
from motion.stage import Minimiser
from motion.sweeps import with_sweeps

WINDOW = 5
"""Vectors that Anderson and L-BFGS remember."""

RADIUS = 0.3
"""For Chebyshev; with 0.5, four of nine splits of 10, 20 and 40 solves blew up within a second, with 0.9 all did."""


@dataclass(frozen=True)
class Contestant:
    """One line of the table.

    Args:
        name: as printed.
        integrator: from :mod:`motion.integrators`.
        minimiser: makes one from :mod:`motion.minimisers`, with no memory yet.
        iterations: solves in one stage; of several, the best for each budget counts.
        stages: stages in one step of the integrator.
        tweaks: what else :class:`~motion.stage.Stage` is told.
        ours: whether this is what the solver does.
    """

    name: str
    integrator: Integrator
    minimiser: Callable[[], Minimiser] = lambda: local_global
    iterations: tuple[int, ...] = (1,)
    stages: int = 1
    tweaks: Mapping[str, float] = field(default_factory=dict)
    ours: bool = False

    def substeps(self, solves: int, iterations: int) -> int:
        """Steps of the integrator in a frame of so many ``solves``."""
        return solves // (iterations * self.stages)


INTEGRATORS = (
    Contestant("implicit Euler", implicit_euler),
    Contestant("BDF2", bdf2),
    Contestant("SDIRK2", sdirk2, stages=2),
    Contestant("midpoint", midpoint, ours=True),
)
MINIMISERS = (
    Contestant("midpoint, iterated", midpoint, iterations=(2, 5)),
    Contestant("midpoint, Chebyshev", midpoint, lambda: chebyshev(RADIUS), iterations=(2, 5)),
    Contestant("midpoint, Anderson", midpoint, lambda: anderson(WINDOW), iterations=(2, 5)),
    Contestant("midpoint, L-BFGS", midpoint, lambda: lbfgs(WINDOW), iterations=(2, 5)),
    Contestant("midpoint, L-BFGS kept", midpoint, lambda: lbfgs(WINDOW, keep=True), iterations=(1, 2)),
    Contestant("BDF2, Anderson", bdf2, lambda: anderson(WINDOW), iterations=(2, 5)),
    Contestant("BDF2, L-BFGS kept", bdf2, lambda: lbfgs(WINDOW, keep=True), iterations=(1, 2)),
)
OTHERS = (
    Contestant("trapezoidal", trapezoidal),
    Contestant("midpoint, warm start 0.5", midpoint, tweaks={"warm": 0.5}),
    Contestant("midpoint, warm start 0.9", midpoint, tweaks={"warm": 0.9}),
    Contestant("midpoint, W for 0.8 K", midpoint, tweaks={"softer": 0.8}),
    Contestant("midpoint, W for 0.5 K", midpoint, tweaks={"softer": 0.5}),
    Contestant("midpoint, 2 sweeps", midpoint, lambda: with_sweeps(2)),
    Contestant("midpoint, 4 sweeps", midpoint, lambda: with_sweeps(4)),
    Contestant("BDF2, 2 sweeps", bdf2, lambda: with_sweeps(2)),
)
