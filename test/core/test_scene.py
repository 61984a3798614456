"""Scene files: every wrong one is refused with the file, the key, the value and what would be allowed."""

from __future__ import annotations

import copy
import io
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from cloth_core import MeshError, MeshWarning, SettingError
from cloth_core.scene import Scene

GRID = "cloth: {grid: {width: 1.0, height: 0.5, columns: 5, rows: 4}}\n"


def test_a_scene_holds_what_the_file_says():
    scene = Scene.parse(
        GRID
        + """
material: {preset: denim, friction: 0.7}
solver: {dt: 1e-2, integrator: meyer2000}
obstacles: {ball: {sphere: {radius: 0.3, center: [0, 0, -1]}}, floor: {plane: {}}}
grasps: {hand: {radius: 0.05}}
groups: {hooks: [0, 4]}
pins: [hooks]
gravity: [0, 0, -1.62]
script: {grasps: {hand: [{at: 0, position: [0, 0, 0]}, {at: 1, position: [0, 0, 1], closure: 1}]}}
"""
    )
    solver, state = scene.build()
    assert (scene.material.friction, scene.material.stretch_warp) == (0.7, 1014.0)
    assert solver.config.dt == 0.01
    assert list(solver.pinned) == [0, 4]
    assert set(state.obstacles) == {"ball", "floor"}
    assert scene.inputs.gravity == (0.0, 0.0, -1.62)
    halfway = scene.script.inputs_at(0.5, scene.inputs).grasps["hand"]
    assert halfway.pose.position == pytest.approx((0.0, 0.0, 0.5))
    assert halfway.radius == 0.05


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "section with the keys"),
        ("material: {}", "cloth: is missing"),
        ("cloth: {}", "cloth: needs either grid or mesh"),
        (
            "cloth: {grid: {width: 1.0, height: 0.5, columns: 5}}",
            "cloth.grid.rows: is missing: a whole number 2 .. 1000",
        ),
        ("cloth: {grid: {width: 1.0, height: 0.5, columns: 5, rows: 1}}", "cloth.grid.rows: 1 is out of range"),
        ("cloth: {mesh: {file: nowhere.obj}}", "nowhere.obj: cannot be read as a mesh"),
        (GRID + "materil: {}", "materil: no such key; did you mean material?"),
        (GRID + "material: {bendd: 1}", "material.bendd: no such key; did you mean bend?"),
        (GRID + "material: {bend: much}", "material.bend: 'much' is not a number 0 .. 1000 N m (bending stiffness)"),
        (GRID + "material: {preset: tweed}", "material.preset: 'tweed' is not one of denim"),
        (GRID + "material: {preset: [a]}", "material.preset: ['a'] is not one of denim"),
        (GRID + "solver: {dt: 1.0}", "solver.dt: 1.0 is out of range: a number 0.001 .. 0.1 s"),
        (GRID + "solver: {integrator: euler}", "is not one of implicit_midpoint, meyer2000"),
        (GRID + "obstacles: {ball: {sphere: {radius: -1}}}", "obstacles.ball.sphere.radius: -1 is out of range"),
        (GRID + "obstacles: {ball: {orb: {}}}", "obstacles.ball.orb: no such key"),
        (GRID + "obstacles: {1ball: {sphere: {radius: 1}}}", "obstacles: '1ball' is not a name of letters"),
        (GRID + "obstacles: {b: {sphere: {radius: 1, orientation: [0, 0, 0, 0]}}}", "obstacles.b.sphere.orientation"),
        (
            GRID + "grasps: {hand: {open_at: 0.9}}",
            "grasps.hand.open_at: 0.9 is above close_at: allowed is 0 .. close_at, which is 0.6",
        ),
        (GRID + "wind: {velocity: [1, 2]}", "wind.velocity: [1, 2] has 2 components, not 3 numbers m/s"),
        (GRID + "pins: [left, rihgt]", "pins: no vertex group 'rihgt'"),
        (GRID + "groups: {hooks: [99]}", "groups.hooks: vertex 99 is not 0 .. 19"),
        (
            GRID + "script: {grasps: {hand: [{at: 0, position: [0, 0, 0]}]}}",
            "script.grasps.hand: the scene declares no",
        ),
        (
            GRID + "script: {wind: [{at: 1, velocity: [0, 0, 0]}, {at: 1, velocity: [0, 0, 0]}]}",
            "is not after the keyframe",
        ),
        (GRID + "gravity: [0, 0, .inf]", "gravity: [0, 0, inf] is not 3 finite numbers m/s^2"),
        (GRID + "gravity: [0, 0, -2000]", "gravity: gravity (0.0, 0.0, -2000.0) is not three numbers within +-1000"),
        (GRID + "grasps: {hand: {position: [0, 0]}}", "grasps.hand.position: [0, 0] is not 3 finite numbers m"),
        (GRID + "solver: {substeps: .inf}", "solver.substeps: inf is not a whole number"),
        ("cloth: [", "is not valid YAML"),
        (GRID + GRID, "is not valid YAML: found duplicate key"),
    ],
)
def test_what_is_wrong_is_refused_in_words(text, said):
    with pytest.raises(SettingError) as refused:
        Scene.parse(text, source="my.yaml")
    message = str(refused.value)
    assert message.startswith("my.yaml: ")
    assert said in message
    assert ": : " not in message and "http" not in message


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(SettingError, match=r"none.yaml: cannot be read: No such file"):
        Scene.load(tmp_path / "none.yaml")


def test_a_file_that_holds_no_mesh_says_so(tmp_path):
    (tmp_path / "noise.stl").write_bytes(bytes(range(256)) * 2)
    with pytest.raises(SettingError, match=r"cloth: .*noise.stl: cannot be read as a mesh"):
        Scene.parse("cloth: {mesh: {file: noise.stl}}", folder=tmp_path)


def test_a_mesh_file_that_was_mended_says_so_on_the_way(tmp_path):
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 9 9 9\nv 0 1 0\nf 1 2 4\n")
    with pytest.warns(MeshWarning, match=r"sheet.obj: vertices that belong to no triangle were dropped: 2$"):
        scene = Scene.parse("cloth: {mesh: {file: sheet.obj}}", folder=tmp_path)
    assert scene.mesh.vertex_count == 3


def test_values_that_are_possible_each_and_impossible_together_are_refused():
    fine = "cloth: {grid: {width: 0.001, height: 0.001, columns: 20, rows: 20}}\n"
    Scene.parse(fine).build()
    with pytest.raises(MeshError, match=r"vertices too light.*: 0, 1, .* softer stretching or bending"):
        Scene.parse(fine + "material: {bend: 100.0, areal_density: 0.001}").build()


FULL = """
cloth: {grid: {width: 1.0, height: 0.5, columns: 5, rows: 4}, position: [0, 0, 1], orientation: [0, 0, 0, 1]}
material: {areal_density: 0.2, stretch_warp: 100, bend: 1.0e-5, damping: 0.1}
solver: {dt: 0.02, integrator: meyer2000, substeps: 0, contact_shell: 0.005}
obstacles: {ball: {sphere: {radius: 0.3, center: [0, 0, -1]}}, floor: {plane: {normal: [0, 0, 1]}}}
grasps: {hand: {radius: 0.05, position: [0, 0, 0], close_at: 0.6, open_at: 0.3}}
wind: {velocity: [1, 0, 0], gust_intensity: 0.1, gust_seed: 3}
groups: {hooks: [0, 4]}
pins: [hooks]
gravity: [0, 0, -1.62]
view: {eye: [1, 1, 1], target: [0, 0, 0]}
script:
  grasps: {hand: [{at: 0, position: [0, 0, 0]}, {at: 1, position: [0, 0, 1], closure: 1}]}
  wind: [{at: 1, velocity: [0, 0, 1]}]
"""


def places(node, path=()):
    """Where something stands in a document."""
    if path:
        yield path
    for key in node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ():
        yield from places(node[key], (*path, key))


YAML_12 = YAML(typ="safe", pure=True)
DOCUMENT = YAML_12.load(FULL)
NONSENSE = [
    math.nan,
    math.inf,
    -math.inf,
    1e308,
    10**400,
    -1,
    2.5,
    True,
    None,
    "x",
    [],
    {},
    [None],
    {1: 2},
    [[1]],
    b"x",
]


@given(st.sampled_from(list(places(DOCUMENT))), st.sampled_from(NONSENSE))
def test_nonsense_anywhere_is_a_setting_error_that_names_the_file_or_no_nonsense(path, value):
    document = copy.deepcopy(DOCUMENT)
    section = document
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = value
    text = io.StringIO()
    YAML_12.dump(document, text)
    try:
        Scene.parse(text.getvalue(), source="my.yaml")
    except SettingError as error:
        assert str(error).startswith("my.yaml: ")
    else:
        assert not isinstance(value, float) or math.isfinite(value)
