"""W, the paper's precomputed inverse, as one operator with several representations."""

from cloth_core.linear.assemble import Assembly, bending_matrix, stretch_matrix
from cloth_core.linear.elimination import Plans
from cloth_core.linear.filter import ImplicitFilter

__all__ = ["Assembly", "ImplicitFilter", "Plans", "bending_matrix", "stretch_matrix"]
