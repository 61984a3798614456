"""W along threads and inertia across them: W by itself takes a thread for as stiff across as along."""

from __future__ import annotations

import math

from cloth_core.kernels import inlined_kernel, kernel
from cloth_core.kernels.tensors import projection, times

SOFT = 0.7
"""What threads resist a push with, beside the inertia of a vertex: from about twice that on they are what bears it."""


@inlined_kernel
def joined(hard, v, along, push, yields):
    """How vertex ``v`` moves of what W moves it ``along`` threads, and of a ``push``, to which it ``yields`` across."""
    x, y, z = times(hard, v, along[0], along[1], along[2])
    px, py, pz = push
    kx, ky, kz = times(hard, v, px, py, pz)
    px, py, pz = px - kx, py - ky, pz - kz
    kx, ky, kz = times(hard, v, px, py, pz)
    return x + yields * (px - kx), y + yields * (py - ky), z + yields * (pz - kz)


@kernel
def find_hardness(along, mass, hard):
    """Project onto what threads bear of a push of each vertex: into ``hard`` (V, 6).

    From what they resist ``along`` (V, 6) kg themselves, beside its ``mass`` (V,) kg; symmetric tensors.
    """
    for v in range(mass.shape[0]):
        soft = SOFT * mass[v]
        tensor = along[v, 0], along[v, 1], along[v, 2], along[v, 3], along[v, 4], along[v, 5]
        hard[v, 0], hard[v, 1], hard[v, 2], hard[v, 3], hard[v, 4], hard[v, 5] = projection(tensor, soft)


@kernel
def keep(hard, push, kept):
    """What threads bear of a ``push`` (V, 3) of the vertices, into ``kept`` (V, 3)."""
    for v in range(push.shape[0]):
        kept[v, 0], kept[v, 1], kept[v, 2] = times(hard, v, push[v, 0], push[v, 1], push[v, 2])


@kernel
def join(hard, push, mass, across, most, moved):
    """Of what W has ``moved`` (V, 3) m keep what goes along threads, and add what goes across them; in place.

    There the ``push`` (V, 3) kg m meets inertia, ``mass`` (V,) kg, and what resists ``across`` (V,) kg. No vertex goes
    farther than ``most`` m.
    """
    for v in range(push.shape[0]):
        x, y, z = joined(
            hard, v, (moved[v, 0], moved[v, 1], moved[v, 2]), (push[v, 0], push[v, 1], push[v, 2]),
            1.0 / (mass[v] + across[v]),
        )  # fmt: skip
        way = math.sqrt(x * x + y * y + z * z)
        share = most / way if way > most else 1.0
        moved[v, 0], moved[v, 1], moved[v, 2] = share * x, share * y, share * z
