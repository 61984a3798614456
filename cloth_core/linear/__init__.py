"""W, the paper's precomputed inverse, as one operator with several representations."""

from cloth_core.linear.assemble import stiffness_matrix
from cloth_core.linear.filter import ImplicitFilter

__all__ = ["ImplicitFilter", "stiffness_matrix"]
