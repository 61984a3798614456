"""The rows of ``soak.py``: a real node in a process of its own, looked at from outside."""
