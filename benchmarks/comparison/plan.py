"""Who takes part, and who runs what in which order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

SCENARIOS = ("hang", "drape", "drag", "selfcol")


@dataclass(frozen=True)
class Contestant:
    """An engine with one way of using it.

    Args:
        engine: its file is ``peers/bench_<engine>.py``.
        variant: as that file names it.
        scenarios: what it is run on.
        largest: most vertices a side it is run with.
        counted: whether it may be the fastest peer.
    """

    engine: str
    variant: str
    scenarios: tuple[str, ...] = ("hang", "drape", "drag")
    largest: int = 1000
    counted: bool = True

    @property
    def name(self) -> str:
        """Short, for tables and pictures."""
        return f"{self.engine} {self.variant}"

    @property
    def ours(self) -> bool:
        """Whether it is this package's."""
        return self.engine == "ours"


OURS = Contestant("ours", "default")
CONTESTANTS = (
    OURS,
    Contestant("ours", "meyer2000"),
    Contestant("fms", "scipy", counted=False),  # sixty lines of ours, not an engine: the lower bound of cost
    Contestant("pypbd", "xpbd"),
    Contestant("mujoco", "elastic", (*SCENARIOS,)),
    Contestant("mujoco", "ipc", ("drape", "selfcol"), largest=100),  # without contacts it is the elastic one
)
ENGINES = tuple(dict.fromkeys(contestant.engine for contestant in CONTESTANTS))


@dataclass(frozen=True)
class Job:
    """One contestant on one scenario with ``n`` x ``n`` vertices."""

    contestant: Contestant
    scenario: str
    n: int

    @property
    def title(self) -> str:
        """For the progress line."""
        return f"{self.scenario} {self.n:3d} {self.contestant.name}"


def jobs(engines: Sequence[str], scenarios: Sequence[str], sizes: Sequence[int]) -> Iterator[Job]:
    """One round. Contestants take turns on the same work, so that a slow minute of the machine hits all of them."""
    for n in sizes:
        for scenario in scenarios:
            for contestant in CONTESTANTS:
                takes_part = contestant.engine in engines and scenario in contestant.scenarios
                if takes_part and n <= contestant.largest:
                    yield Job(contestant, scenario, n)
