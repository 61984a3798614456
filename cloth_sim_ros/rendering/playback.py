"""A scene played from its start by its own script, as fast as the solver goes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from cloth_core import Inputs, State
from cloth_core.scene import Scene


def play(scene: Scene, times: Iterable[float]) -> Iterator[tuple[State, Inputs]]:
    """The state and inputs at each of ``times`` s, ascending; each is the first step that is not before it."""
    solver, state = scene.build()
    for time in times:
        # Half a step of slack: sums of dt are not exactly the times that are asked for.
        while state.time < time - 0.5 * solver.config.dt:
            state = solver.step(state, scene.script.inputs_at(state.time, scene.inputs))
        yield state, scene.script.inputs_at(state.time, scene.inputs)


def frame_times(start: float, end: float, fps: float) -> list[float]:
    """Instants from ``start`` up to, not including, ``end`` s, so that a loop has no frame twice."""
    return [start + number / fps for number in range(max(1, round((end - start) * fps)))]
