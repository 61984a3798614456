from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cloth_core import Wind
from cloth_sim_ros import replay
from cloth_sim_ros.recording.content import Snapshot, Step, in_force
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify
from cloth_sim_ros.session import SessionError


def nudged(arrays, name, vertex, by):
    """The snapshot's arrays with the x of one vertex moved."""
    changed = np.array(arrays[name])
    changed[vertex, 0] += by
    return {**arrays, name: changed}


def with_wind(step, index):
    """The step, with another wind if it is number ``index``."""
    if isinstance(step, Step) and step.index == index:
        return replace(step, inputs=replace(step.inputs, wind=Wind(velocity=(9.0, 0.0, 0.0))))
    return step


def test_a_recorded_session_is_simulated_again_bit_equal(cloth_session):
    session = cloth_session()
    session.run(60)
    result = verify(RecordedSession(session.close()))
    assert result.bit_equal
    assert (result.steps, result.snapshots) == (60, 7)
    assert result.simulated_seconds == pytest.approx(1.2)


def test_the_integrator_of_the_paper_is_simulated_again_bit_equal(cloth_session):
    session = cloth_session(more="solver: {integrator: meyer2000}")
    session.run(30)
    assert verify(RecordedSession(session.close())).bit_equal


def test_a_step_whose_time_was_up_is_repeated_as_it_was(cloth_session):
    session = cloth_session(more="solver: {stretch_sweeps: 12}")
    session.run(30, cut_short_at=25)
    path = session.close()
    sweeps = {step.index: step.sweeps for step in RecordedSession(path).steps()}
    assert sum(sweeps[25]) < sum(sweeps[24])
    assert verify(RecordedSession(path)).bit_equal


def test_reset_and_restore_are_followed(cloth_session):
    session = cloth_session()
    session.run(20)
    earlier = session.solver.snapshot(session.state)  # the hand holds a corner here
    assert len(session.state.held) > 0
    session.run(25)
    session.restore(earlier)
    session.run(10)
    session.recorder.event("pause", session.state.step_index, session.stamp_ns)
    session.recorder.event("resume", session.state.step_index, session.stamp_ns)
    session.run(5)
    session.reset()
    session.run(10)
    result = verify(RecordedSession(session.close()))
    assert result.bit_equal
    assert result.steps == 70


def test_parameters_that_were_changed_under_way_are_followed(cloth_session):
    session = cloth_session()
    session.run(12)
    material = replace(session.solver.material, friction=1.5, areal_density=0.35, bend=1e-3)
    session.solver = session.solver.changed(material=material, config=replace(session.solver.config, substeps=5))
    session.recorder.event("parameters", session.state.step_index, session.stamp_ns, **in_force(session.solver))
    session.run(30)
    path = session.close()
    assert verify(RecordedSession(path)).bit_equal
    assert {len(step.sweeps) for step in RecordedSession(path).steps()} == {8, 5}


def test_parameters_that_mean_nothing_are_named(cloth_session):
    session = cloth_session()
    session.recorder.event("parameters", 0, session.stamp_ns, material={"frition": 1.0}, solver={})
    session.run(2)
    with pytest.raises(SessionError, match=r"parameters after step 0 .*did you mean friction"):
        verify(RecordedSession(session.close()))


def test_a_changed_input_is_found_at_its_step_and_the_vertex_by_the_next_snapshot(cloth_session, tampered):
    session = cloth_session()
    session.run(30)
    result = verify(RecordedSession(tampered(session.close(), lambda entry: with_wind(entry, 13))))
    assert not result.bit_equal
    assert result.first_difference.step == 13
    assert result.first_difference.seen_at == 20
    assert result.first_difference.vertex is not None
    assert result.first_difference.distance > 0
    assert result.steps == 20  # nothing later tells more


def test_recorded_points_name_the_vertex_at_the_very_step(cloth_session, tampered):
    session = cloth_session(record="outputs")
    session.run(30)
    result = verify(RecordedSession(tampered(session.close(), lambda entry: with_wind(entry, 13))))
    assert result.first_difference.step == result.first_difference.seen_at == 13
    assert result.first_difference.distance > 0


def test_without_points_or_a_later_snapshot_only_the_step_is_named(cloth_session, tampered):
    session = cloth_session()
    session.run(18)
    result = verify(RecordedSession(tampered(session.close(), lambda entry: with_wind(entry, 13))))
    assert (result.first_difference.step, result.first_difference.vertex) == (13, None)


@pytest.mark.parametrize(("array", "unit"), [("position", "m"), ("velocity", "m/s")])
def test_a_changed_snapshot_names_step_vertex_and_distance(cloth_session, tampered, array, unit):
    session = cloth_session()
    session.run(30)

    def change(entry):
        if isinstance(entry, Snapshot) and entry.index == 20:
            return Snapshot(20, nudged(entry.arrays, array, 37, 1e-3))
        return entry

    difference = verify(RecordedSession(tampered(session.close(), change))).first_difference
    assert (difference.step, difference.vertex, difference.unit) == (20, 37, unit)
    assert difference.distance == pytest.approx(1e-3)


def test_a_change_of_the_last_bit_is_seen(cloth_session, tampered):
    session = cloth_session()
    session.run(10)

    def change(entry):
        if isinstance(entry, Snapshot) and entry.index == 10:
            position = np.array(entry.arrays["position"])
            position[5, 2] = np.nextafter(position[5, 2], np.inf)
            return Snapshot(10, {**entry.arrays, "position": position})
        return entry

    difference = verify(RecordedSession(tampered(session.close(), change))).first_difference
    assert (difference.step, difference.vertex) == (10, 5)
    assert 0 < difference.distance < 1e-15


def test_a_missing_step_is_named(cloth_session, tampered):
    session = cloth_session()
    session.run(8)

    def change(entry):
        return replace(entry, index=99) if isinstance(entry, Step) and entry.index == 6 else entry

    with pytest.raises(SessionError, match="step 99 follows step 5"):
        verify(RecordedSession(tampered(session.close(), change)))


def test_a_session_without_a_step_proves_nothing(cloth_session):
    with pytest.raises(SessionError, match="no step"):
        verify(RecordedSession(cloth_session().close()))


def test_progress_is_told_step_by_step(cloth_session):
    session = cloth_session()
    session.run(3)
    told = []
    verify(RecordedSession(session.close()), lambda steps, seconds: told.append(steps))
    assert told == [1, 2, 3]


def test_the_command_says_bit_equal_and_exits_0(cloth_session, capsys):
    session = cloth_session()
    session.run(5)
    assert replay.main([str(session.close()), "--verify"]) == 0
    assert capsys.readouterr().out.startswith("bit-equal: 5 steps and 1 snapshots")


def test_the_command_names_the_difference_and_exits_1(cloth_session, tampered, capsys):
    session = cloth_session(record="outputs")
    session.run(15)
    path = tampered(session.close(), lambda entry: with_wind(entry, 7))
    assert replay.main([str(path), "--verify"]) == 1
    assert capsys.readouterr().out.startswith("differs at step 7, vertex ")


def test_the_command_refuses_what_is_no_session_in_one_line_and_exits_2(tmp_path, capsys):
    (tmp_path / "note.mcap").write_text("not a session")
    for path in (tmp_path / "note.mcap", tmp_path / "missing", tmp_path):
        assert replay.main([str(path), "--verify"]) == 2
        complaint = capsys.readouterr().err
        assert complaint.startswith("cloth_replay: ")
        assert str(path) in complaint
        assert complaint.count("\n") == 1


def test_a_cut_off_session_is_verified_as_far_as_it_goes(cloth_session, tmp_path, capsys):
    session = cloth_session(record="outputs")
    session.run(400)
    file = next(session.close().glob("*.mcap"))
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert replay.main([str(cut), "--verify"]) == 0
    printed = capsys.readouterr()
    assert "was cut off" in printed.err
    assert printed.out.startswith("bit-equal: ")
