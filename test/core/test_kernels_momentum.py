"""The rigid momentum correction against its slow twin."""

from __future__ import annotations

import numpy as np
import pytest
import twins

from cloth_core.kernels import momentum


@pytest.mark.parametrize("seed", range(20))
def test_moments_and_displacement_are_those_of_each_chosen_component(seed):
    random = np.random.default_rng(seed)
    count = 17
    x, inertial, moved = random.normal(size=(3, count, 3))
    mass, component = random.uniform(0.1, 2.0, count), np.arange(count, dtype=np.int32) % 3
    chosen = np.array([True, seed % 2 == 0, False])
    error = inertial - moved

    total, center, drift, inertia, twist = momentum.moments(x, error, mass, component, chosen, 3)
    for c in np.flatnonzero(chosen):
        at = component == c
        assert total[c] == pytest.approx(mass[at].sum())
        np.testing.assert_allclose(center[c], np.average(x[at], axis=0, weights=mass[at]), atol=1e-13)
        np.testing.assert_allclose(drift[c], mass[at] @ error[at], atol=1e-13)
        r = x[at] - center[c]
        np.testing.assert_allclose(twist[c], mass[at] @ np.cross(r, error[at]), atol=1e-12)
        spread = (mass[at, None, None] * r[:, :, None] * r[:, None, :]).sum(axis=0)
        np.testing.assert_allclose(inertia[c], np.trace(spread) * np.eye(3) - spread, atol=1e-12)
    assert not total[~chosen].any() and not drift[~chosen].any() and not twist[~chosen].any()

    shift, turn = momentum.rigid_motion(total, drift, inertia, twist)
    corrected = moved.copy()
    momentum.add_rigid_displacement(x, center, shift, turn, component, chosen, corrected)
    expected = moved.copy()
    for c in np.flatnonzero(chosen):
        expected += twins.rigid_correction(x, inertial, moved, mass, np.flatnonzero(component == c))
    np.testing.assert_allclose(corrected, expected, atol=1e-12)
