"""Every topic and service of the node, in one table. Names are relative to the node (``~``)."""

from __future__ import annotations

from dataclasses import dataclass

from cloth_core.inputs import REST_SCALE
from cloth_sim_ros.session import Qos

NEWEST = Qos(reliability="best_effort", depth=1)
"""Poses and wind: only the newest counts, and every publisher matches."""
RECENT = Qos(reliability="best_effort", depth=10)
"""Joysticks and joints: a short press counts too, and every publisher matches."""
COMMAND = Qos(reliability="reliable", depth=10)
"""Closure: none may be lost."""
STREAM = Qos(reliability="reliable", depth=5)
"""Outputs: large messages arrive whole, and a slow reader does not hold up the others."""
LATCHED = Qos(reliability="reliable", durability="transient_local", depth=1)
"""What changes rarely: whoever comes late gets the last one."""

CLOSURES = "closures"
"""What declares a topic that only the parameter of that name asks for."""


@dataclass(frozen=True)
class Interface:
    """One topic or service.

    Args:
        direction: ``in``, ``out`` or ``srv``.
        name: relative to the node; ``{name}`` stands for a name that the scene declares.
        type_name: ROS interface type.
        meaning: one line for people.
        qos: what the node offers or asks for; None for services.
        declared: part of the scene that declares the names: ``grasps``, ``obstacles``, ``fluids``, ``groups``, or
            nothing; or :data:`CLOSURES`.
    """

    direction: str
    name: str
    type_name: str
    meaning: str
    qos: Qos | None = None
    declared: str = ""

    def named(self, name: str) -> str:
        """The topic of one declared name."""
        return self.name.format(name=name)


GRASP_POSE = Interface(
    "in", "~/grasp/{name}/pose", "geometry_msgs/msg/PoseStamped",
    "gripper or hand; later than grasp_timeout it is held where it is", NEWEST, "grasps",
)  # fmt: skip
GRASP_CLOSURE = Interface(
    "in", "~/grasp/{name}/closure", "std_msgs/msg/Float64",
    "0 open .. 1 closed; closing captures the cloth within the grasp's radius", COMMAND, "grasps",
)  # fmt: skip
JOY = Interface(
    "in", "~/joy", "sensor_msgs/msg/Joy",
    "closure from an axis or button; this topic or others, as the parameter closures says", RECENT, CLOSURES,
)  # fmt: skip
JOINTS = Interface(
    "in", "~/joint_states", "sensor_msgs/msg/JointState",
    "closure from a joint; this topic or others, as the parameter closures says", RECENT, CLOSURES,
)  # fmt: skip
WIND = Interface(
    "in",
    "~/wind",
    "geometry_msgs/msg/Vector3Stamped",
    "mean wind in m/s, turned into the cloth's frame, capped",
    NEWEST,
)
WIND_POSE = Interface(
    "in", "~/wind/pose", "geometry_msgs/msg/PoseStamped",
    "a pointer: wind of the speed wind_pointer_speed blows along its x axis", NEWEST,
)  # fmt: skip
FLUID_VELOCITY = Interface(
    "in", "~/fluid/{name}/velocity", "geometry_msgs/msg/Vector3Stamped",
    "velocity in m/s of a region of fluid, turned into the cloth's frame", NEWEST, "fluids",
)  # fmt: skip
GROUP_PIN = Interface(
    "in", "~/group/{name}/pin", "std_msgs/msg/Bool",
    "pins a group of vertices where they are, or lets them go", COMMAND, "groups",
)  # fmt: skip
GROUP_POSE = Interface(
    "in", "~/group/{name}/pose", "geometry_msgs/msg/PoseStamped",
    "moves what is pinned of a group, as one body: it goes with a frame that stood at its mean, along the axes of the "
    "cloth's, when its first pose came; no faster than solver.max_grasp_speed and max_grasp_turn", NEWEST, "groups",
)  # fmt: skip
GROUP_REST_SCALE = Interface(
    "in", "~/group/{name}/rest_scale", "std_msgs/msg/Float64",
    f"rest lengths within a group over those it was made with, {REST_SCALE.low:g} .. {REST_SCALE.high:g}, such as a "
    "waistband's; they change by 100 %/s at most", COMMAND, "groups",
)  # fmt: skip
OBSTACLE_POSE = Interface(
    "in", "~/obstacle/{name}/pose", "geometry_msgs/msg/PoseStamped",
    "moves an obstacle; its surface drags cloth along", NEWEST, "obstacles",
)  # fmt: skip

CAMERA_POSE = Interface(
    "in", "~/camera/pose", "geometry_msgs/msg/PoseStamped",
    "optical frame (z ahead, x right, y down) of the camera for visible_points", NEWEST,
)  # fmt: skip
CAMERA_INFO = Interface(
    "in", "~/camera/info", "sensor_msgs/msg/CameraInfo",
    "its pinhole, undistorted; 640 x 480 and 60 degrees before one came. Its frame_id is used if no pose comes", NEWEST,
)  # fmt: skip

POINTS = Interface(
    "out", "~/cloth/points", "sensor_msgs/msg/PointCloud2",
    "every step: x y z normal_x normal_y normal_z strain (float32), vertex_id (uint32)", STREAM,
)  # fmt: skip
VISIBLE = Interface(
    "out", "~/cloth/visible_points", "sensor_msgs/msg/PointCloud2",
    "the points that the camera sees, fields as in ~/cloth/points; only while somebody listens", STREAM,
)  # fmt: skip
MESH = Interface(
    "out",
    "~/cloth/mesh",
    "visualization_msgs/msg/Marker",
    "TRIANGLE_LIST; only while somebody listens",
    STREAM,
)
TRIANGLES = Interface(
    "out",
    "~/cloth/triangles",
    "sensor_msgs/msg/PointCloud2",
    "vertex ids v0 v1 v2 (uint32) of every triangle",
    LATCHED,
)
TOPOLOGY = Interface("out", "~/cloth/topology", "shape_msgs/msg/Mesh", "the cloth as it starts, for planners", LATCHED)
WRENCH = Interface(
    "out", "~/grasp/{name}/wrench", "geometry_msgs/msg/WrenchStamped",
    "of the cloth on the hand, N and N m, in its own frame; frame_id is the grasp's name", STREAM, "grasps",
)  # fmt: skip
RUMBLE = Interface(
    "out", "~/grasp/{name}/rumble", "sensor_msgs/msg/JoyFeedbackArray",
    "one TYPE_RUMBLE, 0 .. 1: changes of the force, cloth that is caught, lost, or pulled taut", STREAM, "grasps",
)  # fmt: skip
OBSTACLES = Interface(
    "out", "~/obstacles", "visualization_msgs/msg/MarkerArray", "what the cloth collides with", LATCHED
)
STATS = {
    name: Interface("out", f"~/stats/{name}", "std_msgs/msg/Float64", meaning, STREAM)
    for name, meaning in {
        "step_time_ms": "time that the step took, ms",
        "max_stretch": "largest length over rest length",
        "kinetic_energy": "J",
        "contacts": "pairs of vertex and obstacle in touch",
        "held": "vertices pinned or grasped",
    }.items()
}
DIAGNOSTICS = Interface(
    "out",
    "/diagnostics",
    "diagnostic_msgs/msg/DiagnosticArray",
    "once a second: timing, inputs, session",
    STREAM,
)
PAUSE = Interface("srv", "~/pause", "std_srvs/srv/SetBool", "true stops the simulated time, false lets it go on")
RESET = Interface("srv", "~/reset", "std_srvs/srv/Trigger", "back to the scene's start; nothing stays held")

STEP = Interface("srv", "~/step", "std_srvs/srv/Trigger", "one step, while paused")
SNAPSHOT = Interface("srv", "~/snapshot", "std_srvs/srv/Trigger", "keeps the cloth and its inputs, in one place")
RESTORE = Interface("srv", "~/restore", "std_srvs/srv/Trigger", "back to what ~/snapshot kept, bit for bit")

INPUTS = (
    *(GRASP_POSE, GRASP_CLOSURE, JOY, JOINTS, WIND, WIND_POSE, FLUID_VELOCITY),
    *(OBSTACLE_POSE, GROUP_PIN, GROUP_POSE, GROUP_REST_SCALE, CAMERA_POSE, CAMERA_INFO),
)
OUTPUTS = (POINTS, VISIBLE, MESH, TRIANGLES, TOPOLOGY, OBSTACLES, WRENCH, RUMBLE, *STATS.values(), DIAGNOSTICS)
SERVICES = (PAUSE, RESET, STEP, SNAPSHOT, RESTORE)
INTERFACES = (*INPUTS, *OUTPUTS, *SERVICES)


def as_text() -> str:
    """The table for ``--help``."""
    shown = [(i.direction, i.name.replace("{name}", "<name>"), _short(i.type_name), i.meaning) for i in INTERFACES]
    wide = [max(len(row[column]) for row in shown) for column in range(3)]
    return "\n".join(f"  {d:<{wide[0]}}  {name:<{wide[1]}}  {kind:<{wide[2]}}  {m}" for d, name, kind, m in shown)


def _short(type_name: str) -> str:
    return type_name.replace("/msg/", "/").replace("/srv/", "/")
