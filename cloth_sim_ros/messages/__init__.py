"""Messages as bytes and as values: CDR by numpy, conversions checked field by field. No ROS import."""
