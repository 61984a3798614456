"""Integrators compared on one cloth that falls and swings: all on the paper's constant W, counted by solves with it."""
