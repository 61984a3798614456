"""What a session holds, how it is written while the node runs, read back, and verified."""
