"""The managed node: its states, its services and its session."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_srvs.srv import SetBool, Trigger

from cloth_core import ClothError
from cloth_sim_ros.interfaces import PAUSE, RESET
from cloth_sim_ros.parameters import NodeSettings
from cloth_sim_ros.recording.folder import open_session
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.ros.pace import pace_of
from cloth_sim_ros.ros.parameters import declare
from cloth_sim_ros.ros.parts import Parts, assemble
from cloth_sim_ros.ros.report import Report
from cloth_sim_ros.session import SessionError
from cloth_sim_ros.simulation.runner import Runner


class ClothNode(LifecycleNode):
    """``cloth_sim``: configured it holds a scene ready to run, active it steps, publishes and records.

    Args:
        asked_to_end: whether the process was asked to end: then what fails is no error.
        options: for the LifecycleNode.

    Raises:
        SettingError: a parameter of the node itself has a wrong type or range.
    """

    def __init__(self, asked_to_end: Callable[[], bool] = lambda: False, **options: Any) -> None:
        super().__init__("cloth_sim", **options)
        self.asked_to_end = asked_to_end
        self.settings = declare(self, NodeSettings())
        self._parts: Parts | None = None
        self._runner: Runner | None = None
        self._recorder: Recorder | None = None
        self._session_problem = ""
        self._configured = ExitStack()  # undoes on_configure
        self._activated = ExitStack()  # undoes on_activate

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the scene, compile, factorise, join the graph; refused with one line if anything is wrong."""
        with ExitStack() as undo:
            try:
                self._configure(undo)
            except ClothError as error:
                self.get_logger().error(f"cannot start: {error}")
                return TransitionCallbackReturn.FAILURE
            except Exception:  # rclpy would swallow it without a word
                if not self.asked_to_end():  # compiled code turns the interrupt of a signal into errors of its own
                    self.get_logger().error(f"cannot start:\n{traceback.format_exc()}")
                return TransitionCallbackReturn.FAILURE
            self._configured = undo.pop_all()
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Begin to step, publish and record."""
        result = super().on_activate(state)
        try:
            self._activate()
        except Exception:  # as above
            self.get_logger().error(f"cannot run:\n{traceback.format_exc()}")
            self._stop()
            super().on_deactivate(state)
            return TransitionCallbackReturn.FAILURE
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Stop stepping, publishing and listening; the cloth stays as it is."""
        self._stop()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Close the session and leave the graph."""
        self.close()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """The same from any state, for good."""
        self.close()
        return super().on_shutdown(state)

    def close(self) -> None:
        """End what runs and close the session; calling again changes nothing."""
        self._stop()
        if self._recorder is not None:
            health = self._recorder.close()
            self._recorder = None
            self.get_logger().info(f"session closed: {health.folder}")
        self._configured.close()

    def _stop(self) -> None:
        if self._runner is not None:
            self._parts.inputs.active = False
            self._runner.stop()
            self._runner = None
            self._activated.close()

    def _configure(self, undo: ExitStack) -> None:
        self._parts = assemble(self, self.settings, undo)
        for kind, interface, serve in ((SetBool, PAUSE, self._pause), (Trigger, RESET, self._reset)):
            undo.callback(self.destroy_service, self.create_service(kind, interface.name, serve))
        report = Report(self, self._parts)
        undo.callback(report.destroy)
        # On a clock of its own: it must speak up when /clock does not come.
        timer = self.create_timer(
            1.0,
            lambda: report.publish(self._runner, self._recorder, self._session_problem),
            clock=Clock(clock_type=ClockType.STEADY_TIME),
        )
        undo.callback(self.destroy_timer, timer)

    def _activate(self) -> None:
        if self._recorder is None:
            self._open_session()
        parts = self._parts
        parts.outputs.recorder = parts.inputs.recorder = self._recorder
        self._runner = Runner(
            parts.simulation,
            pace_of(self, parts.simulation.solver.config.dt, self._activated),
            parts.outputs,
            self._recorder,
            parts.failures,
            hints=parts.hints,
            ros_now=lambda: self.get_clock().now().nanoseconds,
            budget=self.settings.time_budget,
            on_reset=parts.intake.forget_stamps,
        )
        self._runner.start()
        parts.inputs.active = True

    def _open_session(self) -> None:
        simulation = self._parts.simulation
        self._session_problem = ""
        try:
            self._recorder = open_session(
                self.settings, simulation.scene, simulation.solver, self.get_fully_qualified_name()
            )
        except SessionError as error:
            self._session_problem = str(error)
            self.get_logger().error(f"{error}; going on without recording")
        if self._recorder is not None:
            self.get_logger().info(f"recording to {self._recorder.path}")

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        return self._answer(response, lambda runner: runner.pause(request.data))

    def _reset(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return self._answer(response, lambda runner: runner.reset())

    def _answer(self, response: Any, action: Callable[[Runner], str]) -> Any:
        if self._runner is None:
            response.success, response.message = False, "the node is not active"
            return response
        try:
            response.success, response.message = True, action(self._runner)
        except Exception as error:
            response.success, response.message = False, f"{type(error).__name__}: {error}"
        return response
