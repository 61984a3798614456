"""Solvers of other parameters, made beside the one that steps."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from cloth_core import ClothError, ClothSolver, Material, SolverConfig


class Tuning:
    """Makes the solver of the newest wish in a thread of its own; wishes that are overtaken are left out.

    Args:
        solver: what is in force.
        ready: is called in that thread when :meth:`take` has something to give, or :attr:`problem` to say.
    """

    def __init__(self, solver: ClothSolver, ready: Callable[[], None]) -> None:
        self._solver = solver
        self._ready = ready
        self._lock = threading.Lock()  # guards everything below
        self._wish = self._made_for = (solver.material, solver.config)
        self._made: ClothSolver | None = None
        self._problem: ClothError | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="tuning")

    @property
    def wish(self) -> tuple[Material, SolverConfig]:
        """What is in force, or shall soon be."""
        with self._lock:
            return self._wish

    def want(self, material: Material, config: SolverConfig) -> None:
        """Have a solver made of these, unless something newer is wished for before its turn comes."""
        with self._lock:
            self._wish = (material, config)
        self._worker.submit(self._make)

    def take(self) -> ClothSolver | None:
        """The solver that was made last, once; None if there is no new one.

        Raises:
            ClothError: it cannot be made; what is wished for is what was in force before.
        """
        with self._lock:
            made, self._made = self._made, None
            problem, self._problem = self._problem, None
        if problem is not None:
            raise problem
        return made

    def close(self) -> None:
        """Wait for what is being made."""
        self._worker.shutdown(cancel_futures=True)

    def _make(self) -> None:
        with self._lock:
            wish = self._wish
            if wish == self._made_for:
                return
        material, config = wish
        try:
            self._solver = self._solver.changed(material=material, config=config)
        except ClothError as error:
            with self._lock:
                self._problem = error
                if self._wish == wish:
                    self._wish = self._made_for
        else:
            with self._lock:
                self._made, self._made_for = self._solver, wish
        self._ready()
