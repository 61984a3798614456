"""The thread that steps the simulation, slot by slot, and does what must not happen during a step."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue
from typing import Any

from cloth_sim_ros.simulation.clock import Pace, Slot
from cloth_sim_ros.simulation.frame import Frame
from cloth_sim_ros.simulation.simulation import Simulation


class SimulationLoop:
    """Steps a simulation at a pace, in a thread of its own.

    Args:
        simulation: what is stepped.
        pace: when.
        deliver: gets every frame and its slot, in the loop's thread.
        failed: gets what a step or ``deliver`` raised; the loop goes on.
        restart: is called in the loop's thread when the clock jumped back.
        budget: share of a slot after which a step hurries up.
    """

    def __init__(
        self,
        simulation: Simulation,
        pace: Pace,
        *,
        deliver: Callable[[Frame, Slot], None],
        failed: Callable[[Exception], None],
        restart: Callable[[], None],
        budget: float = 0.8,
    ) -> None:
        self._simulation = simulation
        self._pace = pace
        self._deliver = deliver
        self._failed = failed
        self._restart = restart
        self.budget = budget
        self._orders: SimpleQueue[tuple[Callable[[], Any], Future[Any]]] = SimpleQueue()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulation", daemon=True)

    def start(self) -> None:
        """Begin to step."""
        self._thread.start()

    def stop(self) -> None:
        """End after the step at hand and wait for it; what was ordered until now is still done."""
        self._stopping.set()
        self._pace.wake()
        if self._thread.is_alive():
            self._thread.join()
        self._follow_orders()

    def do(self, action: Callable[[], Any]) -> Future[Any]:
        """Have ``action`` run between two steps; the future holds what it returns or raises."""
        future: Future[Any] = Future()
        self._orders.put((action, future))
        self._pace.wake()
        return future

    def _run(self) -> None:
        while not self._stopping.is_set():
            slot = self._pace.wait()
            self._follow_orders()
            if slot is None:
                continue
            try:
                if slot.restarted:
                    self._restart()
                if not self._simulation.paused:
                    self._deliver(self._simulation.tick(time.monotonic(), slot.out_of_time(self.budget)), slot)
            except Exception as error:  # a cloth that stands still and says why beats a dead node
                self._failed(error)

    def _follow_orders(self) -> None:
        while True:
            try:
                action, future = self._orders.get_nowait()
            except Empty:
                return
            try:
                future.set_result(action())
            except Exception as error:
                future.set_exception(error)
