"""Publishes frames: each message becomes bytes once, for the topic and for the session."""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np
from rclpy.lifecycle import LifecycleNode
from rclpy.serialization import serialize_message

from cloth_core import Material, Pose
from cloth_sim_ros import interfaces
from cloth_sim_ros.messages.cdr import MarkerEncoder, PointCloudEncoder, encode_mesh, encode_triangles
from cloth_sim_ros.parameters import NodeSettings
from cloth_sim_ros.ros.messages import obstacle_markers, rumble_of, wrench_of
from cloth_sim_ros.ros.publishers import Publishers
from cloth_sim_ros.ros.qos import IncompatibleQos
from cloth_sim_ros.simulation.frame import Frame
from cloth_sim_ros.simulation.haptics import Haptics
from cloth_sim_ros.simulation.simulation import Simulation
from cloth_sim_ros.vision.camera import Viewpoint
from cloth_sim_ros.vision.visible import visible_vertices

FAST_MESH_VERTICES = 2500
CLOTH_COLOUR = (0.76, 0.16, 0.22, 1.0)
_FLOAT64 = struct.Struct("<4sd")  # a std_msgs/Float64: the header of little-endian CDR, then the number


class Outputs:
    """The node's publishers, and what goes out over them.

    Args:
        node: the managed node; it publishes while it is active.
        simulation: what is shown.
        settings: the node's; replaced when they change.
        viewpoint: the camera.
        incompatible: is told of subscribers that cannot be served.
    """

    def __init__(
        self,
        node: LifecycleNode,
        simulation: Simulation,
        *,
        settings: NodeSettings,
        viewpoint: Viewpoint,
        incompatible: IncompatibleQos,
    ) -> None:
        self._simulation = simulation
        frame_id = self._frame_id = settings.frame_id
        self.settings = settings
        self._haptics = Haptics()
        self._viewpoint = viewpoint
        mesh = simulation.solver.mesh
        self._points, self._visible = PointCloudEncoder(frame_id), PointCloudEncoder(frame_id)
        self._marker = MarkerEncoder(frame_id, "cloth", 0, CLOTH_COLOUR, mesh.triangles)
        those = [i for i in interfaces.OUTPUTS if i is not interfaces.DIAGNOSTICS]
        hands = [*simulation.scene.inputs.grasps, *simulation.solver.grippers]
        self.publishers = Publishers(node, those, {"grasps": hands}, incompatible)
        self._weighed: Material | None = None
        self._obstacles_shown: dict[str, Pose] = {}
        self._topology_sent = False
        self._obstacles_at = 0

    def publish_points(self, frame: Frame, stamp_ns: int) -> None:
        """Publish the points of ``frame``."""
        self.publishers.send(
            interfaces.POINTS,
            self._points.encode(stamp_ns, frame.position, frame.normal, frame.strain),
            stamp_ns,
        )

    def publish_rest(self, frame: Frame, stamp_ns: int) -> None:
        """Publish what else belongs to ``frame``: what is due, and what somebody wants."""
        if not self._topology_sent:
            self._publish_topology(frame, stamp_ns)
        if (
            self._viewpoint.pose is not None
            and self._is_due(frame, self.settings.visible_rate)
            and self.publishers.heard(interfaces.VISIBLE)
        ):
            self._publish_visible(frame, stamp_ns)
        if self._mesh_is_due(frame) and self.publishers.wanted(interfaces.MESH):
            self.publishers.send(interfaces.MESH, self._marker.encode(stamp_ns, frame.position), stamp_ns)
        self._publish_haptics(frame, stamp_ns)
        poses = frame.state.obstacles
        if poses != self._obstacles_shown or not 0 <= stamp_ns - self._obstacles_at < 1_000_000_000:
            self._publish_obstacles(poses, stamp_ns)
        for name, value in self._stats(frame).items():
            if self.publishers.wanted(interfaces.STATS[name]):
                self.publishers.send(interfaces.STATS[name], _FLOAT64.pack(b"\0\1\0\0", value), stamp_ns)

    def _is_due(self, frame: Frame, rate: float) -> bool:
        """Whether what is published at ``rate`` Hz is so now."""
        return frame.step_index % max(1, round(1.0 / (rate * self._simulation.solver.config.dt))) == 0

    def _mesh_is_due(self, frame: Frame) -> bool:
        return len(frame.position) <= FAST_MESH_VERTICES or self._is_due(frame, self.settings.mesh_rate)

    def _publish_haptics(self, frame: Frame, stamp_ns: int) -> None:
        hums = self._haptics.rumble(frame, self._simulation.solver.config.dt, self.settings.rumble_force)
        for name, wrench in self._haptics.wrenches(frame).items():
            if self.publishers.wanted(interfaces.WRENCH, name):
                cdr = serialize_message(wrench_of(name, wrench, stamp_ns))
                self.publishers.send(interfaces.WRENCH, cdr, stamp_ns, name)
            if self.publishers.wanted(interfaces.RUMBLE, name):
                cdr = serialize_message(rumble_of(hums[name]))
                self.publishers.send(interfaces.RUMBLE, cdr, stamp_ns, name)

    def _publish_visible(self, frame: Frame, stamp_ns: int) -> None:
        solver, camera = self._simulation.solver, self._viewpoint
        seen = visible_vertices(
            camera.pose, camera.lens, frame.position, solver.mesh.triangles, solver.obstacles, frame.state.obstacles
        )
        cloud = self._visible.encode(stamp_ns, frame.position[seen], frame.normal[seen], frame.strain[seen], seen)
        self.publishers.send(interfaces.VISIBLE, cloud, stamp_ns)

    def _publish_topology(self, frame: Frame, stamp_ns: int) -> None:
        triangles = self._simulation.solver.mesh.triangles
        self.publishers.send(interfaces.TRIANGLES, encode_triangles(self._frame_id, stamp_ns, triangles), stamp_ns)
        self.publishers.send(interfaces.TOPOLOGY, encode_mesh(triangles, frame.position), stamp_ns)
        self._topology_sent = True

    def _publish_obstacles(self, poses: Mapping[str, Pose], stamp_ns: int) -> None:
        array = obstacle_markers(self._simulation.solver.obstacles, poses, self._frame_id, stamp_ns)
        self.publishers.send(interfaces.OBSTACLES, serialize_message(array), stamp_ns)
        self._obstacles_shown, self._obstacles_at = dict(poses), stamp_ns

    def _stats(self, frame: Frame) -> dict[str, float]:
        velocity, solver = frame.state.velocity, self._simulation.solver
        if solver.material is not self._weighed:
            self._weighed, self._mass = solver.material, solver.mesh.vertex_mass(solver.material)
        return {
            "step_time_ms": 1e3 * frame.step_seconds,
            "max_stretch": frame.report.max_stretch,
            "kinetic_energy": 0.5 * float(self._mass @ np.einsum("va,va->v", velocity, velocity)),
            "contacts": float(frame.report.contacts),
            "held": float(frame.report.held),
        }
