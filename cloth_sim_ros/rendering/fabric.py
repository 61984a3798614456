"""What a cloth is printed with: colour images in material coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cloth_core import ClothMesh

PIXELS_PER_METRE = 640.0
Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Fabric:
    """Colours of a cloth and how they are laid out.

    Args:
        ground: colour that covers most of it.
        figure: colour of the lines on it.
        back: what the other side's colours are multiplied by, 0..1 each.
        pattern: from material coordinates u, v in m and the size in m to the figure's share, 0..1.
        gloss: strength of the highlights, 0..1.
    """

    ground: Colour
    figure: Colour
    back: tuple[float, float, float]
    pattern: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    gloss: float = 0.1


def _stripes(distance: np.ndarray, *bands: tuple[float, float]) -> np.ndarray:
    """1 where ``distance`` m lies in one of the bands (start, end), soft over a pixel."""
    soft = 1.0 / PIXELS_PER_METRE
    share = np.zeros_like(distance)
    for start, end in bands:
        share = np.maximum(share, np.clip((distance - start) / soft, 0, 1) * np.clip((end - distance) / soft, 0, 1))
    return share


def _hem(u: np.ndarray, v: np.ndarray, size: np.ndarray) -> np.ndarray:
    inward = np.minimum(np.minimum(u, size[0] - u), np.minimum(v, size[1] - v))
    return _stripes(inward, (0.035, 0.06), (0.068, 0.074))


def _windowpane(u: np.ndarray, v: np.ndarray, _size: np.ndarray) -> np.ndarray:
    return 0.75 * np.maximum(_stripes(u % 0.1, (0.047, 0.053)), _stripes(v % 0.1, (0.047, 0.053)))


def _gingham(u: np.ndarray, v: np.ndarray, _size: np.ndarray) -> np.ndarray:
    return 0.5 * (_stripes(u % 0.11, (0.0, 0.055)) + _stripes(v % 0.11, (0.0, 0.055)))


def _tricolour(u: np.ndarray, _v: np.ndarray, size: np.ndarray) -> np.ndarray:
    return _stripes(u, (size[0] / 3.0, 2.0 * size[0] / 3.0))


FABRICS = {
    "silk": Fabric((178, 46, 58), (244, 219, 186), (1.0, 0.8, 0.8), _hem, gloss=0.2),
    "cotton": Fabric((232, 226, 214), (150, 160, 176), (0.80, 0.84, 0.90), _windowpane),
    "gingham": Fabric((250, 247, 240), (70, 118, 166), (0.92, 0.92, 0.95), _gingham),
    "bunting": Fabric((43, 92, 138), (242, 238, 228), (0.88, 0.90, 0.94), _tricolour),
}
"""Fabrics by name; the first is the default."""


def printed(fabric: Fabric, mesh: ClothMesh) -> np.ndarray | None:
    """The image, (rows, columns, 3) uint8, for a cloth with texture coordinates; None for one without."""
    if mesh.uv is None:
        return None
    size = _size(mesh)
    columns, rows = (round(min(2048.0, max(64.0, PIXELS_PER_METRE * extent))) for extent in size)
    u, v = np.meshgrid((np.arange(columns) + 0.5) / columns * size[0], (rows - np.arange(rows) - 0.5) / rows * size[1])
    share = fabric.pattern(u, v, size)[..., None]
    image = (1.0 - share) * np.array(fabric.ground) + share * np.array(fabric.figure)
    return image.round().astype(np.uint8)


def _size(mesh: ClothMesh) -> np.ndarray:
    """(2,) m: what the unit of u and of v measures on the cloth, as its springs have it on average."""
    i, j = mesh.spring_vertex.T
    squares, *_ = np.linalg.lstsq((mesh.uv[j] - mesh.uv[i]) ** 2, mesh.spring_rest**2, rcond=None)
    return np.sqrt(np.maximum(squares, 1e-6))
