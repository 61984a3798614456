"""A sheet as strain gauges in four directions, whose energy has a constant Hessian when their lengths are let go."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.material import Material


def gauges(material: Material) -> tuple[np.ndarray, np.ndarray]:
    """Directions and moduli of the gauges that make the sheet of a ``material``.

    Along warp and weft and along two diagonals at the angles a and -a to the warp. A gauge of direction d and
    modulus k stores k / 2 (|F d| - 1)^2 per area, F being the deformation gradient; for small strains the four
    together are the orthotropic sheet of :meth:`Material.sheet_stiffness`, for with diagonals of w each

        C_warp = k_warp + 2 w cos^4 a,  C_weft = k_weft + 2 w sin^4 a,  shear = C_cross = 2 w cos^2 a sin^2 a.

    The diagonals run at 45 degrees if that leaves no modulus negative, else as close to it as does.

    Returns:
        (4, 2) unit vectors, by their parts along warp and weft, and (4,) N/m.
    """
    warp, weft, shear = material.sheet_stiffness()
    square = min(max(1.0, shear / warp), weft / shear) if shear > 0.0 else 1.0  # tan^2 a
    cosine, sine = math.sqrt(1.0 / (1.0 + square)), math.sqrt(square / (1.0 + square))
    direction = np.array([[1.0, 0.0], [0.0, 1.0], [cosine, sine], [cosine, -sine]])
    diagonal = 0.5 * shear * (1.0 + square) ** 2 / square
    # Rounding may leave a trace below zero where a diagonal carries all that there is.
    threads = max(warp - shear / square, 0.0), max(weft - shear * square, 0.0)
    return direction, np.array([*threads, diagonal, diagonal])
