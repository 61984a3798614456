"""Whether threads may share the turns of a loop, which is whether Intel's TBB is there to hand them out.

TBB gives a turn to whoever is free: a thread that the machine has put aside delays nothing but its own turn. OpenMP,
numba's other choice, waits at the end of each loop for threads that had nothing to do, for milliseconds wherever
something else wants the core. ``NUMBA_NUM_THREADS=1``, or another ``NUMBA_THREADING_LAYER``, does without.
"""

from __future__ import annotations

import ctypes
import functools
from importlib import metadata

import numba

LIBRARY = "libtbb.so.12"
LAYERS = ("default", "tbb", "safe", "threadsafe", "forksafe")
"""Threading layers of numba that are TBB where TBB is found."""


@functools.cache
def shared() -> bool:
    """Whether TBB is there and more than one thread is wanted."""
    wanted = numba.config.NUMBA_NUM_THREADS > 1 and numba.config.THREADING_LAYER in LAYERS
    return wanted and any(_loads(path) for path in (*_installed(), LIBRARY))


def _installed() -> list[str]:
    """Where pip put the library: beside no module, so that the loader would not look there."""
    try:
        files = metadata.files("tbb") or ()
    except metadata.PackageNotFoundError:
        return []
    return [str(file.locate().resolve()) for file in files if file.name == LIBRARY]


def _loads(path: str) -> bool:
    try:
        ctypes.CDLL(path, ctypes.RTLD_GLOBAL)
    except OSError:
        return False
    return True
