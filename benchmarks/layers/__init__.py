"""Parts of benchmarks/self_collision.py."""
