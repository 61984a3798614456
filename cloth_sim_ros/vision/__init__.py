"""What a camera sees of the cloth. No ROS import."""
