"""Parts of benchmarks/bars.py."""
