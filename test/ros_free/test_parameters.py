"""Parameters: one truth in the dataclasses, documented in config/cloth.yaml; and where shared files are found."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from cloth_core import Material, SettingError, SolverConfig
from cloth_core.scene import Scene
from cloth_sim_ros import share
from cloth_sim_ros.parameters import FIXED, NodeSettings, as_parameter_file, changed, grouped, parameter_names

CHECKOUT = Path(__file__).parents[2]


def load(text):
    return YAML(typ="safe", pure=True).load(text)["/**"]["ros__parameters"]


def test_the_shipped_parameter_file_is_the_generated_one():
    assert (CHECKOUT / "config" / "cloth.yaml").read_text() == as_parameter_file(), (
        "run: python -m cloth_sim_ros.parameters > config/cloth.yaml"
    )


def test_the_parameter_file_gives_the_defaults_back():
    assert NodeSettings.from_mapping(load(as_parameter_file())) == NodeSettings()


def test_with_its_comments_taken_away_the_parameter_file_holds_every_parameter():
    lines = [line.replace("    # ", "    ", 1) for line in as_parameter_file().splitlines()]
    kept = [line for line in lines if line.split("#")[0].rstrip().endswith(":") or ": " in line.split("#")[0]]
    values = load(
        "\n".join(line for line in kept if line.split(":")[0].strip().isidentifier() or "ros__" in line or "**" in line)
    )
    assert Material.from_mapping(values.pop("material")) == Material()
    assert SolverConfig.from_mapping(values.pop("solver")) == SolverConfig()
    assert values.keys() == {field.name for field in dataclasses.fields(NodeSettings)}


def test_values_by_full_name_are_checked_in_the_words_of_the_full_name():
    given = grouped({"material.friction": 0.7, "grasp_timeout": 0.5, "use_sim_time": True, "solver.substeps": 4})
    assert given == {"": {"grasp_timeout": 0.5}, "material": {"friction": 0.7}, "solver": {"substeps": 4}}
    assert changed(Material(), "material", given["material"]) == Material(friction=0.7)
    with pytest.raises(SettingError, match=r"material\.friction: -1 is out of range: a number 0 \.\. 10"):
        changed(Material(), "material", {"friction": -1})


def test_parameter_names_walk_all_the_dataclasses():
    names = parameter_names()
    assert set(FIXED) <= set(names)
    assert {"scene", "static_transforms", "material.areal_density", "solver.dt"} <= set(names)
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("values", "parts"),
    [
        ({"record": "everything"}, ("record", "everything", "none, inputs, outputs, all")),
        ({"grasp_timeout": -1.0}, ("grasp_timeout", "-1.0", "0.01 .. 10 s")),
        ({"mesh_rate": "fast"}, ("mesh_rate", "fast", "Hz")),
        ({"static_transforms": "world table"}, ("static_transforms", "list of texts")),
        ({"autostart": 1}, ("autostart", "true or false")),
    ],
)
def test_a_wrong_value_is_refused_with_name_value_and_range(values, parts):
    with pytest.raises(SettingError) as refused:
        NodeSettings(**values)
    for part in parts:
        assert part in str(refused.value)


def test_sessions_go_where_the_parameter_the_environment_or_ros_says(monkeypatch, tmp_path):
    monkeypatch.delenv("CLOTH_SESSIONS", raising=False)
    assert NodeSettings().sessions == Path.home() / ".ros" / "cloth_sessions"
    monkeypatch.setenv("CLOTH_SESSIONS", str(tmp_path))
    assert NodeSettings().sessions == tmp_path
    assert NodeSettings(session_folder="~/mine").sessions == Path.home() / "mine"


def test_every_shipped_scene_is_found_by_name_and_loads():
    names = share.scene_names()
    assert "scarf" in names
    for name in names:
        assert Scene.load(share.find_scene(name)).mesh.vertex_count > 0


def test_a_scene_is_found_by_its_path(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("cloth: {grid: {width: 1.0, height: 1.0, columns: 3, rows: 3}}\n")
    assert share.find_scene(str(file)) == file


def test_an_unknown_scene_is_refused_naming_those_that_there_are():
    with pytest.raises(SettingError, match=r"scene: 'skarf' .*scarf"):
        share.find_scene("skarf")


def test_an_installation_on_the_ament_path_goes_before_the_checkout(monkeypatch, tmp_path):
    scenes = tmp_path / "share" / "cloth_sim_ros" / "config" / "scenes"
    scenes.mkdir(parents=True)
    (scenes / "only.yaml").write_text("")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{tmp_path}")
    assert share.scene_names() == ["only"]
    assert share.find_scene("only") == scenes / "only.yaml"


def test_what_was_mended_in_a_mesh_file_goes_to_who_loads_the_scene_and_other_warnings_go_on(tmp_path, monkeypatch):
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 9 9 9\nv 0 1 0\nf 1 2 4\nf 4 2 1\n")
    (tmp_path / "sheet.yaml").write_text("cloth: {mesh: {file: sheet.obj}}\n")
    load = Scene.load

    def load_and_warn(path):
        warnings.warn("something else", DeprecationWarning, stacklevel=1)
        return load(path)

    monkeypatch.setattr(Scene, "load", load_and_warn)
    lines: list[str] = []
    with pytest.warns(DeprecationWarning, match="something else") as others:
        scene = share.load_scene(str(tmp_path / "sheet.yaml"), lines.append)
    assert (scene.mesh.vertex_count, len(others)) == (3, 1)
    assert lines == [
        f"{tmp_path}/sheet.obj: vertices that belong to no triangle were dropped: 2",
        f"{tmp_path}/sheet.obj: triangles that repeat an earlier one were dropped: 1",
    ]
