"""A session simulated with other parameters beside what was recorded."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_core import SettingError
from cloth_sim_ros import replay
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.recording.verify import verify
from cloth_sim_ros.recording.what_if import parse_changes, report, what_if


@pytest.fixture
def path(cloth_session):
    session = cloth_session()
    session.run(30)
    session.reset()
    session.run(20)
    return session.close()


def test_without_a_change_nothing_comes_apart(path):
    moments = what_if(RecordedSession(path), {})
    assert [moment.step for moment in moments] == [*range(1, 31), *range(1, 21)]
    assert max(moment.largest for moment in moments) == 0.0
    assert all(moment.stretch[0] == moment.stretch[1] for moment in moments)


def test_a_change_is_simulated_with_the_same_inputs_and_its_distance_told(path):
    changes = parse_changes(["material.areal_density=1.5", "solver.substeps=4"])
    moments = what_if(RecordedSession(path), changes)
    farthest = max(moments, key=lambda moment: moment.largest)
    assert 1e-3 < farthest.largest < 0.5
    assert all(moment.rms <= moment.largest for moment in moments)
    assert f"vertex {farthest.vertex}, step {farthest.step}" in report(moments)
    assert len(report(moments, rows=5).splitlines()) == 7


def test_both_begin_anew_after_a_reset(path):
    moments = what_if(RecordedSession(path), {"material.areal_density": 1.5})
    assert moments[30].largest < 0.1 * max(moment.largest for moment in moments[:30])


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("material.frition=1", "material.friction"),
        ("solver.dt=0.01", "cannot|can be changed"),
        ("friction=1", "can be changed"),
        ("material.friction", "key=value"),
        ("material.friction=high", "0 .. 10"),
        ("material.friction=11", "0 .. 10"),
        ("solver.integrator=euler", "meyer2000"),
    ],
)
def test_a_change_that_means_nothing_is_refused_with_what_would_be_allowed(text, part):
    with pytest.raises(SettingError, match=part):
        parse_changes([text])


def test_the_command_prints_the_table_and_refuses_in_one_line(path, capsys):
    assert replay.main([str(path), "--what-if", "material.friction=1.0"]) == 0
    printed = capsys.readouterr().out
    assert "material.friction = 1.0" in printed
    assert "farthest apart" in printed
    assert replay.main([str(path), "--what-if", "material.friction=-1"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_part_is_verified_from_its_first_snapshot_on(cloth_session, tampered):
    session = cloth_session()
    session.run(40)  # snapshots at 0, 10, 20, 30, 40
    recorded = RecordedSession(session.close())
    first, last = recorded.reader.times_ns
    assert (first, last) == (1_000_000_000, 1_800_000_000)
    recorded.window_ns = (first + 300_000_000, first + 640_000_000)
    result = verify(recorded)
    assert result.bit_equal
    assert (result.steps, result.snapshots) == (12, 2)  # from 0.4 s, which is step 20, to step 32


def test_nothing_between_from_and_to_is_said_with_the_length(path, capsys):
    assert replay.main([str(path), "--verify", "--from", "90"]) == 2
    assert "it is 1.00 s long" in capsys.readouterr().err


def test_a_cut_off_session_is_recovered_by_the_command(path, tmp_path, capsys):
    (file,) = path.glob("*.mcap")
    cut = tmp_path / "cut"
    cut.mkdir()
    (cut / "cut_0.mcap").write_bytes(file.read_bytes()[:-10])
    assert replay.main([str(cut), "--recover"]) == 0
    assert "cut_recovered" in capsys.readouterr().out
    recovered = RecordedSession(tmp_path / "cut_recovered")
    assert recovered.complete
    assert len(list(recovered.steps())) > 0
    assert np.isfinite(next(recovered.snapshots()).arrays["position"]).all()
