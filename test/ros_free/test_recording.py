from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import bodies
import numpy as np
import pytest

from cloth_core import Grasp, Inputs, Pose, Wind
from cloth_core.scene import Scene
from cloth_sim_ros.messages.cdr import encode_string
from cloth_sim_ros.recording.content import Event, Snapshot, Step
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.recorder import RECORD, Recorder
from cloth_sim_ros.recording.setup import attachments_of, metadata_of, scene_from
from cloth_sim_ros.session import SessionError, SessionWriter
from cloth_sim_ros.share import find_scene

INPUTS = Inputs(
    grasps={"hand": Grasp(pose=Pose((0.1, 1 / 3, -2.5), (0.1, 0.2, 0.3, 0.9)), closure=0.7, radius=0.05)},
    wind=Wind(velocity=(1e-17, -3.3, 0.1), gust_intensity=0.2, gust_seed=9),
    obstacles={"ball": Pose((2 / 3, 0.0, -0.0))},
    groups={"left": Pose((0.1, 0.2, 1 / 3), (0.0, 0.6, 0.0, 0.8))},
    rest_scale={"left": 0.7, "top": 1 / 3},
    gravity=(0.0, 0.1, -9.81),
)


def test_a_step_comes_back_to_the_last_bit():
    step = Step(417, INPUTS, (3, 1, 2), "0123456789abcdef")
    assert Step.decode(step.encode()) == step


def test_an_event_comes_back_with_its_details():
    event = Event("pause", 12, {"by": "operator", "seconds": 0.1})
    assert Event.decode(event.encode()) == event


def test_a_snapshot_comes_back_bit_equal():
    arrays = {
        "position": np.array([[np.nan, -0.0, 1 / 3]]),
        "pinned": np.zeros(0, np.int32),
        "grip_vertex/a": np.arange(3),
    }
    back = Snapshot.decode(Snapshot(50, arrays).encode())
    assert back.index == 50
    assert back.arrays.keys() == arrays.keys()
    for name, array in arrays.items():
        assert back.arrays[name].dtype == array.dtype
        assert back.arrays[name].tobytes() == array.tobytes()


def test_the_scene_comes_back_as_it_was_simulated(cloth_session):
    session = cloth_session()
    scene = RecordedSession(session.close()).scene
    assert scene.material == session.scene.material
    assert scene.solver == session.scene.solver
    assert scene.obstacles == session.scene.obstacles
    assert scene.inputs == session.scene.inputs
    assert scene.text == session.scene.text
    assert scene.mesh.digest == session.scene.mesh.digest
    assert {name: list(members) for name, members in scene.mesh.groups.items()} == {
        name: list(members) for name, members in session.scene.mesh.groups.items()
    }
    assert scene.build()[1].digest == session.scene.build()[1].digest


def test_overrides_of_the_solver_win_over_the_scene_file(tmp_path):
    from dataclasses import replace

    scene = Scene.parse("cloth: {grid: {width: 1, height: 1, columns: 4, rows: 4}}\nmaterial: {shear: 10.0}")
    overridden = replace(scene, material=replace(scene.material, shear=77.5), solver=replace(scene.solver, dt=0.01))
    Recorder.open(tmp_path / "s", overridden, {}, overridden.build()[0], "/cloth_sim").close()
    back = RecordedSession(tmp_path / "s").scene
    assert (back.material.shear, back.solver.dt) == (77.5, 0.01)


def test_entries_come_in_the_order_in_which_they_happened(cloth_session):
    session = cloth_session()
    session.run(4, snapshot_every=2)
    session.reset()
    session.run(1)
    recorded = RecordedSession(session.close())
    order = [(type(entry).__name__, entry.index) for _, entry in recorded.entries()]
    steps = [("Step", 1), ("Step", 2), ("Snapshot", 2), ("Step", 3), ("Step", 4), ("Snapshot", 4)]
    assert order == [("Snapshot", 0), *steps, ("Event", 4), ("Snapshot", 0), ("Step", 1)]
    assert [event.kind for event in recorded.events()] == ["reset"]


@pytest.mark.parametrize(("record", "clouds", "markers"), [("inputs", 0, 0), ("outputs", 3, 0), ("all", 3, 1)])
def test_outputs_are_recorded_as_chosen(cloth_session, record, clouds, markers):
    session = cloth_session(record=record)
    session.recorder.output("/cloth_sim/cloth/mesh", "visualization_msgs/msg/Marker", b"\0\1\0\0", 1)
    session.run(3)
    recorded = RecordedSession(session.close())
    assert len(list(recorded.outputs("cloth/points"))) == clouds
    assert len(list(recorded.outputs("cloth/mesh"))) == markers
    assert len(list(recorded.steps())) == 3


def test_raw_inputs_are_recorded_byte_for_byte(cloth_session):
    session = cloth_session()
    session.recorder.raw_input("/cloth_sim/note", "std_msgs/msg/String", encode_string("as it came"), 123)
    (record,) = RecordedSession(session.close()).outputs("note")
    assert (record.cdr, record.log_time_ns) == (encode_string("as it came"), 123)


def test_the_metadata_says_what_was_simulated_with_what(cloth_session):
    about = RecordedSession(cloth_session().close()).about
    assert about["vertices"] == "81"
    assert about["dt"] == "0.02"
    assert about["numpy"] == np.__version__
    assert about["representation"] == "dense"


def test_the_node_s_parameters_are_kept(cloth_session):
    document = json.loads(RecordedSession(cloth_session().close()).reader.attachments["parameters.json"])
    assert document["parameters"] == {"rate": 50}


def test_a_bag_of_something_else_is_refused_with_its_path(tmp_path):
    with SessionWriter(tmp_path / "bag") as writer:
        writer.write("/chatter", "std_msgs/msg/String", encode_string("hello"), 1)
    with pytest.raises(SessionError, match=r"bag.*not a session of the cloth simulation"):
        RecordedSession(tmp_path / "bag")


def test_a_session_of_a_newer_format_is_refused(cloth_session, tmp_path):
    reader = RecordedSession(cloth_session().close()).reader
    about = {**reader.metadata["cloth_sim"], "format": "2"}
    SessionWriter(tmp_path / "new", attachments=reader.attachments, metadata={"cloth_sim": about}).close()
    with pytest.raises(SessionError, match="format 2"):
        _ = RecordedSession(tmp_path / "new").scene


def test_a_session_with_another_mesh_is_refused(cloth_session, tmp_path):
    reader = RecordedSession(cloth_session().close()).reader
    about = {**reader.metadata["cloth_sim"], "mesh_digest": "0" * 64}
    SessionWriter(tmp_path / "other", attachments=reader.attachments, metadata={"cloth_sim": about}).close()
    with pytest.raises(SessionError, match="mesh"):
        _ = RecordedSession(tmp_path / "other").scene


def test_a_damaged_step_is_named(cloth_session, tmp_path):
    session = cloth_session()
    session.recorder.raw_input("/cloth_sim/session/step", Step.type_name, encode_string("{not json"), 77)
    with pytest.raises(SessionError, match=r"/cloth_sim/session/step at 77 ns is damaged"):
        list(RecordedSession(session.close()).entries())


def test_an_unknown_choice_of_what_to_record_is_refused(cloth_session):
    for record in ("none", "some"):
        with pytest.raises(ValueError, match=f"{record}.*inputs, outputs, all"):
            cloth_session(record=record)
    assert RECORD[0] == "none"


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    scene = Scene.parse("cloth: {grid: {width: 1, height: 1, columns: 4, rows: 4}}")
    with pytest.raises(SessionError, match=str(blocked)):
        Recorder.open(blocked / "session", scene, {}, scene.build()[0], "/cloth_sim")


def test_a_namespace_of_its_own_is_kept(tmp_path: Path):
    scene = Scene.parse("cloth: {grid: {width: 1, height: 1, columns: 4, rows: 4}}")
    solver, state = scene.build()
    recorder = Recorder.open(tmp_path / "s", scene, {}, solver, "/left/cloth")
    recorder.snapshot(solver.snapshot(state), 0, 5)
    recorder.close()
    session = RecordedSession(tmp_path / "s")
    assert session.bookkeeping >= {"/left/cloth/session/step"}
    assert [snapshot.index for snapshot in session.snapshots()] == [0]


def test_settings_in_a_session_are_checked_again(cloth_session, tmp_path):
    reader = RecordedSession(cloth_session().close()).reader
    document = json.loads(reader.attachments["parameters.json"])
    document["scene"]["material"]["areal_density"] = -1.0
    changed = {**reader.attachments, "parameters.json": json.dumps(document).encode()}
    SessionWriter(tmp_path / "odd", attachments=changed, metadata=reader.metadata).close()
    with pytest.raises(SessionError, match="areal_density"):
        _ = RecordedSession(tmp_path / "odd").scene


def test_meshes_of_obstacles_come_back_without_their_files(tmp_path):
    """A mesh alone and one in a compound: distances are the same to the last bit, though the file is gone."""
    file = tmp_path / "ball.ply"
    bodies.as_trimesh(bodies.ball(100.0)).export(file)
    mesh = "voxel_field: {path: ball.ply, scale: 0.001, center: [0.1, 0, 0]"
    scene = Scene.parse(
        "cloth: {grid: {width: 0.4, height: 0.4, columns: 4, rows: 4}}\nobstacles:\n"
        f"  ball: {{{mesh}, voxel: 0.02}}}}\n"
        f"  two: {{compound: {{voxel: 0.02, parts: {{a: {{{mesh}}}}}, b: {{box: {{extents: [0.2, 0.1, 0.1]}}}}}}}}}}\n",
        folder=tmp_path,
    )
    solver, _ = scene.build()
    attachments, about = attachments_of(scene, solver, {}), metadata_of(scene, solver, "/a", "inputs")["cloth_sim"]
    file.unlink()
    back = scene_from(attachments, about)
    points = np.random.default_rng(0).uniform(-0.3, 0.3, (200, 3))
    for name, obstacle in scene.obstacles.items():
        assert back.obstacles[name].pose == obstacle.pose
        for one, other in zip(
            back.obstacles[name].field.distance(points), obstacle.field.distance(points), strict=True
        ):
            np.testing.assert_array_equal(one, other)


def test_the_pieces_of_a_scene_and_their_groups_come_back(tmp_path):
    grid = "grid: {width: 0.3, height: 0.3, columns: 4, rows: 4}"
    scene = Scene.parse(f"cloth: {{towel: {{{grid}}}, napkin: {{{grid}, position: [0, 0, 0.1]}}}}")
    solver, _ = scene.build()
    Recorder.open(tmp_path / "s", scene, {}, solver, "/cloth_sim").close()
    back = RecordedSession(tmp_path / "s").scene.mesh
    assert back.digest == scene.mesh.digest
    for kept, given in ((back.pieces, scene.mesh.pieces), (back.groups, scene.mesh.groups)):
        assert {n: m.tolist() for n, m in kept.items()} == {n: m.tolist() for n, m in given.items()}


@pytest.mark.parametrize("name", ["gripper", "river", "scarf"])
def test_nothing_of_a_scene_but_its_script_is_forgotten(name):
    scene = Scene.load(find_scene(name))
    solver, _ = scene.build()
    attachments, about = attachments_of(scene, solver, {}), metadata_of(scene, solver, "/a", "inputs")["cloth_sim"]
    back = scene_from(attachments, about)
    for field in dataclasses.fields(Scene):
        if field.name not in ("mesh", "script"):
            assert getattr(back, field.name) == getattr(scene, field.name), field.name
    assert back.mesh.digest == scene.mesh.digest
    assert back.build()[0].grippers == solver.grippers
