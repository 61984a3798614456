"""Compiling is told of: our kernels by name, once each, and nothing of what is loaded or not ours."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from numba import types

from cloth_core import compiling
from cloth_core.kernels import kernel, momentum


def test_each_of_our_kernels_is_told_when_it_begins_to_compile():
    said = []
    along, inertia, twist, turn = (
        np.array([1.0, 0.0, 0.0]),
        np.diag([2.0, 3.0, 4.0]),
        np.array([6.0, 1.0, 1.0]),
        np.zeros(3),
    )
    ours = numba.njit(momentum._turn_about_line.py_func)  # not cached: compiles anew
    foreign = numba.njit(lambda x: x + 1)
    with compiling.told(lambda number, name: said.append((number, name))):
        assert foreign(1) == 2
        assert said == []
        ours(along, inertia, twist, turn)
        assert said == [(1, "_turn_about_line")]
        ours(along, inertia, twist, turn)  # compiled already
        numba.njit(momentum._turn_about_line.py_func)(along, inertia, twist, turn)
    numba.njit(momentum._turn_about_line.py_func)(along, inertia, twist, turn)  # nobody listens any more
    assert said == [(1, "_turn_about_line"), (2, "_turn_about_line")]
    assert turn == pytest.approx([3.0, 0.0, 0.0])


@kernel
def _half(number):
    return 0.5 * number


def test_a_kernel_called_with_several_numbers_of_the_source_is_compiled_once():
    for number in (1, 2, 3):
        _half.get_call_template((types.literal(number),), {})
    _half.get_call_template((types.int64,), {})
    assert _half.signatures == [(types.int64,)]
    assert _half(3) == 1.5
    _half.get_call_template((types.float64,), {})
    assert _half.signatures == [(types.int64,), (types.float64,)]
