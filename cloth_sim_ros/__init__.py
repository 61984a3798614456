"""Cloth simulation on ROS 2 topics: the floor that knows ROS and MCAP. The solver is `cloth_core`."""
