"""One node, seen from outside: what it publishes fits together, and what it is told happens."""

from __future__ import annotations

import math

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Vector3Stamped, WrenchStamped
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, JoyFeedback, JoyFeedbackArray, PointCloud2
from shape_msgs.msg import Mesh
from std_msgs.msg import Bool, Float64
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import Marker, MarkerArray

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
VERTICES, TRIANGLES = 81, 128
POINT = np.dtype([(name, "<f4") for name in ("x", "y", "z", "nx", "ny", "nz", "strain")] + [("id", "<u4")])


@pytest.fixture(scope="module")
def node(start_node):
    return start_node()


@pytest.fixture(autouse=True)
def from_the_start(node, peer):
    """Every test begins with the cloth where the scene puts it, moving."""
    assert peer.call(SetBool, "pause", SetBool.Request(data=False)).success
    assert peer.call(Trigger, "reset", Trigger.Request()).success


def positions(cloud):
    points = np.frombuffer(bytes(cloud.data), POINT)
    return np.stack([points["x"], points["y"], points["z"]], axis=1)


def stamp(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def pose(x, y, z, frame="world"):
    message = PoseStamped()
    message.header.frame_id = frame
    message.pose.position.x, message.pose.position.y, message.pose.position.z = x, y, z
    message.pose.orientation.w = 1.0
    return message


def test_points_come_with_normals_strain_and_ids_stamped_on_the_grid_of_steps(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    peer.wait_until(lambda: len(clouds) >= 25, "25 clouds")
    for cloud in clouds:
        assert cloud.header.frame_id == "world"
        assert (cloud.height, cloud.width, cloud.point_step) == (1, VERTICES, 32)
        points = np.frombuffer(bytes(cloud.data), POINT)
        assert points["id"].tolist() == list(range(VERTICES))
        assert all(np.isfinite(points[name]).all() for name in POINT.names)
        lengths = np.sqrt(points["nx"] ** 2 + points["ny"] ** 2 + points["nz"] ** 2)
        assert lengths == pytest.approx(1.0, abs=1e-5)
    steps = np.diff([stamp(cloud) for cloud in clouds]) / 20e6
    assert steps == pytest.approx(np.round(steps), abs=0.1)
    assert steps.min() > 0.5


def test_points_triangles_topology_and_mesh_fit_together(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    meshes = peer.listen(Marker, "cloth/mesh")
    triangles = peer.listen(PointCloud2, "cloth/triangles", LATCHED)
    topologies = peer.listen(Mesh, "cloth/topology", LATCHED)

    def same_step():
        clouds_by_stamp = {stamp(cloud): cloud for cloud in clouds}
        return next(((clouds_by_stamp[stamp(m)], m) for m in meshes if stamp(m) in clouds_by_stamp), None)

    cloud, mesh = (
        peer.wait_until(lambda: triangles and topologies and same_step(), "a mesh and a cloud of the same step")
        and same_step()
    )
    corners = np.frombuffer(bytes(triangles[0].data), "<u4").reshape(-1, 3)
    assert corners.shape == (TRIANGLES, 3)
    assert corners.max() == VERTICES - 1
    assert [list(t.vertex_indices) for t in topologies[0].triangles] == corners.tolist()
    assert len(topologies[0].vertices) == VERTICES
    drawn = np.array([[p.x, p.y, p.z] for p in mesh.points]).reshape(-1, 3, 3)
    assert mesh.type == Marker.TRIANGLE_LIST
    assert drawn == pytest.approx(positions(cloud)[corners], abs=1e-6)


def test_a_gripper_closed_at_a_corner_lifts_it_and_lets_it_fall(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    held = peer.listen(Float64, "stats/held")
    move = peer.speak(PoseStamped, "grasp/hand/pose", 1)
    close = peer.speak(Float64, "grasp/hand/closure")
    corner = positions(peer.wait_until(lambda: clouds and clouds[-1], "a cloud"))[-1].astype(float)
    peer.wait_until(
        lambda: held and held[-1].data > 1.0,  # one vertex is pinned
        "a captured vertex",
        meanwhile=lambda: (move(pose(*positions(clouds[-1])[-1].astype(float))), close(Float64(data=1.0))),
    )
    goal = (corner[0], corner[1], 0.8)
    peer.wait_until(
        lambda: abs(positions(clouds[-1])[-1][2] - 0.8) < 0.1,
        "the corner to be lifted to 0.8 m",
        meanwhile=lambda: move(pose(*goal)),
    )
    close(Float64(data=0.0))
    peer.wait_until(lambda: held[-1].data == 1.0, "the corner to be released")
    peer.wait_until(lambda: positions(clouds[-1])[-1][2] < 0.5, "the corner to fall")


def test_a_hand_that_lifts_the_cloth_feels_it_and_its_controller_hums(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    wrenches = peer.listen(WrenchStamped, "grasp/hand/wrench")
    rumbles = peer.listen(JoyFeedbackArray, "grasp/hand/rumble")
    move, close = peer.speak(PoseStamped, "grasp/hand/pose", 1), peer.speak(Float64, "grasp/hand/closure")
    corner = positions(peer.wait_until(lambda: clouds and clouds[-1], "a cloud"))[-1].astype(float)
    goal = pose(corner[0], corner[1], corner[2])

    def lift():
        move(goal)
        close(Float64(data=1.0))
        goal.pose.position.z = min(0.9, goal.pose.position.z + 0.004)

    peer.wait_until(
        lambda: wrenches and wrenches[-1].wrench.force.z < -0.05,
        "a pull downwards",
        meanwhile=lift,
    )
    assert wrenches[-1].header.frame_id == "hand"
    peer.wait_until(lambda: any(r.array[0].intensity > 0.3 for r in rumbles), "the controller to hum", meanwhile=lift)
    assert {(len(r.array), r.array[0].type) for r in rumbles} == {(1, JoyFeedback.TYPE_RUMBLE)}
    assert all(0.0 <= r.array[0].intensity <= 1.0 for r in rumbles)
    assert peer.call(SetBool, "pause", SetBool.Request(data=True)).success
    assert peer.call(Trigger, "reset", Trigger.Request()).success  # shown, with a hand that holds nothing any more
    assert peer.call(SetBool, "pause", SetBool.Request(data=False)).success
    close(Float64(data=0.0))


def test_wind_blows_the_cloth_along(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    blow = peer.speak(Vector3Stamped, "wind", 1)
    wind = Vector3Stamped()
    wind.header.frame_id = "world"
    wind.vector.x = wind.vector.z = 8.0

    def height():
        return positions(clouds[-1])[:, 2].mean() if clouds else 0.0

    peer.wait_until(lambda: height() > 0.55, "the cloth to be blown up", meanwhile=lambda: blow(wind))


def test_a_group_is_pinned_and_let_go_and_a_pointer_directs_the_wind(peer):
    clouds, held = peer.listen(PointCloud2, "cloth/points"), peer.listen(Float64, "stats/held")
    pin, point = peer.speak(Bool, "group/corners/pin"), peer.speak(PoseStamped, "wind/pose", 1)
    up = pose(0.0, 0.0, 0.0)
    # Its x axis points half upwards; straight up the floor would shelter the cloth.
    up.pose.orientation.y, up.pose.orientation.w = -math.sin(math.pi / 8), math.cos(math.pi / 8)
    fast = Parameter("wind_pointer_speed", value=12.0).to_parameter_msg()
    (changed,) = peer.call(SetParameters, "set_parameters", SetParameters.Request(parameters=[fast])).results
    assert changed.successful
    pin(Bool(data=True))
    peer.wait_until(lambda: held and held[-1].data == 4.0, "four pinned corners")
    peer.wait_until(
        lambda: positions(clouds[-1])[:, 2].max() > positions(clouds[-1])[-1, 2] + 0.02,
        "the cloth to be blown up between its corners",
        meanwhile=lambda: point(up),
    )
    pin(Bool(data=False))
    peer.wait_until(lambda: held[-1].data == 0.0, "no pinned corner")
    assert peer.call(Trigger, "reset", Trigger.Request()).success
    peer.wait_until(lambda: held[-1].data == 1.0, "the pin of the scene")


def test_a_moved_obstacle_is_shown_where_it_is(peer):
    shown = peer.listen(MarkerArray, "obstacles", LATCHED)
    move = peer.speak(PoseStamped, "obstacle/ball/pose", 1)

    def ball_at(x):
        balls = [m for array in shown[-1:] for m in array.markers if m.ns == "ball"]
        return balls and math.isclose(balls[0].pose.position.x, x, abs_tol=1e-9)

    peer.wait_until(lambda: ball_at(0.0), "the ball at its start")
    assert {marker.ns for marker in shown[-1].markers} == {"ball", "floor"}
    ball = next(marker for marker in shown[-1].markers if marker.ns == "ball")
    assert (ball.type, ball.scale.x) == (Marker.SPHERE, pytest.approx(0.2))
    peer.wait_until(lambda: ball_at(0.25), "the ball at 0.25 m", meanwhile=lambda: move(pose(0.25, 0.0, 0.2)))


def test_the_camera_sees_what_neither_the_ball_nor_the_floor_hides(peer):
    seen = peer.listen(PointCloud2, "cloth/visible_points")
    clouds = peer.listen(PointCloud2, "cloth/points")
    look = peer.speak(PoseStamped, "camera/pose", 1)
    above, below = pose(0.01, 0.02, 3.0), pose(0.0, 0.0, -3.0)
    above.pose.orientation.x, above.pose.orientation.w = 1.0, 0.0  # looks down

    def sees(count):
        return seen and seen[-1].width == count

    # From above all that is not yet folded, from under the floor nothing.
    peer.wait_until(lambda: sees(0), "a camera that sees nothing", meanwhile=lambda: look(below))
    assert peer.call(Trigger, "reset", Trigger.Request()).success
    peer.wait_until(lambda: sees(VERTICES), "a camera that sees the cloth whole", meanwhile=lambda: look(above))
    info = CameraInfo(width=640, height=480, k=[5540.0, 0.0, 319.5, 0.0, 5540.0, 239.5, 0.0, 0.0, 1.0])
    tell = peer.speak(CameraInfo, "camera/info", 1)
    peer.wait_until(
        lambda: seen and 0 < seen[-1].width < VERTICES / 2, "a lens that sees a part", meanwhile=lambda: tell(info)
    )
    part = np.frombuffer(bytes(seen[-1].data), POINT)
    whole = next(cloud for cloud in clouds if stamp(cloud) == stamp(seen[-1]))
    assert positions(seen[-1]).tolist() == positions(whole)[part["id"]].tolist()
    assert np.abs(positions(seen[-1])[:, 0] - 0.01).max() < 0.06 * 3.0


def test_pause_stops_the_clouds_and_lets_them_go_on(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    peer.wait_until(lambda: clouds, "a cloud")
    paused = peer.call(SetBool, "pause", SetBool.Request(data=True))
    assert paused.success
    assert "paused after step" in paused.message
    again = peer.call(SetBool, "pause", SetBool.Request(data=True))
    assert again.message == "was paused already"
    count = len(clouds)
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    peer.wait_until(lambda: len(reports) >= 2, "two seconds to pass")
    assert len(clouds) - count <= 1  # one may have been under way
    assert value(reports[-1], "paused") == "true"
    assert peer.call(SetBool, "pause", SetBool.Request(data=False)).success
    count = len(clouds)
    peer.wait_until(lambda: len(clouds) > count + 5, "clouds again")


def test_paused_it_is_stepped_kept_and_restored_bit_for_bit(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")

    def order(name):
        answer = peer.call(Trigger, name, Trigger.Request())
        assert answer.success, answer.message
        return answer.message

    def steps(count):
        """What is published in so many steps."""
        since = peer.node.get_clock().now().nanoseconds  # something else may still be under way
        for _ in range(count):
            order("step")

        def new():
            return [positions(cloud) for cloud in clouds if stamp(cloud) >= since]

        peer.wait_until(lambda: len(new()) >= count, "a cloud of each step")
        assert len(new()) == count
        return new()

    answer = peer.call(Trigger, "step", Trigger.Request())
    assert (answer.success, answer.message) == (False, "it is not paused: call ~/pause with true before")
    assert peer.call(SetBool, "pause", SetBool.Request(data=True)).success
    assert order("snapshot").startswith("kept step")
    first = steps(6)
    before = len(clouds)
    order("restore")
    peer.wait_until(lambda: len(clouds) > before, "the cloth as it was kept")  # shown while paused, too
    again = steps(6)
    assert [a.tobytes() for a in again] == [f.tobytes() for f in first]
    assert first[0].tobytes() != first[-1].tobytes()
    assert peer.call(SetBool, "pause", SetBool.Request(data=False)).success


def test_reset_puts_the_cloth_back(peer):
    clouds = peer.listen(PointCloud2, "cloth/points")
    peer.wait_until(lambda: clouds and positions(clouds[-1])[:, 2].min() < 0.4, "the cloth to fall")
    answer = peer.call(Trigger, "reset", Trigger.Request())
    assert answer.success
    assert answer.message.startswith("reset after step")
    peer.wait_until(lambda: positions(clouds[-1])[:, 2].min() > 0.48, "the cloth to be where it started")


def value(array, key):
    values = {pair.key: pair.value for status in array.status for pair in status.values}
    return values[key]


def test_diagnostics_tell_how_it_goes(peer, node):
    reports = peer.listen(DiagnosticArray, "/diagnostics")
    report = peer.wait_until(lambda: reports and reports[-1], "diagnostics")
    names = {status.name for status in report.status}
    assert names == {f"cloth_sim: {part}" for part in ("timing", "cloth", "inputs", "session")}
    assert {status.hardware_id for status in report.status} == {"/cloth_sim"}
    assert float(value(report, "nominal_hz")) == 50.0
    assert float(value(report, "max_stretch")) < 1.1
    assert value(report, "session_folder") in node.output
    assert value(report, "vertices") == str(VERTICES)
