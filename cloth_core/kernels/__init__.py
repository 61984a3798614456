"""Numba kernels: arrays and numbers in, arrays out; no objects, no imports from the rest of the package.

:func:`kernel` compiles without fastmath (it would break NaN checks and bit-equal replays), releases
the GIL, and caches on disk under a digest of all kernel sources: numba itself does not notice when a
kernel that another one calls has changed.
"""

from __future__ import annotations

import functools
import hashlib
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba import types

from cloth_core.kernels import threads

_Function = TypeVar("_Function")


@functools.cache
def sources_digest() -> str:
    """Of all kernel sources and numba's version: what they compute is the same where this is."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def cache_folder() -> Path:
    """Where the compiled kernels of exactly these sources are kept.

    ``NUMBA_CACHE_DIR`` or ``XDG_CACHE_HOME`` move it; a folder that cannot be written falls back to
    the temporary folder.
    """
    digest = sources_digest() + ("-shared" if threads.shared() else "")
    home = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or Path(home) / "cloth_core")
    folder = base / digest
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return Path(tempfile.gettempdir()) / f"cloth_core-{os.getuid()}" / digest


def kernel(function: _Function) -> _Function:
    """Compile ``function`` with numba on its first call, cached on disk."""
    return _compiled(function, fastmath=False)


def lane_kernel(function: _Function) -> _Function:
    """As :func:`kernel`, but sums may run in vector lanes and products be fused into them.

    For dense inner loops that test for no NaN: what is not finite stays so.
    """
    return _compiled(function, fastmath={"contract", "reassoc", "nsz"})


def inlined_kernel(function: _Function) -> _Function:
    """As :func:`kernel`, for what is too short to be called: arrays that are passed on cost as much as ten products."""
    return _compiled(function, fastmath=False, inline="always")


def shared_kernel(function: _Function) -> _Function:
    """As :func:`kernel`, but threads share the turns of its ``prange`` loops, where they can.

    A turn must write nothing that another one reads or writes: then the result is the same whoever does it, and
    however many they are.
    """
    return _compiled(function, fastmath=False, parallel=threads.shared())


def part_kernel(function: _Function) -> _Function:
    """As :func:`kernel`, for parts of kernels that are always compiled into their callers.

    For functions of many arrays and little work: an array is handed over as seven numbers, and its references are
    counted up and down, at the price of the work itself. Here nothing is counted: parts must not make arrays.
    """
    return _compiled(function, fastmath=False, forceinline=True, _nrt=False)


def _compiled(function: _Function, **options: Any) -> _Function:
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(cache_folder())
    try:
        made = numba.njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, **options)(function)
    finally:
        numba.config.CACHE_DIR = before
    made.get_call_template = _of_any_number(made.get_call_template)
    return made


def _of_any_number(template: Callable[..., Any]) -> Callable[..., Any]:
    """Of a ``template`` by which numba calls one kernel in another: compiles once for all whole numbers in the source.

    numba has a type for each of them, 1, 2 and 3, and would compile all that is called with them again and again.
    """

    def general(args: Sequence[types.Type], kws: Mapping[str, types.Type]) -> Any:
        plain = (types.unliteral(each) if isinstance(each, types.IntegerLiteral) else each for each in args)
        return template(tuple(plain), kws)

    return general
