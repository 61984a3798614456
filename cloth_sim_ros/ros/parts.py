"""What a configured node consists of, put together."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace

from rclpy.lifecycle import LifecycleNode

from cloth_core import compiling
from cloth_core.scene import Scene
from cloth_sim_ros.parameters import NodeSettings, parameter_names
from cloth_sim_ros.ros.inputs import Subscriptions
from cloth_sim_ros.ros.outputs import Outputs
from cloth_sim_ros.ros.parameters import declare, warn_of_unknown
from cloth_sim_ros.ros.qos import IncompatibleQos
from cloth_sim_ros.ros.tf import tf_lookup
from cloth_sim_ros.share import load_scene
from cloth_sim_ros.simulation.frames import FrameTree
from cloth_sim_ros.simulation.intake import Intake
from cloth_sim_ros.simulation.notices import Notices
from cloth_sim_ros.simulation.simulation import Simulation

_SAID_EVERY_S = 2.0


@dataclass(frozen=True)
class Parts:
    """A scene ready to run, and its topics.

    Args:
        simulation: the cloth.
        representation: how W is stored.
        intake: judges what comes in.
        inputs: the subscriptions.
        outputs: the publishers.
        failures: says and counts steps that went wrong.
        refused: says and counts messages that were not used.
        hints: says and counts grasps that hold nothing, or nothing any more.
        incompatible: peers whose quality of service does not fit.
    """

    simulation: Simulation
    representation: str
    intake: Intake
    inputs: Subscriptions
    outputs: Outputs
    failures: Notices
    refused: Notices
    hints: Notices
    incompatible: IncompatibleQos


def assemble(node: LifecycleNode, settings: NodeSettings, undo: ExitStack) -> Parts:
    """Load the scene, compile and factorise, join the graph; ``undo`` gets what takes it all back.

    Raises:
        ClothError: the scene or a parameter cannot be used.
    """
    log = node.get_logger()
    scene = _load_scene(node, settings)
    warn_of_unknown(node, parameter_names())
    failures, refused, hints = Notices(log.error), Notices(log.warning), Notices(log.warning)
    incompatible = IncompatibleQos(log.warning)
    frames = FrameTree(settings.frame_id, settings.static_transforms, tf_lookup(node))
    simulation = _prepared(node, scene, settings)
    outputs = Outputs(
        node,
        simulation,
        frame_id=settings.frame_id,
        mesh_rate=settings.mesh_rate,
        incompatible=incompatible,
    )
    undo.callback(outputs.destroy)
    intake = Intake(simulation, frames, scene.solver.max_wind_speed, refused)
    inputs = Subscriptions(node, scene, intake, incompatible)
    undo.callback(inputs.destroy)
    return Parts(
        simulation=simulation,
        representation=simulation.solver.representation,
        intake=intake,
        inputs=inputs,
        outputs=outputs,
        failures=failures,
        refused=refused,
        hints=hints,
        incompatible=incompatible,
    )


def _load_scene(node: LifecycleNode, settings: NodeSettings) -> Scene:
    scene = load_scene(settings.scene, node.get_logger().warning)
    material = declare(node, scene.material, "material")
    solver = declare(node, scene.solver, "solver")
    return replace(scene, material=material, solver=solver)


def _prepared(node: LifecycleNode, scene: Scene, settings: NodeSettings) -> Simulation:
    log = node.get_logger()
    vertices = scene.mesh.vertex_count
    log.info(f"scene {scene.name}: {vertices} vertices; compiling kernels, which takes half a minute the first time")
    begin = time.monotonic()
    with compiling.told(_now_and_then(log.info, begin)):
        simulation = Simulation(scene, grasp_timeout=settings.grasp_timeout)
        simulation.prepare()
    took, step = time.monotonic() - begin, 1e3 * scene.solver.dt
    log.info(f"ready after {took:.1f} s; W is {simulation.solver.representation}, a step is {step:g} ms")
    return simulation


def _now_and_then(say: Callable[[str], None], begin: float) -> Callable[[int, str], None]:
    """Says which kernel is being compiled, every few seconds of those after ``begin`` (monotonic s)."""
    said = begin

    def progress(number: int, name: str) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= _SAID_EVERY_S:
            said = now
            say(f"compiling kernel {number} ({name}) after {now - begin:.0f} s")

    return progress
