"""The tables: stretch of ours, time of a frame beside the peers, and who fails the quality gate by what."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from comparison import machine
from comparison.gate import faults, stopped_early
from comparison.plan import CONTESTANTS, OURS, SCENARIOS, Contestant
from comparison.process import NOT_INSTALLED

STRETCH_LIMIT = 0.03
# Scenario: bar and aim of the excess over the limit in the whole run; at the end it is the same for both scenarios.
WORST_STRETCH = {"hang": (0.03, 0.01), "drape": (0.03, 0.01), "drag": (0.05, 0.02)}
STRETCH_AT_REST = {"hang": (0.01, 0.003), "drape": (0.01, 0.003)}
# Vertices a side: bar and aim of a frame in ms on two cores, of hang and drape.
FRAME_MS = {50: (4.0, 2.0), 100: (16.0, 8.0), 200: (120.0, 40.0)}
FASTER, FASTER_SIZES, FASTER_SCENARIOS = (6.0, 20.0), (50, 71, 100), ("hang", "drape")

MARKS = ("bar / aim", "reached")

Results = Sequence[dict[str, Any]]


def report(document: dict[str, Any]) -> str:
    """Everything there is to read in a document of results, as Markdown."""
    results = document["results"]
    scenarios = list(dict.fromkeys(result["scenario"] for result in results))
    missing = list(dict.fromkeys(r["engine"] for r in results if r["status"] == NOT_INSTALLED))
    parts = [_machine(document), "## Stretch of ours over its limit", stretch_table(results)]
    for scenario in scenarios:
        parts += [f"## A frame of {scenario}: ms, median / p95", frame_table(results, scenario)]
    parts += ["x: fails the gate on quality. ~: stopped early.", *_failures(results)]
    parts += [f"not installed (make peers): {', '.join(missing)}"] if missing else []
    return "\n\n".join(parts)


def stretch_table(results: Results) -> str:
    """How far the longest edge exceeds the limit, in the whole run and at its end, beside bar and aim."""
    header = ("scenario", "n", "worst", *MARKS, "at the end", *MARKS, "speed at the end, m/s")
    ours = [result for result in results if of(result) == OURS and "stretch_end_max" in result]
    rows = []
    for result in sorted(ours, key=lambda result: (SCENARIOS.index(result["scenario"]), result["n"])):
        early, scenario = stopped_early(result), result["scenario"]
        worst, end = (result[key] - STRETCH_LIMIT for key in ("stretch_max_run", "stretch_end_max"))
        in_run = _compared(worst, WORST_STRETCH.get(scenario), "~" if early else "")
        at_end = ("-", "", "") if early else _compared(end, STRETCH_AT_REST.get(scenario))
        rows.append((scenario, result["n"], *in_run, *at_end, f"{result['speed_end']:.2f}"))
    return markdown(header, rows)


def frame_table(results: Results, scenario: str) -> str:
    """The time of a frame of everyone, ours against its bars, and how much faster than the fastest good peer."""
    here = [r for r in results if r["scenario"] == scenario and r["status"] != NOT_INSTALLED]
    shown = [contestant for contestant in CONTESTANTS if any(of(result) == contestant for result in here)]
    names = [contestant.name for contestant in shown]
    header = ("n", *names, "two cores: bar / aim", "reached", "times faster", *MARKS)
    rows = []
    for n in sorted({result["n"] for result in here}):
        by = {of(result): result for result in here if result["n"] == n}
        rows.append((n, *(_time(by.get(contestant)) for contestant in shown), *_bars(by, n), *_lead(by, n)))
    return markdown(header, rows)


def fastest_peer(by: dict[Contestant, dict[str, Any]]) -> Contestant | None:
    """Of those that count and pass the gate."""
    good = [c for c, result in by.items() if c.counted and not c.ours and not faults(result)]
    return min(good, key=lambda contestant: by[contestant]["ms_median"], default=None)


def of(result: dict[str, Any]) -> Contestant:
    """Whose result it is."""
    return next(c for c in CONTESTANTS if (c.engine, c.variant) == (result["engine"], result["variant"]))


def markdown(header: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """A table that reads well as it stands, too."""
    cells = [[str(cell) for cell in row] for row in (header, *rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(header))]
    lines = [
        "| " + " | ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in cells
    ]
    return "\n".join([lines[0], "|" + "|".join("-" * (width + 1) + ":" for width in widths) + "|", *lines[1:]])


def verdict(value: float, bar: float, aim: float) -> str:
    """Whether ``value`` reaches the aim, the bar or neither; the smaller of the two says which way is good."""
    better = (lambda mark: value <= mark) if aim < bar else (lambda mark: value >= mark)
    return "aim" if better(aim) else "bar" if better(bar) else "MISSED"


def _compared(value: float, marks: tuple[float, float] | None, note: str = "") -> tuple[str, str, str]:
    shown = f"{value:+.4f}{note}"
    return (shown, f"{marks[0]:g} / {marks[1]:g}", verdict(value, *marks)) if marks else (shown, "", "")


def _time(result: dict[str, Any] | None) -> str:
    if result is None:
        return "-"
    if "ms_median" not in result:
        return "x"
    marks = ("~" if stopped_early(result) else "") + (" x" if faults(result) else "")
    return f"{_ms(result['ms_median'])} / {_ms(result['ms_p95'])}{marks}"


def _ms(time: float) -> str:
    return f"{time:.2f}" if time < 10 else f"{time:.1f}"


def _bars(by: dict[Contestant, dict[str, Any]], n: int) -> tuple[str, str]:
    result = by.get(OURS)
    if result is None or "ms_median" not in result or n not in FRAME_MS or result["scenario"] not in FASTER_SCENARIOS:
        return "", ""
    bar, aim = FRAME_MS[n]
    return f"{bar:g} / {aim:g}", verdict(result["ms_median"], bar, aim)


def _lead(by: dict[Contestant, dict[str, Any]], n: int) -> tuple[str, str, str]:
    """How many times faster ours is, the bar and aim of it, and the verdict."""
    ours, peer = by.get(OURS), fastest_peer(by)
    if ours is None:
        return "-", "", ""
    if faults(ours):
        return "ours fails", "", ""
    if peer is None:
        return "no peer passes", "", ""
    ratio = by[peer]["ms_median"] / ours["ms_median"]
    lead = f"{ratio:.1f} {peer.name}"
    if n not in FASTER_SIZES or ours["scenario"] not in FASTER_SCENARIOS:
        return lead, "", ""
    return lead, f"{FASTER[0]:g} / {FASTER[1]:g}", verdict(ratio, *FASTER)


def _failures(results: Results) -> list[str]:
    lines = [
        f"* {of(result).name}, {result['scenario']} {result['n']}: {'; '.join(wrong)}"
        for result in results
        if result["status"] != NOT_INSTALLED and (wrong := faults(result))
    ]
    return ["\n".join(lines)] if lines else []


def _machine(document: dict[str, Any]) -> str:
    how = document["how"]
    threads = f"{how['threads']} core" + ("s" if how["threads"] > 1 else "")
    return (
        f"{machine.sentence(document['machine'])} Each run in a process of its own on {threads}, one at a time; "
        f"medians of {how['repeats']} interleaved repeats."
    )
