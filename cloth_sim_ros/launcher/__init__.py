"""What `make run` needs beside the node: child processes and a status line."""
