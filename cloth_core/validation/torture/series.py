"""A series of episodes: how it runs, what it says meanwhile, and the tables at its end."""

from __future__ import annotations

import itertools
import math
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TextIO

from cloth_core.validation.torture.abuse import ABUSES
from cloth_core.validation.torture.contract import Breach
from cloth_core.validation.torture.episode import DEFAULT_INTEGRATOR, LARGEST, Episode, draw
from cloth_core.validation.torture.play import Outcome, play


@dataclass(frozen=True)
class Series:
    """Episodes 1, 2, 3, ... of a seed; the same, whatever the speed of the machine.

    Args:
        seed: at least 0.
        integrator: for all of them, instead of what each draws.
        abuses: for all of them, instead of what each draws.
        largest: most vertices a side of a cloth.
    """

    seed: int = 0
    integrator: str | None = None
    abuses: tuple[str, ...] = ()
    largest: int = LARGEST

    def run(self, *, minutes: float, only: int | None = None) -> list[Outcome]:
        """Play for ``minutes`` of wall-clock time and finish the episode begun; or play the episode ``only``.

        Failures are printed as they come, progress goes to standard error. Ctrl-C ends the series where it is.
        """
        progress = Progress(minutes * 60.0, sys.stderr)
        outcomes: list[Outcome] = []
        numbers = itertools.count(1) if only is None else [only]
        try:
            for number in numbers:
                outcomes.append(play(self.episode(number), progress.each_step))
                progress.finished(outcomes[-1], self.command(outcomes[-1]))
                if progress.over:
                    break
        except KeyboardInterrupt:
            pass
        progress.clear()
        return outcomes

    def episode(self, number: int) -> Episode:
        """Episode ``number``, from 1."""
        return draw(self.seed, number, integrator=self.integrator, abuses=self.abuses, largest=self.largest)

    def command(self, outcome: Outcome) -> str:
        """The command that plays an episode of this series again, alone."""
        words = ["cloth_validate --torture 1", f"--seed {self.seed}", f"--episode {outcome.episode.number}"]
        words += [f"--integrator {self.integrator}"] if self.integrator else []
        words += [f"--abuse {name}" for name in self.abuses]
        words += [f"--largest {self.largest}"] if self.largest != LARGEST else []
        return " ".join(words)


class Progress:
    """One line that is overwritten on a terminal; elsewhere a line every ten seconds. Failures are printed for good."""

    def __init__(self, budget: float, stream: TextIO) -> None:
        self._budget, self._stream, self._in_place = budget, stream, stream.isatty()
        self._started = time.monotonic()
        self._shown = -math.inf if self._in_place else self._started
        self._episodes = self._failed = 0
        self._worst, self._simulated = -math.inf, 0.0

    @property
    def over(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() - self._started > self._budget

    def each_step(self, simulated: float) -> None:
        """Hear that an episode has come to ``simulated`` s; say something if it is time to."""
        now = time.monotonic()
        if now - self._shown >= (0.2 if self._in_place else 10.0):
            self._shown = now
            self._say(self._line(now, simulated))

    def finished(self, outcome: Outcome, command: str) -> None:
        """Count an episode; a failure is told at once."""
        self._episodes += 1
        self._simulated += outcome.duration
        if outcome.episode.strict:
            self._worst = max(self._worst, outcome.worst_excess)
        if not outcome.passed:
            self._failed += 1
            self.clear()
            print(describe(outcome, command), flush=True)

    def clear(self) -> None:
        """Take the line away."""
        if self._in_place:
            self._stream.write("\r\033[K")
            self._stream.flush()

    def _line(self, now: float, simulated: float) -> str:
        worst = f"{self._worst:+.3f}" if self._episodes and math.isfinite(self._worst) else "none yet"
        return (
            f"{now - self._started:.0f} of {self._budget:.0f} s: {self._episodes} episodes, {self._failed} failed; "
            f"worst stretch over its limit {worst}; {(self._simulated + simulated) / 60.0:.1f} simulated minutes"
        )

    def _say(self, line: str) -> None:
        self._stream.write(f"\r\033[K{line}" if self._in_place else line + "\n")
        self._stream.flush()


def describe(outcome: Outcome, command: str) -> str:
    """A failed episode: what it was, what broke, and how to see it again."""
    head = f"episode {outcome.episode.number} FAILS: {outcome.episode}"
    return "\n".join([head, *(f"  {breach}" for breach in outcome.breaches), f"  {command}"])


def table(outcomes: Sequence[Outcome]) -> str:
    """Abuse by integrator: episodes it had a part in, how many broke which rule, and the worst stretch."""
    rows = [("abuse", "integrator", "episodes", "failed", "worst stretch over limit", "broken")]
    integrators = dict.fromkeys([DEFAULT_INTEGRATOR, *sorted({o.episode.config.integrator for o in outcomes})])
    for name in ABUSES:
        for integrator in integrators:
            chosen = [o for o in outcomes if name in o.episode.abuses and o.episode.config.integrator == integrator]
            if chosen:
                failed = [o for o in chosen if not o.passed]
                worst = max(o.worst_excess for o in chosen)
                counts = (str(len(chosen)), str(len(failed)), f"{worst:+.4f}")
                rows.append((name, integrator, *counts, _rules(b for o in failed for b in o.breaches)))
    widths = [max(len(row[column]) for row in rows) for column in range(6)]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def _rules(breaches: Iterable[Breach]) -> str:
    counts: dict[str, int] = {}
    for breach in breaches:
        counts[breach.rule] = counts.get(breach.rule, 0) + 1
    return ", ".join(f"{rule} {count}" for rule, count in counts.items())


def as_mapping(outcome: Outcome, command: str) -> dict[str, object]:
    """Plain values for JSON; None where a number is not finite."""
    return {
        "episode": outcome.episode.number,
        "what": str(outcome.episode),
        "integrator": outcome.episode.config.integrator,
        "abuses": list(outcome.episode.abuses),
        "passed": outcome.passed,
        "worst_excess": _finite(outcome.worst_excess),
        "duration_s": outcome.duration,
        "digest": outcome.digest,
        "command": command,
        "breaches": [
            {"rule": b.rule, "step": b.step, "time_s": b.time, "calm": b.calm, "unit": b.unit, "note": b.note}
            | {"figure": _finite(b.figure), "bound": _finite(b.bound)}
            for b in outcome.breaches
        ],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
