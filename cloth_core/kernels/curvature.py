"""Forces of the quadratic bending energy."""

from __future__ import annotations

from cloth_core.kernels import kernel


@kernel
def add_bending_forces(position, velocity, start, vertex, weight, bend, viscosity_time, force):
    """Add -Q (x + ``viscosity_time`` v) of the bending energy to ``force`` (V, 3) N.

    Q is ``bend`` N m times the sum of weight outer weight over the readings of curvature: reading r has the entries
    ``start`` (R + 1,) [r] to [r + 1] of ``vertex`` (N,) and ``weight`` (N,) 1/m.
    """
    for r in range(start.shape[0] - 1):
        for a in range(3):
            reading = 0.0
            for n in range(start[r], start[r + 1]):
                v = vertex[n]
                reading += weight[n] * (position[v, a] + viscosity_time * velocity[v, a])
            for n in range(start[r], start[r + 1]):
                force[vertex[n], a] -= bend * reading * weight[n]
