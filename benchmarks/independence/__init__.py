"""Parts of benchmarks/mesh_independence.py."""
