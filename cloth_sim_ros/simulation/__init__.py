"""The cloth as the node drives it: newest inputs in, one frame a slot out, on absolute deadlines. No ROS import."""
