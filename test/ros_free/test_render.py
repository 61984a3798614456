"""Pictures: skipped where the extra [render] or an OpenGL library is missing."""

from __future__ import annotations

import itertools
import subprocess
import sys
from dataclasses import replace

import bodies
import numpy as np
import pytest

from cloth_core import ClothMesh, Inputs, Wind
from cloth_core.fields import Compound, VoxelField
from cloth_core.inputs import Grasp
from cloth_core.obstacles import Box
from cloth_core.pose import Pose
from cloth_core.scene import Scene
from cloth_sim_ros import render
from cloth_sim_ros.rendering import offscreen
from cloth_sim_ros.rendering.fabric import FABRICS, printed
from cloth_sim_ros.rendering.offscreen import RenderError, require_renderer
from cloth_sim_ros.rendering.playback import frame_times, play
from cloth_sim_ros.rendering.smooth import loop_subdivision

SCENE = """
cloth: {grid: {width: 1.0, height: 0.8, columns: 12, rows: 10}, position: [0.0, 0.0, 0.7]}
obstacles:
  ball: {sphere: {radius: 0.2, center: [0.0, 0.0, 0.2]}}
  box: {box: {extents: [0.2, 0.2, 0.2], center: [0.4, 0.3, 0.1]}}
  egg: {ellipsoid: {radii: [0.1, 0.1, 0.15], center: [-0.4, 0.3, 0.15]}}
  post: {capsule: {radius: 0.03, length: 0.5, center: [-0.4, -0.3, 0.3]}}
  ground: {plane: {}}
grasps: {hand: {position: [0.4, -0.4, 0.5]}}
wind: {velocity: [1.0, 0.0, 0.0]}
view: {eye: [1.3, -1.9, 1.2], target: [0.0, 0.0, 0.3]}
"""
SIZE = (160, 120)


@pytest.fixture
def drawing():
    """Skips, with the reason, where nothing can be drawn."""
    try:
        require_renderer()
    except RenderError as error:
        pytest.skip(f"cannot draw here: {error}")


@pytest.fixture
def scene_file(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(SCENE)
    return path


def read_image(path):
    from PIL import Image

    with Image.open(path) as image:
        return np.array(image.convert("RGB"))


def read_animation(path):
    if path.suffix == ".gif":
        from PIL import Image, ImageSequence

        with Image.open(path) as animation:
            return [np.array(frame.convert("RGB"), int) for frame in ImageSequence.Iterator(animation)]
    import imageio_ffmpeg

    decode = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(decode, capture_output=True, check=True).stdout
    return list(np.frombuffer(raw, np.uint8).reshape(-1, SIZE[1], SIZE[0], 3).astype(int))


@pytest.mark.usefixtures("drawing")
def test_a_still_is_written_and_not_blank(scene_file, tmp_path, capsys):
    png = tmp_path / "pictures" / "still.png"
    assert render.main([str(scene_file), "--time", "0.1", "--png", str(png), "--size", "160x120"]) == 0
    picture = read_image(png)
    assert picture.shape == (120, 160, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 200
    assert str(png) in capsys.readouterr().out


@pytest.mark.usefixtures("drawing")
def test_what_moves_changes_the_picture():
    from cloth_sim_ros.rendering.stage import Stage

    scene = Scene.parse(SCENE)
    (state, inputs), (later, _) = play(scene, [0.0, 0.3])
    calm = replace(inputs, wind=Wind())
    hand = replace(inputs, grasps={"hand": Grasp(pose=Pose((0.5, -0.5, 0.6)), closure=1.0)})
    moved = replace(state, obstacles={**state.obstacles, "ball": Pose((0.0, -0.3, 0.2))})
    with Stage(scene, SIZE) as stage:
        first = stage.picture(state, inputs)
        for changed in ((later, inputs), (state, calm), (state, hand), (moved, inputs)):
            assert (stage.picture(*changed) != first).any(axis=2).sum() > 10
        assert np.array_equal(stage.picture(state, inputs), first)


@pytest.mark.usefixtures("drawing")
def test_meshes_and_compounds_are_drawn_where_their_parts_stand():
    from cloth_sim_ros.rendering.shapes import surface

    ball = VoxelField(surface=bodies.ball(0.1), center=(0.0, 0.0, 1.0))
    assert surface(ball).bounds == pytest.approx((-0.1, 0.1, -0.1, 0.1, -0.1, 0.1), abs=2e-3)  # in its own frame
    lamp = Compound(parts={"post": Box(extents=(0.1, 0.1, 1.0), center=(0.0, 0.0, 0.5)), "shade": ball})
    assert surface(lamp).bounds == pytest.approx((-0.1, 0.1, -0.1, 0.1, 0.0, 1.1), abs=2e-3)


@pytest.mark.usefixtures("drawing")
def test_the_two_sides_of_the_cloth_have_two_tones():
    from cloth_sim_ros.rendering.stage import Stage

    text = "cloth: {grid: {width: 1, height: 1, columns: 5, rows: 5}}\nview: {eye: [0, -1, %d], target: [0, 0, 0]}"
    tones = []
    for above in (2, -2):
        scene = Scene.parse(text % above)
        with Stage(scene, SIZE, FABRICS["bunting"]) as stage:
            picture = stage.picture(scene.build()[1], Inputs())
        assert picture[60, 80].max() > 60  # neither is black
        tones.append(picture[60, 80].astype(int))
    assert np.abs(tones[0] - tones[1]).max() > 10


@pytest.mark.usefixtures("drawing")
@pytest.mark.parametrize("ending", [".gif", ".mp4"])
def test_an_animation_holds_the_frames_that_were_asked_for(scene_file, tmp_path, ending):
    if ending == ".mp4":
        pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / f"fall{ending}"
    called = [str(scene_file), "--animation", str(path), "--to", "0.5", "--fps", "10", "--size", "160x120"]
    assert render.main(called) == 0
    frames = read_animation(path)
    assert len(frames) == 5
    assert all((np.abs(a - b).max(axis=2) > 20).sum() > 20 for a, b in itertools.pairwise(frames))


def test_a_missing_package_is_named(monkeypatch, capsys, scene_file):
    monkeypatch.setattr(offscreen.importlib.util, "find_spec", lambda name: None if name == "pyvista" else object())
    assert render.main([str(scene_file)]) == 1
    complaint = capsys.readouterr().err
    assert "pyvista" in complaint and "pip install" in complaint


def test_a_missing_opengl_library_is_named_before_vtk_can_crash(monkeypatch, capsys, scene_file):
    monkeypatch.setattr(offscreen.importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(offscreen, "GL_WINDOWS", {"libNoSuchGL.so.1": "none"})
    monkeypatch.delenv("DISPLAY", raising=False)
    loaded = set(sys.modules)
    assert render.main([str(scene_file)]) == 1
    assert "apt install libegl1" in capsys.readouterr().err
    assert not {name for name in set(sys.modules) - loaded if name.startswith("vtk")}


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([], "name one scene"),
        (["scarf", "--all"], "name one scene"),
        (["scarf", "--time", "-1"], "0 .. 3600 s"),
        (["scarf", "--size", "640"], "WIDTHxHEIGHT"),
        (["scarf", "--animation", "film.avi"], ".gif"),
        (["scarf", "--animation", "a.gif", "--from", "3", "--to", "2"], "is not after"),
    ],
)
def test_a_wrong_call_says_what_is_allowed(arguments, complaint, capsys):
    with pytest.raises(SystemExit) as ended:
        render.main(arguments)
    assert ended.value.code == 2
    assert complaint in capsys.readouterr().err


@pytest.mark.usefixtures("drawing")
def test_an_unknown_scene_is_answered_with_the_known_ones(capsys):
    assert render.main(["no_such_scene"]) == 1
    complaint = capsys.readouterr().err
    assert "no_such_scene" in complaint and "scarf" in complaint


def test_frames_of_a_loop_stop_short_of_its_end():
    assert frame_times(1.0, 2.0, 4.0) == [1.0, 1.25, 1.5, 1.75]


def test_playback_gives_the_step_at_each_time():
    states = [state for state, _ in play(Scene.parse(SCENE), [0.0, 0.02, 0.1])]
    assert [state.step_index for state in states] == [0, 1, 5]


def test_subdivision_keeps_a_plane_and_the_way_it_faces():
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=6, rows=5)
    finer, triangles = loop_subdivision(mesh.triangles, mesh.vertex_count)
    fine = finer @ mesh.rest_position
    assert triangles.shape == (4 * len(mesh.triangles), 3)
    assert np.allclose(np.asarray(finer.sum(axis=1)), 1.0)
    a, b, c = (fine[triangles[:, n]] for n in range(3))
    facing = np.cross(b - a, c - a)
    assert np.allclose(facing[:, :2], 0.0) and (facing[:, 2] > 0).all()
    inner = (np.abs(mesh.rest_position[:, :2]) < 0.25).all(axis=1)
    assert np.allclose(fine[: mesh.vertex_count][inner], mesh.rest_position[inner])


def test_subdivision_of_a_tetrahedron_follows_loop():
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    triangles = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
    finer, _ = loop_subdivision(triangles, 4)
    # Valence 3: 7/16 of the vertex and 3/16 of each neighbour, whose sum is minus the vertex.
    assert np.allclose((finer @ corners)[:4], corners / 4.0)
    # Edge 0-1: 3/8 of both ends, 1/8 of both opposite corners.
    assert np.allclose((finer @ corners)[4], [0.5, 0.0, 0.0])


@pytest.mark.parametrize("name", list(FABRICS))
def test_a_print_covers_the_cloth_in_its_two_colours(name):
    fabric = FABRICS[name]
    image = printed(fabric, ClothMesh.grid(width=0.9, height=0.5, columns=10, rows=6))
    assert image.shape == (320, 576, 3) and image.dtype == np.uint8
    colours = {tuple(colour) for colour in image.reshape(-1, 3).tolist()}
    assert fabric.ground in colours and len(colours) > 1


def test_a_cloth_without_texture_coordinates_has_no_print():
    mesh = ClothMesh.from_triangles([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert printed(FABRICS["silk"], mesh) is None
