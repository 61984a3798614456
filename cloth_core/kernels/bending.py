"""Bending by its constant Hessian: what goes into its implicit solve."""

from __future__ import annotations

from numba import prange

from cloth_core.kernels import kernel, lane_kernel, shared_kernel


@lane_kernel
def look_ahead(position, velocity, lag, time, ahead):
    """Where ``velocity`` + ``lag`` (V, 3) m/s lead in ``time`` s, into ``ahead`` (V, 3) m."""
    for v in range(position.shape[0]):
        for a in range(3):
            ahead[v, a] = position[v, a] + time * (velocity[v, a] + lag[v, a])


@shared_kernel
def add_up_impulses(indptr, indices, data, ahead, mass, gravity, time, impulse):
    """``time`` s times weight and the force of a Hessian at ``ahead`` (V, 3) m, into ``impulse`` (V, 3) N s."""
    for v in prange(mass.shape[0]):
        x = y = z = 0.0
        for p in range(indptr[v], indptr[v + 1]):
            j = indices[p]
            w = data[p]
            x += w * ahead[j, 0]
            y += w * ahead[j, 1]
            z += w * ahead[j, 2]
        m = mass[v]
        impulse[v, 0] = time * (m * gravity[0] - x)
        impulse[v, 1] = time * (m * gravity[1] - y)
        impulse[v, 2] = time * (m * gravity[2] - z)


@kernel
def energy(indptr, indices, data, position):
    """J, half of position times a symmetric Hessian times ``position`` (V, 3) m; its rows add up to nothing.

    By differences of positions, so that nothing cancels far from the origin.
    """
    total = 0.0
    for v in range(position.shape[0]):
        for p in range(indptr[v], indptr[v + 1]):
            j = indices[p]
            if j > v:
                x, y = position[j, 0] - position[v, 0], position[j, 1] - position[v, 1]
                z = position[j, 2] - position[v, 2]
                total -= 0.5 * data[p] * (x * x + y * y + z * z)
    return total
