"""Ways to advance the cloth by one substep on the same W."""

from cloth_core.integrators.implicit_midpoint import ImplicitMidpoint
from cloth_core.integrators.meyer2000 import Meyer2000
from cloth_core.integrators.model import Model, Substep

BY_NAME = {"implicit_midpoint": ImplicitMidpoint, "meyer2000": Meyer2000}

__all__ = ["BY_NAME", "ImplicitMidpoint", "Meyer2000", "Model", "Substep"]
