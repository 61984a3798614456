"""The wiring to the ROS graph: the only part of the node that imports rclpy and message packages."""
