"""Settings refuse what makes no sense, and say which key, which value, which range and unit."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from cloth_core import Grasp, InputError, Inputs, Material, Pose, SettingError, SolverConfig, Wind
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Plane, Sphere

EVERY_SECTION = (Material, SolverConfig, Wind, Grasp, Plane, Sphere, Box, Capsule, Ellipsoid)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: Material(areal_density=-0.1), ["areal_density", "-0.1", "0.001 .. 20", "kg/m^2"]),
        (lambda: Material(areal_density=math.nan), ["areal_density", "nan", "kg/m^2"]),
        (lambda: Material(bend="0.1"), ["bend", "'0.1'", "a number", "N m"]),
        (lambda: Material(friction=True), ["friction", "True", "0 .. 10"]),
        (lambda: SolverConfig(dt=0.5), ["dt", "0.5", "0.001 .. 0.1 s"]),
        (lambda: SolverConfig(substeps=2.5), ["substeps", "2.5", "a whole number", "0 .. 200"]),
        (lambda: SolverConfig(integrator="rk4"), ["integrator", "'rk4'", "implicit_midpoint, meyer2000"]),
        (lambda: Wind(velocity=(1.0, 2.0)), ["velocity", "2 components", "3 numbers", "m/s"]),
        (lambda: Wind(velocity=(1.0, math.inf, 0.0)), ["velocity", "inf", "m/s"]),
        (lambda: Wind(velocity="fast"), ["velocity", "'fast'"]),
        (lambda: Grasp(pose=Pose(), closure=1.2), ["closure", "1.2", "0 .. 1"]),
        (lambda: Sphere(radius=0.0), ["radius", "0.0", "0.0001 .. 1000 m"]),
        (lambda: Box(extents=(1.0, 1.0, -1.0)), ["extents", "-1.0", "m"]),
        (lambda: Plane(normal=(0.0, 0.0, 0.0)), ["normal", "no direction", "1e-9"]),
        (lambda: Plane(normal=(0.0, 1e308, 1e308)), ["normal", "1e+308", "3 numbers -1e+06 .. 1e+06"]),
        (lambda: Sphere(radius=1.0, center=(0.0, -2e6, 0.0)), ["center", "-2000000.0", "-1e+06 .. 1e+06 m"]),
        (lambda: Material.preset("velvet"), ["preset", "'velvet'", "denim"]),
        (lambda: Material.preset("denim", friction=99.0), ["friction", "99.0", "0 .. 10"]),
        (lambda: Material.preset("denim", frixion=0.5), ["frixion: no such key; did you mean friction?"]),
        (
            lambda: Material(stiffness="x"),
            ["Material(): stiffness: no such key; known keys: areal_density, stretch_warp"],
        ),
        (lambda: Material(areal_densty=0.2), ["Material(): areal_densty", "did you mean areal_density?"]),
        (lambda: Material("denim"), ["Material(): 'denim' has no name; known keys: areal_density"]),
        (lambda: Sphere(0.3), ["Sphere(): 0.3 has no name", "radius"]),
        (lambda: Grasp(pose=None), ["pose: None is not of the type Pose; write Pose((x, y, z)) (m)"]),
        (lambda: Grasp(pose=(0.0, 0.0, 1.0)), ["pose: (0.0, 0.0, 1.0) is not of the type Pose"]),
        (
            lambda: Grasp(pose=Pose(), close_at=0.3, open_at=0.5),
            ["open_at: 0.5 is above close_at", "0 .. close_at, which is 0.3"],
        ),
    ],
)
def test_message_names_key_value_range_and_unit(build, words):
    with pytest.raises(SettingError) as caught:
        build()
    for word in words:
        assert word in str(caught.value)


def test_every_bound_is_allowed_and_what_lies_beyond_is_not():
    for section in (Material, SolverConfig):
        for name, known in section.settings():
            if known.kind not in ("float", "int"):
                continue
            for bound in (known.low, known.high):
                assert getattr(section(**{name: bound}), name) == bound
            for beyond in (known.low - 1, known.high + 1):
                with pytest.raises(SettingError, match=name):
                    section(**{name: beyond})


@pytest.mark.parametrize("section", [Plane, Sphere, Box, Capsule, Ellipsoid])
def test_obstacles_stand_firm_at_every_bound_and_what_lies_beyond_is_refused(section):
    for name, known in section.settings():
        assert math.isfinite(known.low), name
        assert math.isfinite(known.high), name
        needed = {n: s.high for n, s in section.settings() if s.kind == "float" and n in ("radius", "length")}
        needed |= {n: (s.high,) * s.size for n, s in section.settings() if n in ("extents", "radii")}

        def given(bound, name=name, known=known, needed=needed):
            return section(**{**needed, name: (bound,) * known.size if known.size else bound})

        for bound in {known.low, known.high} - {0.0}:
            obstacle = given(bound)
            assert np.linalg.norm(obstacle.pose.orientation) == pytest.approx(1.0)
            assert np.isfinite([*obstacle.pose.position, *obstacle.size]).all()
            with pytest.raises(SettingError, match=name):
                given(bound + math.copysign(1e-3 * abs(bound), bound - 0.5 * (known.low + known.high)))


@pytest.mark.parametrize("section", EVERY_SECTION)
def test_every_setting_has_a_sentence(section):
    for name, known in section.settings():
        assert known.help, name
        assert known.allowed, name


@pytest.mark.parametrize("value", [math.inf, -math.inf, math.nan, 10**400, -(10**400)])
def test_numbers_that_no_float_or_no_int_can_hold_are_refused_like_others(value):
    with pytest.raises(SettingError, match=r"dt: .* a number 0.001 .. 0.1 s"):
        SolverConfig(dt=value)
    with pytest.raises(SettingError, match=r"substeps: .* a whole number 0 .. \d+"):
        SolverConfig(substeps=value)
    with pytest.raises(SettingError, match=r"velocity: .* 3 numbers m/s"):
        Wind(velocity=(0.0, value, 0.0))


def test_mapping_round_trip_is_exact():
    material = Material.preset("denim", friction=0.1 + 0.2)
    assert Material.from_mapping(material.as_mapping()) == material
    wind = Wind(velocity=(0.1, 0.2, 0.3), gust_seed=7)
    assert Wind.from_mapping(wind.as_mapping()) == wind


def test_unknown_and_missing_keys_are_named():
    with pytest.raises(SettingError, match=r"arreal_density: no such key; did you mean areal_density\?"):
        Material.from_mapping({"arreal_density": 0.2})
    with pytest.raises(SettingError, match="zzz: no such key; known keys: areal_density"):
        Material.from_mapping({"zzz": 0.2})
    with pytest.raises(SettingError, match="radius: is missing: a number"):
        Sphere.from_mapping({})
    with pytest.raises(SettingError, match="not a section"):
        Material.from_mapping([1, 2])


def test_an_error_can_be_placed_in_its_section_and_file():
    error = SettingError("dt", "0.5 is out of range").under("solver").read_from("scarf.yaml")
    assert str(error) == "scarf.yaml: solver.dt: 0.5 is out of range"
    assert (error.key, error.source) == ("solver.dt", "scarf.yaml")


def test_settings_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Material().friction = 0.5


@pytest.mark.parametrize(
    ("build", "word"),
    [
        (lambda: Pose((math.nan, 0, 0)), "position"),
        (lambda: Pose((1e7, 0, 0)), "1e6"),
        (lambda: Pose(orientation=(0, 0, 0, 0)), "orientation"),
        (lambda: Pose(orientation=(0, 0, math.inf, 1)), "orientation"),
        (lambda: Pose(orientation=(0, 0, 1)), "quaternion"),
        (lambda: Pose((1, 2)), "three"),
        (lambda: Pose(None), "position None is not three finite numbers within .* m"),
        (lambda: Pose("123"), "position '123' is not three"),
        (lambda: Pose(5.0), "position 5.0 is not three"),
        (lambda: Pose((0, 0, "up")), "position .* is not three"),
        (lambda: Pose(orientation=None), "orientation None is not a quaternion"),
        (lambda: Inputs(gravity=9.81), r"gravity 9.81 is not three numbers within \+-1000 m/s\^2, such as .*-9.81"),
        (lambda: Inputs(gravity="123"), "gravity '123' is not three numbers"),
        (lambda: Inputs(gravity=None), "gravity None is not three numbers"),
        (lambda: Inputs(wind=(2, 0, 0)), r"wind: \(2, 0, 0\) is not of the type Wind; write Wind\(velocity=.* \(m/s\)"),
        (lambda: Inputs(wind=None), "wind: None is not of the type Wind"),
        (
            lambda: Inputs(grasps=[Grasp(pose=Pose())]),
            r"grasps: \[Grasp.*\.\.\. does not map names to values; write {'name'",
        ),
        (lambda: Inputs(grasps=Grasp(pose=Pose())), "grasps: Grasp.* does not map names to values"),
        (lambda: Inputs(grasps={"hand": Pose()}), r"grasps.hand: Pose.* is not of the type Grasp; write Grasp\("),
        (lambda: Inputs(grasps={"": Grasp(pose=Pose())}), "grasps: '' is no name"),
        (lambda: Inputs(grasps={1: Grasp(pose=Pose())}), "grasps: 1 is no name"),
        (
            lambda: Inputs(obstacles={"ball": (0, 0, 1)}),
            r"obstacles.ball: \(0, 0, 1\) is not of the type Pose; write Pose",
        ),
        (lambda: Inputs(obstacles={"ball": Sphere(radius=1.0)}), "obstacles.ball: Sphere.* is not of the type Pose"),
        (lambda: Inputs(gravity=(0, 0)), "gravity"),
        (lambda: Inputs(gravity=(0, 0, math.nan)), "gravity"),
        (lambda: Inputs(gravity=(0, 0, -2000)), "1000 m/s"),
    ],
)
def test_bad_poses_and_gravity_are_input_errors(build, word):
    with pytest.raises(InputError, match=word):
        build()
