"""Telling whoever waits that kernels are being compiled: the first start takes half a minute."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core import event


@contextmanager
def told(say: Callable[[int, str], None]) -> Iterator[None]:
    """While this lasts, call ``say(number, name)`` for each of our kernels that begins to compile.

    A kernel that lies compiled on disk, as all do after the first start, is loaded without a word. ``number`` counts
    from 1. ``say`` is called in the thread that compiles, and what it raises reaches that thread::

        with compiling.told(lambda number, name: print(f"compiling kernel {number}: {name}")):
            solver.prepare()
    """
    with event.install_listener("numba:compile", _Listener(say)):
        yield


class _Listener(event.Listener):
    def __init__(self, say: Callable[[int, str], None]) -> None:
        self._say, self._number = say, 0

    def on_start(self, begun: event.Event) -> None:
        function = begun.data["dispatcher"].py_func
        if function.__module__.startswith(f"{__package__}."):
            self._number += 1
            self._say(self._number, function.__name__)

    def on_end(self, ended: event.Event) -> None:
        pass
