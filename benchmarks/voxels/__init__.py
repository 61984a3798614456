"""What ``benchmarks/fields.py`` measures."""
