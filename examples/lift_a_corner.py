"""Take the cloth at its lowest point, lift it by 30 cm and say whether it came along; run it beside the cloth node.

python examples/lift_a_corner.py [namespace, /cloth_sim by default]
"""

from __future__ import annotations

import sys

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64


class Lifter(Node):
    """Waits for the cloth, closes the hand at its lowest vertex, then rises at 0.2 m/s and looks what became of it."""

    def __init__(self, cloth: str) -> None:
        super().__init__("lifter")
        self.hand = self.create_publisher(PoseStamped, f"{cloth}/grasp/hand/pose", 1)
        self.closure = self.create_publisher(Float64, f"{cloth}/grasp/hand/closure", 10)
        self.create_subscription(PointCloud2, f"{cloth}/cloth/points", self.see, 5)
        self.create_timer(0.02, self.move)
        self.get_logger().info(f"waiting for {cloth} to publish points and to listen to grasp/hand")
        self.corner: np.ndarray | None = None
        self.vertex, self.height, self.risen = 0, 0.0, 0.0

    def see(self, cloud: PointCloud2) -> None:
        """Look for the lowest vertex until the hand moves, and then how high it is."""
        points = np.frombuffer(bytes(cloud.data), np.float32).reshape(-1, cloud.point_step // 4)[:, :3]
        if self.risen == 0.0:
            self.vertex = int(points[:, 2].argmin())
            self.corner = points[self.vertex].astype(float)
        self.height = float(points[self.vertex, 2])

    def move(self) -> None:
        """Publish the hand: closed, and a little higher every time."""
        if self.corner is None or self.closure.get_subscription_count() == 0:
            return
        pose = PoseStamped()
        pose.header.stamp = self.get_clock().now().to_msg()
        pose.pose.position.x, pose.pose.position.y = float(self.corner[0]), float(self.corner[1])
        pose.pose.position.z = float(self.corner[2]) + self.risen
        self.hand.publish(pose)
        self.closure.publish(Float64(data=1.0))
        self.risen += 0.004
        if self.risen > 0.3:
            self.closure.publish(Float64(data=0.0))
            self.tell(self.height - float(self.corner[2]))
            raise SystemExit

    def tell(self, lifted: float) -> None:
        """Say how far the corner came along."""
        if lifted > 0.5 * self.risen:
            self.get_logger().info(f"caught vertex {self.vertex} and lifted it by {lifted:.2f} m")
        else:
            self.get_logger().warning(
                f"caught nothing that stayed in the hand: vertex {self.vertex} rose by {lifted:.2f} m "
                f"while the hand rose by {self.risen:.2f} m; /diagnostics and the log of the node say why"
            )


def main() -> None:
    """Run until the cloth is lifted."""
    rclpy.init()
    node = Lifter(sys.argv[1] if len(sys.argv) > 1 else "/cloth_sim")
    try:
        rclpy.spin(node)
    except (SystemExit, KeyboardInterrupt, ExternalShutdownException):
        pass
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
