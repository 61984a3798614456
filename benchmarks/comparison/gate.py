"""Quality before time: what a run must have done right for its time to count.

A cloth that hardly falls, stretches like rubber or sinks into the sphere is cheap to compute. What can only be told at
rest is not held against a run that was stopped early.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

HANG_STRETCH_MAX, HANG_STRETCH_P99 = 0.10, 0.02
DEPTH_AT_IMPACT_MM = 10.0
DEPTH_AT_REST_MM = 0.001  # none; a micrometre is left for rounding
# Scenario: the instant in s, the mean height in m of a cloth that falls freely until then, and how far off is allowed.
FREE_FALL = {"hang": (0.5, 0.97, 0.10), "drape": (0.16, 0.624, 0.02), "selfcol": (0.16, 0.624, 0.02)}


def faults(result: dict[str, Any]) -> list[str]:
    """What is wrong with a run, each with its number; empty where its time counts."""
    if result["status"] != "ok":
        return [result["status"]]
    if "explosion" in result or not result["finite_end"]:
        return [f"exploded at {result['bad_at_s']:.2f} s ({result['explosion']})"]
    return [*_in_motion(result), *([] if stopped_early(result) else _at_rest(result))]


def stopped_early(result: dict[str, Any]) -> bool:
    """Whether time was up before the scenario was over."""
    return "truncated_at_s" in result


def _in_motion(result: dict[str, Any]) -> Iterator[str]:
    if result["scenario"] in FREE_FALL:
        instant, expected, share = FREE_FALL[result["scenario"]]
        height = result.get(f"com_z_{instant:g}")
        if height is None:
            yield f"stopped before {instant:g} s: its fall cannot be judged"
        elif abs(height - expected) > share * expected:
            off = 100 * (height / expected - 1)
            yield f"mean height at {instant:g} s {height:.3f} m, {off:+.1f} % off free fall (at most {100 * share:g})"
    depth = result.get("pen_max_mm", 0.0)
    if depth > DEPTH_AT_IMPACT_MM:
        yield f"{depth:.1f} mm into the sphere (at most {DEPTH_AT_IMPACT_MM:g})"


def _at_rest(result: dict[str, Any]) -> Iterator[str]:
    if result["scenario"] == "hang":
        for name, key, most in (
            ("max", "stretch_end_max", HANG_STRETCH_MAX),
            ("p99", "stretch_end_p99", HANG_STRETCH_P99),
        ):
            if result[key] > most:
                yield f"stretch {name} {100 * result[key]:.1f} % (at most {100 * most:g})"
    depth = result.get("pen_end_mm", 0.0)
    if depth > DEPTH_AT_REST_MM:
        yield f"{depth:.2g} mm inside the sphere at the end (at most 0)"
    if result["scenario"] == "selfcol" and result["self_x"]:
        yield f"{result['self_x']} self-crossings at the end (at most 0)"
