"""A session simulated with another material or integrator beside what was recorded, and how far the two part."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cloth_core import Material, SettingError, SolverConfig
from cloth_core.settings import Settings
from cloth_sim_ros.recording.content import Step
from cloth_sim_ros.recording.follow import Follower
from cloth_sim_ros.recording.recorded import RecordedSession
from cloth_sim_ros.session import SessionError

Progress = Callable[[int, float], None]
_GROUPS: dict[str, type[Settings]] = {"material": Material, "solver": SolverConfig}
_FIXED = ("solver.dt",)  # every recorded input is that of one step


@dataclass(frozen=True)
class Moment:
    """How two simulations of the same inputs compare after one step.

    Args:
        step: its number.
        time: s of simulated time.
        rms: m, root mean square of the distance between the two positions of a vertex.
        largest: m, the largest one.
        vertex: that has it.
        stretch: largest length over rest length, as recorded and changed.
    """

    step: int
    time: float
    rms: float
    largest: float
    vertex: int
    stretch: tuple[float, float]


def parse_changes(texts: Sequence[str]) -> dict[str, object]:
    """Values by full name from texts ``key=value``, such as ``material.friction=0.6``.

    Raises:
        SettingError: a key is unknown or fixed, or a value has a wrong type or range.
    """
    found: dict[str, object] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        prefix, _, name = key.partition(".")
        known = dict(_GROUPS[prefix].settings()) if prefix in _GROUPS else {}
        if not equals or name not in known or key in _FIXED:
            names = ", ".join(f"{p}.{n}" for p, kind in _GROUPS.items() for n, _ in kind.settings())
            allowed = ", ".join(n for n in names.split(", ") if n not in _FIXED)
            raise SettingError(key or text, f"'{text}' is not key=value with a key that can be changed: {allowed}")
        found[key] = known[name].check(key, _value(value, known[name].kind))
    return found


def _value(text: str, kind: str) -> object:
    try:
        return {"float": float, "int": int}.get(kind, str)(text)
    except ValueError:
        return text  # the check says what would be allowed


def what_if(
    session: RecordedSession, changes: Mapping[str, object], on_progress: Progress | None = None
) -> list[Moment]:
    """Simulate ``session`` as it was and with ``changes`` (values by full name), side by side.

    Both get the recorded inputs; both begin where a snapshot says at the start, after a reset and after a restore.

    Args:
        session: what was recorded.
        changes: what :func:`parse_changes` gave.
        on_progress: called after every step with the steps done and the simulated time in s.

    Raises:
        SessionError: the session is damaged or holds no step.
        ClothError: the changes do not go together, or cannot be computed.
    """

    def change(material: Material, config: SolverConfig) -> tuple[Material, SolverConfig]:
        return (replace(material, **_of("material", changes)), replace(config, **_of("solver", changes)))

    as_recorded, other = Follower(session), Follower(session, change)
    moments: list[Moment] = []
    for _, entry in session.entries():
        as_recorded.follow(entry)
        other.follow(entry)
        if isinstance(entry, Step):
            moments.append(_compare(as_recorded, other))
            if on_progress is not None:
                on_progress(len(moments), moments[-1].time)
    if not moments:
        raise SessionError(f"{session.path}: holds no step to compare")
    return moments


def _of(prefix: str, changes: Mapping[str, object]) -> dict[str, object]:
    return {key.partition(".")[2]: value for key, value in changes.items() if key.startswith(f"{prefix}.")}


def _compare(as_recorded: Follower, other: Follower) -> Moment:
    ours, theirs = as_recorded.state, other.state
    assert ours is not None and theirs is not None
    distance = np.linalg.norm(ours.position - theirs.position, axis=1)
    vertex = int(distance.argmax())
    return Moment(
        step=ours.step_index,
        time=ours.time,
        rms=float(np.sqrt(np.mean(distance**2))),
        largest=float(distance[vertex]),
        vertex=vertex,
        stretch=(as_recorded.solver.report.max_stretch, other.solver.report.max_stretch),
    )


def report(moments: Sequence[Moment], rows: int = 12) -> str:
    """A table of some moments, equally apart, and the one at which the two are farthest apart."""
    worst = max(moments, key=lambda moment: moment.largest)
    every = max(1, len(moments) // rows)
    lines = ["   time s      rms m  largest m   vertex   stretch recorded   changed"]
    for moment in moments[every - 1 :: every]:
        lines.append(
            f"{moment.time:9.2f} {moment.rms:10.3g} {moment.largest:10.3g} {moment.vertex:8d}"
            f" {moment.stretch[0]:18.4f} {moment.stretch[1]:9.4f}"
        )
    lines.append(
        f"farthest apart: {worst.largest:.3g} m, vertex {worst.vertex}, step {worst.step} ({worst.time:.2f} s)"
    )
    return "\n".join(lines)
