"""The benchmark beside other engines: ours really runs in its harness, and the gate knows good from bad."""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))
sys.path.append(str(Path(__file__).parents[2] / "benchmarks" / "peers"))

import metrics
import table
import workload
from comparison import gate, machine, plan, plot, process, report

BY_NAME = {contestant.name: contestant for contestant in plan.CONTESTANTS}
MEYER, FMS, PYPBD, ELASTIC, IPC = (
    BY_NAME[name] for name in ("ours meyer2000", "fms scipy", "pypbd xpbd", "mujoco elastic", "mujoco ipc")
)
MACHINE = {"date": "today", "cpu": "abacus", "cores": 2, "load": 0.0, "system": "Linux"} | dict.fromkeys(
    ("python", "numpy", "scipy", "numba"), "1.0"
)
GOOD = {
    "hang": {"com_z_0.5": 0.98, "stretch_end_max": 0.031, "stretch_end_p99": 0.01},
    "drape": {"com_z_0.16": 0.622, "stretch_end_max": 0.03, "pen_max_mm": 3.0, "pen_end_mm": -5.0, "self_x": 4},
    "selfcol": {"com_z_0.16": 0.622, "stretch_end_max": 0.03, "pen_max_mm": 3.0, "pen_end_mm": -5.0, "self_x": 0},
    "drag": {"stretch_end_max": 0.03},
}


def a_result(contestant: plan.Contestant, scenario: str, n: int = 50, ms: float = 10.0, **changes: object) -> dict:
    """A run to its end that passes the gate, but for the changes."""
    who = {"engine": contestant.engine, "variant": contestant.variant, "scenario": scenario, "n": n, "status": "ok"}
    measured = {"finite_end": True, "ms_median": ms, "ms_p95": 1.5 * ms, "stretch_max_run": 0.045, "speed_end": 0.1}
    return {**who, **measured, **GOOD[scenario], **changes}


def a_document(*results: dict) -> dict:
    return {"machine": MACHINE, "how": {"threads": 1, "repeats": 3}, "results": list(results)}


def cells(text: str, n: int) -> list[str]:
    """The row of the table that is for ``n`` vertices a side."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    (row,) = (row for row in rows if row[0] == str(n))
    return row


@pytest.mark.parametrize(("scenario", "frames"), [("hang", 26), ("drape", 12), ("drag", 6)])
def test_ours_runs_in_the_harness_and_passes_the_gate(scenario, frames):
    result = process.play(plan.Job(plan.OURS, scenario, 8), frames=frames)
    assert result["status"] == "ok", result
    assert gate.faults(result) == []
    assert (result["frames"], result["truncated_at_s"]) == (frames - 1, round(0.02 * frames, 3))
    assert -0.5 < result["stretch_end_mean"] <= result["stretch_max_run"] < 0.5
    assert 0 < result["ms_p10"] <= result["ms_median"] <= result["ms_p95"]
    # Pinned corners and the corner in the hand are where the scene wants them.
    assert result.get("grasp_err_m", 0.0) < 1e-9
    assert ("grasp_err_m" in result) == (scenario != "drape")


def test_the_gate_catches_the_molasses_of_the_paper():
    result = process.play(plan.Job(MEYER, "hang", 8), frames=26)
    (fault,) = gate.faults(result)
    assert fault.startswith(f"mean height at 0.5 s {result['com_z_0.5']:.3f} m, +")
    assert "(at most 10)" in fault


def test_an_engine_that_fails_says_why_and_a_peer_that_is_missing_is_no_error(monkeypatch, tmp_path):
    failed = process.play(plan.Job(plan.OURS, "drape", 1), frames=3)
    assert failed["status"].startswith(("error: ", "crashed (exit "))
    assert gate.faults(failed) == [failed["status"]]

    monkeypatch.setattr(process, "ENVIRONMENTS", tmp_path)
    missing = process.play(plan.Job(PYPBD, "drape", 8))
    assert missing["status"] == "not installed"
    text = report.report(a_document(a_result(plan.OURS, "drape"), missing))
    assert text.endswith("not installed (make peers): pypbd")
    assert "pypbd xpbd" not in text


@pytest.mark.parametrize("scenario", GOOD)
def test_a_good_run_has_no_faults(scenario):
    assert gate.faults(a_result(PYPBD, scenario)) == []


@pytest.mark.parametrize(
    ("scenario", "changes", "fault"),
    [
        ("hang", {"com_z_0.5": 0.97 * 1.11}, "mean height at 0.5 s 1.077 m, +11.0 % off free fall (at most 10)"),
        ("hang", {"com_z_0.5": 0.97 * 0.89}, "mean height at 0.5 s 0.863 m, -11.0 % off free fall (at most 10)"),
        ("hang", {"stretch_end_max": 0.101}, "stretch max 10.1 % (at most 10)"),
        ("hang", {"stretch_end_p99": 0.021}, "stretch p99 2.1 % (at most 2)"),
        ("drape", {"com_z_0.16": 0.637}, "mean height at 0.16 s 0.637 m, +2.1 % off free fall (at most 2)"),
        ("drape", {"pen_max_mm": 10.1}, "10.1 mm into the sphere (at most 10)"),
        ("drape", {"pen_end_mm": 0.2}, "0.2 mm inside the sphere at the end (at most 0)"),
        ("selfcol", {"self_x": 3}, "3 self-crossings at the end (at most 0)"),
        ("drag", {"explosion": "NaN", "bad_at_s": 0.6}, "exploded at 0.60 s (NaN)"),
        ("drag", {"status": "killed after 240 s"}, "killed after 240 s"),
    ],
)
def test_a_bad_run_is_named_with_its_number(scenario, changes, fault):
    assert gate.faults(a_result(PYPBD, scenario, **changes)) == [fault]


def test_what_shows_at_rest_only_is_not_held_against_a_run_that_was_stopped_early():
    early = {"truncated_at_s": 1.0, "stretch_end_max": 0.4, "stretch_end_p99": 0.3}
    assert gate.faults(a_result(PYPBD, "hang", **early)) == []
    assert gate.faults(a_result(PYPBD, "drape", truncated_at_s=1.0, pen_end_mm=4.0)) == []
    assert gate.faults(a_result(PYPBD, "drape", truncated_at_s=1.0, pen_max_mm=40.0)) != []
    unjudged = a_result(PYPBD, "hang", truncated_at_s=0.2)
    del unjudged["com_z_0.5"]
    assert gate.faults(unjudged) == ["stopped before 0.5 s: its fall cannot be judged"]


def test_ours_is_compared_with_the_fastest_peer_that_passes():
    results = [
        a_result(plan.OURS, "drape", ms=4.0),
        a_result(FMS, "drape", ms=5.0),  # the lower bound is not counted
        a_result(PYPBD, "drape", ms=20.0, pen_max_mm=12.0),
        a_result(ELASTIC, "drape", ms=30.0),
        a_result(IPC, "drape", ms=90.0),
    ]
    row = cells(report.frame_table(results, "drape"), 50)
    assert row[1:6] == ["4.00 / 6.00", "5.00 / 7.50", "20.0 / 30.0 x", "30.0 / 45.0", "90.0 / 135.0"]
    assert row[6:] == ["4 / 2", "bar", "7.5 mujoco elastic", "6 / 20", "bar"]
    assert cells(report.frame_table(results[:3], "drape"), 50)[-3] == "no peer passes"
    assert cells(report.frame_table(results[1:], "drape"), 50)[-3] == "-"
    assert cells(report.frame_table([a_result(plan.OURS, "drape", pen_max_mm=12.0), *results[1:]], "drape"), 50)[
        -3
    ] == ("ours fails")


def test_stretch_stands_beside_its_bar_and_aim():
    results = [
        a_result(plan.OURS, "hang", stretch_max_run=0.0399, stretch_end_max=0.0401),
        a_result(plan.OURS, "drape", n=71, stretch_max_run=0.0601, stretch_end_max=0.0329),
        a_result(plan.OURS, "drag", n=100, stretch_max_run=0.0799),
    ]
    text = report.stretch_table(results)
    rows = {n: [cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]
            for n in [line.split("|")[2].strip()]}  # fmt: skip
    assert rows["50"][2:8] == ["+0.0099", "0.03 / 0.01", "aim", "+0.0101", "0.01 / 0.003", "MISSED"]
    assert rows["71"][2:8] == ["+0.0301", "0.03 / 0.01", "MISSED", "+0.0029", "0.01 / 0.003", "aim"]
    assert rows["100"][2:8] == ["+0.0499", "0.05 / 0.02", "bar", "+0.0000", "", ""]


def test_repeats_are_merged_by_their_medians_and_a_failure_is_not_hidden():
    runs = [a_result(PYPBD, "drape", ms=ms) for ms in (9.0, 50.0, 10.0)]
    assert process.merged(runs)["ms_median"] == 10.0
    assert process.merged(runs)["repeats"] == 3
    crashed = {**runs[0], "status": "crashed (exit 139): no message"}
    assert process.merged([runs[0], crashed, runs[1]])["status"] == crashed["status"]


def test_results_survive_the_file_and_can_be_drawn(tmp_path):
    results = [a_result(c, s, n=n, ms=n / 10) for c in (plan.OURS, PYPBD) for s in ("hang", "drape") for n in (20, 50)]
    document = a_document(*results, a_result(ELASTIC, "hang", explosion="NaN", bad_at_s=0.1, stretch_max_run=np.inf))
    table.save(document, tmp_path / "results" / "table.json")
    assert json.loads((tmp_path / "results" / "table.json").read_text()) == document
    drawn = plot.draw(document, tmp_path / "bench.svg")
    assert drawn == (importlib.util.find_spec("matplotlib") is not None)
    assert not drawn or "</svg>" in (tmp_path / "bench.svg").read_text()


def test_the_machine_is_described_by_what_the_report_names():
    described = machine.describe()
    assert described.keys() == MACHINE.keys()
    assert described["cpu"] and 1 <= described["cores"] <= 4096
    assert 0.0 <= described["load"] <= described["cores"] + 0.5


def test_a_round_gives_everyone_the_same_work_in_turns():
    order = list(plan.jobs(plan.ENGINES, ("hang", "drape"), (20, 200)))
    assert [job.contestant.name for job in order if (job.scenario, job.n) == ("drape", 20)] == list(BY_NAME)
    assert {job.contestant for job in order if job.n == 200} == set(plan.CONTESTANTS) - {IPC}
    assert [job.n for job in order] == sorted(job.n for job in order)


@pytest.mark.parametrize(("name", "height"), [("hang", 1.5), ("drape", 0.75), ("drag", 1.6)])
def test_the_order_of_an_engine_is_found_by_where_its_vertices_stand(name, height):
    scene = workload.Scene(name, 9)
    assert scene.start[:, 2] == pytest.approx(height)
    shuffled = np.random.default_rng(1).permutation(81)
    order = metrics.canonical_order(scene, scene.start[shuffled])
    np.testing.assert_array_equal(shuffled[order], np.arange(81))
    assert metrics.stretch(scene, scene.start) == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ValueError, match="does not start in its place"):
        metrics.canonical_order(scene, scene.start + 0.1)


def test_crossings_of_the_cloth_with_itself_are_counted():
    scene = workload.Scene("drape", 11)
    assert metrics.self_crossings(scene, scene.start) == 0
    folded = scene.start.copy()
    far = folded[:, 0] > folded[:, 0].mean() + 0.051
    folded[far, 0] -= 2.0 * (folded[far, 0] - folded[:, 0].mean() - 0.05)  # folded back, in touch with nothing yet
    folded[far, 2] += 0.03
    assert metrics.self_crossings(scene, folded) == 0
    folded[60 + 11 * 3, 2] -= 0.05  # a vertex of the upper layer is pushed through the lower one
    assert metrics.self_crossings(scene, folded) > 0
