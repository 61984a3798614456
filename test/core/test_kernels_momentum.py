"""The rigid momentum correction against its slow twin."""

from __future__ import annotations

import numpy as np
import pytest
import twins

from cloth_core.kernels import momentum


@pytest.mark.parametrize("seed", range(20))
def test_each_free_component_gets_the_momenta_that_it_should_have(seed):
    random = np.random.default_rng(seed)
    lengths = random.integers(1, 40, 7)
    count = lengths.sum()
    x, inertial, moved = random.normal(size=(3, count, 3))
    mass, component = random.uniform(0.1, 2.0, count), np.repeat(np.arange(7, dtype=np.int32) % 3, lengths)
    ends = np.cumsum(lengths)
    runs = np.column_stack([ends - lengths, ends, np.arange(7) % 3])
    chosen = np.array([True, seed % 2 == 0, False])

    anchor = random.normal(size=(3, 3))
    moment = momentum.moments(x, inertial, moved, mass, runs, anchor, chosen)
    for c in np.flatnonzero(chosen):
        at = component == c
        m, r, e = mass[at], x[at] - anchor[c], (inertial - moved)[at]
        spread = np.einsum("v,vi,vj", m, r, r)
        expected = [[m.sum()], m @ r, m @ e, np.diag(spread), spread[[0, 0, 1], [1, 2, 2]], m @ np.cross(r, e)]
        np.testing.assert_allclose(moment[c], np.concatenate(expected), rtol=1e-12, atol=1e-12)
    assert not moment[~chosen].any()

    shift, turn = momentum.rigid_motion(np.full(3, momentum.FREE), np.zeros((3, 3)), anchor, moment)
    corrected, expected = moved.copy(), moved.copy()
    momentum.add_rigid_displacement(x, anchor, shift, turn, runs, chosen, corrected)
    for c in np.flatnonzero(chosen):
        expected += twins.rigid_correction(x, inertial, moved, mass, np.flatnonzero(component == c))
    np.testing.assert_allclose(corrected, expected, atol=1e-11)
