"""Scene files: every wrong one is refused with the file, the key, the value and what would be allowed."""

from __future__ import annotations

import pytest

from cloth_core import SettingError
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
        (GRID + "solver: {integrator: euler}", "is not one of implicit_euler, meyer2000"),
        (GRID + "obstacles: {ball: {sphere: {radius: -1}}}", "obstacles.ball.sphere.radius: -1 is out of range"),
        (GRID + "obstacles: {ball: {orb: {}}}", "obstacles.ball.orb: no such key"),
        (GRID + "obstacles: {1ball: {sphere: {radius: 1}}}", "obstacles: '1ball' is not a name of letters"),
        (GRID + "obstacles: {b: {sphere: {radius: 1, orientation: [0, 0, 0, 0]}}}", "obstacles.b.sphere.orientation"),
        (GRID + "grasps: {hand: {open_at: 0.9}}", "grasps.hand.open_at: 0.9 must be less than close_at"),
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
