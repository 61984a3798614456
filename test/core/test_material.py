"""The presets are the measured fabrics."""

from __future__ import annotations

import pytest

from cloth_core import Material
from cloth_core.material import PRESETS

# Wang, Ramamoorthi and O'Brien 2011.
AREAL_DENSITY = {
    "interlock": 0.187,
    "denim": 0.324,
    "ponte": 0.284,
    "rib": 0.276,
    "tango": 0.113,
    "dots": 0.128,
    "swim": 0.204,
}


@pytest.mark.parametrize("name", AREAL_DENSITY)
def test_presets_weigh_what_was_measured(name):
    assert Material.preset(name).areal_density == AREAL_DENSITY[name]


def test_every_preset_has_its_measured_density():
    assert PRESETS.keys() == AREAL_DENSITY.keys()


def test_stiffness_and_bending_lie_in_the_measured_ranges():
    denim, interlock, dots = (Material.preset(name) for name in ("denim", "interlock", "dots"))
    assert (denim.stretch_warp, denim.stretch_weft) == (1014, 205)
    assert 17 <= interlock.stretch_weft <= interlock.stretch_warp <= 34
    assert dots.stretch_warp == pytest.approx(2000, rel=0.05)
    assert 2.0e-5 <= denim.bend <= 1.2e-4
    assert 0.7e-5 <= interlock.bend <= 3.9e-5


@pytest.mark.parametrize("name", PRESETS)
def test_stretch_limits_are_those_of_garment_fabrics(name):
    assert 1.06 <= Material.preset(name).stretch_limit <= 1.13


def test_a_preset_can_be_changed_in_part():
    changed = Material.preset("denim", friction=0.7)
    assert (changed.friction, changed.areal_density) == (0.7, 0.324)
