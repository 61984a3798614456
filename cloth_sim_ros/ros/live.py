"""Parameters that are changed while the node runs: judged at once, in force from a step to the next."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rclpy.lifecycle import LifecycleNode

from cloth_core import ClothError, ClothSolver, Material, SolverConfig
from cloth_sim_ros.parameters import NodeSettings, changed, full_name
from cloth_sim_ros.ros.parameters import Groups, on_change, set_silently
from cloth_sim_ros.simulation.tuning import Tuning


class LiveParameters:
    """Carries changes of parameters to where they count.

    Args:
        node: the node.
        settings: its own, as they are.
        solver: in force.
        apply: gets the node's settings whenever they have changed.
        adopt: gets a solver that shall step from now on; returns from when on, in words.
    """

    def __init__(
        self,
        node: LifecycleNode,
        settings: NodeSettings,
        solver: ClothSolver,
        apply: Callable[[NodeSettings], None],
        adopt: Callable[[ClothSolver], str],
    ) -> None:
        self._node = node
        self._settings = settings
        self._apply = apply
        self._adopt = adopt
        self._in_force = _by_full_name(solver.material, solver.config)
        # It wakes the executor, whose thread alone starts and ends what a solver is handed to.
        self._guard = node.create_guard_condition(self._take_over)
        self._tuning = Tuning(solver, self._guard.trigger)
        self._stop_listening = on_change(node, self._check, self._carry_out)

    def close(self) -> None:
        """Take no further changes."""
        self._stop_listening()
        self._tuning.close()
        self._node.destroy_guard_condition(self._guard)

    def _check(self, given: Groups) -> None:
        self._changed(given)

    def _changed(self, given: Groups) -> tuple[NodeSettings, Material, SolverConfig]:
        material, config = self._tuning.wish
        return (
            changed(self._settings, "", given[""]),
            changed(material, "material", given["material"]),
            changed(config, "solver", given["solver"]),
        )

    def _carry_out(self, given: Groups) -> None:
        settings, material, config = self._changed(given)
        if settings != self._settings:
            self._settings = settings
            self._apply(settings)
        if (material, config) != self._tuning.wish:
            self._tuning.want(material, config)

    def _take_over(self) -> None:
        log = self._node.get_logger()
        try:
            solver = self._tuning.take()
        except ClothError as error:
            log.error(f"the parameters stay as they were: {error}")
            self._show(*self._tuning.wish)
            return
        if solver is not None:
            before, self._in_force = self._in_force, _by_full_name(solver.material, solver.config)
            news = ", ".join(f"{name} {value}" for name, value in self._in_force.items() if value != before[name])
            log.info(f"new parameters {self._adopt(solver)}: {news}")

    def _show(self, material: Material, config: SolverConfig) -> None:
        shown = _by_full_name(material, config)
        set_silently(self._node, {n: v for n, v in shown.items() if n != "solver.dt"})


def _by_full_name(material: Material, config: SolverConfig) -> Mapping[str, Any]:
    return {
        full_name(prefix, name): value
        for prefix, settings in (("material", material), ("solver", config))
        for name, value in settings.as_mapping().items()
    }
