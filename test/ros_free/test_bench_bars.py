"""The table of bars: a verdict follows the figure, failed runs miss, and the file has what was printed."""

from __future__ import annotations

import json
import sys
from math import nan
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

import bars
from comparison import machine, plan, process
from marks.measure import PARTS, rows_of_result
from marks.row import HEADER, Row, table
from motion import measure
from motion.cloth import release_test
from table import save


@pytest.mark.parametrize(
    ("value", "reached"), [(0.0, "aim"), (2.0, "aim"), (2.001, "bar"), (4.0, "bar"), (4.001, "MISSED"), (nan, "MISSED")]
)
def test_the_verdict_is_that_of_the_figure(value, reached):
    assert Row("frame", "ms", 4.0, 2.0, value).reached == reached


def test_where_none_may_be_missed_one_is_too_many():
    assert [Row("slots missed", "", 0.0, 0.0, missed).reached for missed in (0.0, 1.0)] == ["aim", "MISSED"]


def test_the_table_has_a_line_for_each_row_with_units_and_the_shortest_time():
    rows = [Row("frame", "ms", 4.0, 2.0, 5.874, least=3.446), Row("memory", "MB", 400.0, 250.0, 231.3, note="hang")]
    header, rule, *lines = table(rows).splitlines()
    assert [[cell.strip() for cell in line.strip("|").split("|")] for line in (header, *lines)] == [
        list(HEADER),
        ["frame", "4", "2", "5.87 ms", "3.45", "MISSED"],
        ["memory (hang)", "400", "250", "231 MB", "", "aim"],
    ]
    assert len(rule) == len(header)


def a_run(scenario: str, n: int, **changes: object) -> dict:
    measured = {"ms_median": 10.0, "ms_min": 8.0, "stretch_max_run": 0.042, "stretch_end_max": 0.021}
    return {"scenario": scenario, "n": n, "status": "ok"} | measured | changes


def test_a_run_gives_its_stretch_over_the_limit_and_its_frame():
    worst, end, frame = rows_of_result(a_run("hang", 100))
    assert (worst.value, worst.reached) == (pytest.approx(0.012), "bar")
    assert (end.value, end.reached) == (0.0, "aim")  # nothing is longer than allowed
    assert (frame.value, frame.least, frame.reached) == (10.0, 8.0, "bar")
    assert len(list(rows_of_result(a_run("hang", 20)))) == 2  # no bar for so few vertices
    (dragged,) = rows_of_result(a_run("drag", 100))
    assert (dragged.bar, dragged.aim) == (0.05, 0.02)


def test_a_run_that_failed_or_did_not_end_misses_and_says_why():
    crashed = {"scenario": "drape", "n": 50, "status": "crashed (exit 139): no message"}
    for row in rows_of_result(crashed):
        assert (row.reached, row.note) == ("MISSED", crashed["status"])
    worst, end, frame = rows_of_result(a_run("drape", 50, ms_median=1.0, truncated_at_s=1.2))
    assert (worst.note, end.note, frame.note) == ("stopped early",) * 3
    assert (worst.reached, end.reached, frame.reached) == ("bar", "MISSED", "aim")  # what is at rest is not known


def test_a_real_run_gives_figures():
    rows = list(rows_of_result(process.play(plan.Job(plan.OURS, "hang", 8), frames=20)))
    assert [row.note for row in rows] == ["stopped early"] * 2
    assert 0.0 <= rows[0].value < 0.05


def test_the_solves_of_a_frame_are_counted():
    cloth = release_test(200.0, side=6)
    assert measure.solves_of_solver(cloth, 5, 2) == 10.0
    assert measure.solves_of_solver(cloth, 0, 0) == 8.0  # one for every 2.5 ms, nothing bends


def test_as_it_comes_the_solver_plays_with_its_own_substeps():
    cloth = release_test(200.0, side=6)
    own, eight, ten = (
        measure.play(cloth, measure.frames_of_solver(cloth, *split)) for split in ((0, 0), (8, 1), (10, 1))
    )
    assert (own.height == eight.height).all()
    assert not (own.height == ten.height).all()


def test_the_file_has_the_rows_the_verdicts_and_the_machine(tmp_path):
    described = machine.describe()
    rows = [Row("frame", "ms", 4.0, 2.0, 5.874, least=3.446), Row("memory", "MB", 400.0, 250.0, 231.3)]
    save(bars.document(described, rows, 2), tmp_path / "bars.json")
    written = json.loads((tmp_path / "bars.json").read_text())
    assert written["machine"] == described
    assert [(row["what"], row["value"], row["reached"]) for row in written["results"]] == [
        ("frame", 5.874, "MISSED"),
        ("memory", 231.3, "aim"),
    ]
    assert described["cpu"] in machine.sentence(described)
    assert ("NOT QUIET" in machine.sentence(described)) is (described["load"] > machine.QUIET)


def test_parts_can_be_asked_for_one_by_one(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["bars.py", "--only", "memory", "start", "--large"])
    options = bars._options()
    assert (options.only, options.large) == (["memory", "start"], True)
    assert options.only[0] in PARTS
