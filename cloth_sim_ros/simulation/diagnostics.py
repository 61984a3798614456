"""What ``/diagnostics`` says, as plain values: how the simulation keeps time, its inputs, its session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

from cloth_sim_ros.session import Health
from cloth_sim_ros.simulation.clock import Rhythm
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Frame

RECENT = 10.0
"""s for which something that went wrong keeps its level."""


class Level(IntEnum):
    """Levels of diagnostic_msgs/DiagnosticStatus."""

    OK, WARN, ERROR, STALE = range(4)


@dataclass(frozen=True)
class Status:
    """One diagnostic_msgs/DiagnosticStatus."""

    name: str
    level: Level
    message: str
    values: dict[str, str] = field(default_factory=dict)


def _status(name: str, problems: Sequence[tuple[Level, str]], fine: str, values: dict[str, object]) -> Status:
    """The worst level, and every problem in words."""
    level = max((level for level, _ in problems), default=Level.OK)
    message = "; ".join(text for _, text in problems) or fine
    return Status(
        name,
        level,
        message,
        {key: f"{v:.6g}" if isinstance(v, float) else str(v) for key, v in values.items()},
    )


def timing(rhythm: Rhythm, *, nominal: float, skipped: int, missed_lately: int, paused: bool, waiting: bool) -> Status:
    """Rate in Hz, lag in s, step times in ms, missed slots.

    Args:
        rhythm: what was published when.
        nominal: Hz; 0 where a clock driven by others sets the pace.
        skipped: slots left out since the start.
        missed_lately: frames that came late since the last call.
        paused: nobody expects steps.
        waiting: nobody has told the time yet.
    """
    rate = rhythm.rate
    problems = []
    if waiting:
        problems.append((Level.WARN, "waiting for /clock (use_sim_time is set)"))
    elif not paused and nominal and rate < 0.5 * nominal:
        problems.append((Level.ERROR, f"{rate:.1f} of {nominal:g} Hz"))
    elif not paused and nominal and rate < 0.98 * nominal:
        problems.append((Level.WARN, f"{rate:.1f} of {nominal:g} Hz"))
    if missed_lately:
        problems.append((Level.WARN, f"{missed_lately} slots missed in the last second"))
    values: dict[str, object] = {
        "rate_hz": f"{rate:.2f}",
        "nominal_hz": nominal,
        "lag_s": skipped / nominal if nominal else 0.0,
        "skipped_slots": skipped,
        "missed_slots": rhythm.missed,
        "step_p50_ms": f"{rhythm.step_time_ms(50):.2f}",
        "step_p99_ms": f"{rhythm.step_time_ms(99):.2f}",
        "paused": str(paused).lower(),
    }
    return _status("timing", problems, "paused" if paused else f"{rate:.1f} Hz", values)


# What fast contact adds to a stretch limit for a moment is no reason to worry; more is.
STRETCH_TOLERANCE = 0.25


def cloth(frame: Frame | None, representation: str, failures: Notices, stretch_limit: float = float("inf")) -> Status:
    """What the last step did, and what went wrong in it."""
    if frame is None:
        return Status("cloth", Level.OK, "no step yet", {"w": representation})
    report = frame.report
    problems = []
    if failures.within(RECENT):
        problems.append((Level.ERROR, failures.as_text()))
    if report.max_stretch > stretch_limit + STRETCH_TOLERANCE:
        problems.append((Level.WARN, f"stretched to {report.max_stretch:.2f}, the limit is {stretch_limit:g}"))
    if report.wind_capped:
        problems.append((Level.WARN, "the wind is faster than solver.max_wind_speed, and capped"))
    if report.out_of_time:
        problems.append((Level.WARN, "the step ran out of time and was cut short"))
    if report.teleported:
        problems.append((Level.WARN, f"teleported, for it was too fast: {', '.join(report.teleported)}"))
    if report.slowed:
        problems.append((Level.WARN, f"followed late, for it was too fast: {', '.join(report.slowed)}"))
    if report.taut:
        problems.append((Level.WARN, f"held back, for the cloth reaches no farther: {', '.join(report.taut)}"))
    grips = frame.state.grips
    values: dict[str, object] = {
        "step": frame.step_index,
        "time_s": frame.time,
        "sweeps": sum(report.sweeps),
        "residual": report.residual,
        "max_stretch": f"{report.max_stretch:.4f}",
        "contacts": report.contacts,
        "restrained_vertices": report.restrained,
        "held_vertices": report.held,
        "held_by": ", ".join(f"{name} ({len(grip.vertex)})" for name, grip in grips.items() if len(grip.vertex))
        or "nothing",
        "vertices": len(frame.position),
        "w": representation,
        "failures": failures.as_text() or "none",
    }
    return _status("cloth", problems, f"stretch {report.max_stretch:.3f}, {report.held} held", values)


def inputs(
    refused: Notices,
    hints: Notices,
    *,
    stale: Sequence[str],
    undeclared: Sequence[str],
    incompatible: Sequence[str],
) -> Status:
    """Stale grasps, messages refused by cause, grasps without effect, topics that nobody reads."""
    problems = []
    if stale:
        problems.append((Level.WARN, f"no pose comes, so the hand stays where it was: {', '.join(stale)}"))
    problems += [(Level.WARN, text) for text in (*refused.within(RECENT), *hints.within(RECENT))]
    if undeclared:
        problems.append((Level.WARN, f"the scene has no input {', '.join(undeclared)}"))
    if incompatible:
        problems.append((Level.WARN, f"incompatible QoS: {', '.join(incompatible)}"))
    values: dict[str, object] = {
        "stale": ", ".join(stale) or "none",
        "refused": sum(refused.counts.values()),
        "refused_by_cause": refused.as_text() or "none",
        "grasps_without_cloth": hints.as_text() or "none",
        "undeclared_topics": ", ".join(undeclared) or "none",
        "incompatible_qos": ", ".join(incompatible) or "none",
    }
    return _status("inputs", problems, "all good", values)


def session(health: Health | None, problem: str) -> Status:
    """Where the session is recorded, and whether that goes well; ``problem`` says why there is none."""
    if health is None:
        level, text = (Level.ERROR, f"not recording: {problem}") if problem else (Level.OK, "not recording, as asked")
        return Status("session", level, text, {"session_folder": "none"})
    problems = []
    if health.error:
        problems.append((Level.ERROR, health.error))
    if health.dropped:
        problems.append((Level.WARN, f"{health.dropped} messages dropped"))
    values: dict[str, object] = {
        "session_folder": health.folder,
        "session_messages": health.messages,
        "session_bytes": health.bytes,
        "session_dropped": health.dropped,
        "session_error": health.error or "none",
    }
    return _status("session", problems, f"recording to {health.folder}", values)
