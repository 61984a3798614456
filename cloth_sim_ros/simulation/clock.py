"""When steps are due: on absolute deadlines of the machine's clock, or in step with one that others drive."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

COARSE_NS = 2_000_000
STAMP_TOLERANCE_NS = 1_000_000


@dataclass(frozen=True)
class Slot:
    """The time that one step has.

    Args:
        stamp_ns: ROS time of the slot.
        begin_ns: monotonic ns at which it began, or None where no wall clock presses.
        duration_ns: ns until the next one.
        restarted: the clock jumped back; a new episode begins here.
    """

    stamp_ns: int
    begin_ns: int | None
    duration_ns: int
    restarted: bool = False

    def out_of_time(self, budget: float) -> Callable[[], bool] | None:
        """Tells whether the share ``budget`` of the slot is over; None where time does not press."""
        if self.begin_ns is None:
            return None
        end = self.begin_ns + int(budget * self.duration_ns)
        return lambda: time.monotonic_ns() > end

    def is_over(self) -> bool:
        """Whether the next slot has begun."""
        return self.begin_ns is not None and time.monotonic_ns() > self.begin_ns + self.duration_ns


class Pace(Protocol):
    """Hands out one slot after the other."""

    skipped: int
    """Slots that were left out: by so many steps simulated time lags."""

    def wait(self) -> Slot | None:
        """Block until the next slot begins; None if :meth:`wake` was called first."""

    def wake(self) -> None:
        """Let :meth:`wait` return, from another thread."""


class WallPace:
    """Slot k begins at start + k * dt, whatever the steps before took.

    A step that overruns delays the next one, and slots that passed entirely meanwhile are skipped:
    simulated time then lags, by steps of the same dt.

    Args:
        dt_ns: ns from slot to slot.
        ros_now: the ROS time in ns. Stamps keep to the grid unless the two clocks drift by more than 1 ms.
    """

    def __init__(self, dt_ns: int, ros_now: Callable[[], int]) -> None:
        self.skipped = 0
        self._dt = dt_ns
        self._ros_now = ros_now
        self._woken = threading.Event()
        self._start = time.monotonic_ns()
        self._offset = ros_now() - time.monotonic_ns()
        self._index = 0

    def wait(self) -> Slot | None:
        """Block until the next slot begins; None if :meth:`wake` was called first."""
        passed = (time.monotonic_ns() - self._start) // self._dt
        index = max(self._index + 1, passed)
        self.skipped += index - self._index - 1
        self._index = index - 1
        begin = self._start + index * self._dt
        if not self._sleep_until(begin):
            return None
        self._index = index
        self._follow_ros_clock()
        return Slot(begin + self._offset, begin, self._dt)

    def wake(self) -> None:
        """Let :meth:`wait` return, from another thread."""
        self._woken.set()

    def _sleep_until(self, begin: int) -> bool:
        while not self._woken.is_set():
            left = begin - time.monotonic_ns()
            if left <= 0:
                return True
            if left > COARSE_NS:
                self._woken.wait((left - COARSE_NS // 2) * 1e-9)
            else:
                time.sleep(left * 1e-9)
        self._woken.clear()
        return False

    def _follow_ros_clock(self) -> None:
        before = time.monotonic_ns()
        offset = self._ros_now() - before
        undisturbed = time.monotonic_ns() - before < STAMP_TOLERANCE_NS // 4
        if undisturbed and abs(offset - self._offset) > STAMP_TOLERANCE_NS:
            self._offset = offset


class ClockPace:
    """One slot for every dt that a clock driven by others (``/clock``) advances; none is ever skipped.

    The first time that comes is the start of the episode; a time before the last one starts a new one.

    Args:
        dt_ns: ns of that clock from slot to slot.
    """

    skipped = 0

    def __init__(self, dt_ns: int) -> None:
        self._dt = dt_ns
        self._changed = threading.Condition()  # guards everything below
        self._start: int | None = None
        self._now = 0
        self._index = 0
        self._restarted = False
        self._woken = False

    def advance(self, now_ns: int) -> None:
        """Tell the time in ns, whenever it changes; 0 means that it is not known yet."""
        with self._changed:
            if now_ns == 0:
                return
            if self._start is None or now_ns < self._now:
                self._restarted = self._start is not None
                self._start, self._index = now_ns, 0
            self._now = now_ns
            self._changed.notify()

    @property
    def waiting_for_clock(self) -> bool:
        """Whether nobody has told the time yet."""
        return self._start is None

    def wait(self) -> Slot | None:
        """Block until the next slot begins; None if :meth:`wake` was called first."""
        with self._changed:
            self._changed.wait_for(lambda: self._woken or self._is_due())
            if self._woken or self._start is None:
                self._woken = False
                return None
            self._index += 1
            restarted, self._restarted = self._restarted, False
            return Slot(self._start + self._index * self._dt, None, self._dt, restarted)

    def wake(self) -> None:
        """Let :meth:`wait` return, from another thread."""
        with self._changed:
            self._woken = True
            self._changed.notify()

    def _is_due(self) -> bool:
        return self._start is not None and self._now >= self._start + (self._index + 1) * self._dt


class Rhythm:
    """How regularly steps were published, over the last few seconds."""

    def __init__(self, window: int = 500) -> None:
        self.missed = 0
        """Frames published after the next slot had begun."""
        self._step_seconds: deque[float] = deque(maxlen=window)
        self._published: deque[int] = deque(maxlen=101)

    def note(self, slot: Slot, step_seconds: float) -> None:
        """Count a frame that has just been published."""
        self.missed += slot.is_over()
        self._step_seconds.append(step_seconds)
        self._published.append(time.monotonic_ns())

    def forget(self) -> None:
        """Begin anew, after a pause."""
        self._published.clear()

    @property
    def rate(self) -> float:
        """Hz over the last 100 frames; 0 if there was none for a second."""
        published = list(self._published)
        if len(published) < 2 or time.monotonic_ns() - published[-1] > 1e9:
            return 0.0
        return (len(published) - 1) * 1e9 / (published[-1] - published[0])

    def step_time_ms(self, percent: float) -> float:
        """Percentile of the step time in ms, over the last 500 steps; 0 before the first."""
        seconds = list(self._step_seconds)
        return 1e3 * float(np.percentile(seconds, percent)) if seconds else 0.0
