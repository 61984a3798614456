"""Nested dissection: an elimination order in which a sparse factor stays sparse, and falls into dense blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from cloth_core.kernels import panels


@dataclass(frozen=True)
class Block:
    """Vertices that are eliminated together, after those of the two blocks that they separate."""

    vertices: np.ndarray
    children: tuple[int, ...] = ()


def dissect(matrix: csr_matrix, place: np.ndarray, largest: int) -> list[Block]:
    """Split the graph of a symmetric (N, N) ``matrix`` until the parts are small; parents come after children.

    Each part is cut at the median of its longest extent (George 1973, "Nested dissection of a regular finite element
    mesh"; geometric, after Miller et al. 1997, "Separators for sphere-packings and nearest neighbor graphs").

    Args:
        matrix: whose entries say who is neighbour to whom.
        place: (N, D) m, where the vertices lie, in the rest shape.
        largest: vertices of a part that is not split any more.
    """
    marked = np.zeros(matrix.shape[0], dtype=np.bool_)
    blocks: list[Block] = []

    def split(part: np.ndarray) -> int:
        if len(part) > largest:
            near, far = _halves(place, part)
            touches = np.empty(len(near), dtype=np.bool_)
            marked[far] = True
            panels.touching(matrix.indptr, matrix.indices, near, marked, touches)
            marked[far] = False
            if not touches.all():
                blocks.append(Block(near[touches], (split(near[~touches]), split(far))))
                return len(blocks) - 1
        blocks.append(Block(part))
        return len(blocks) - 1

    split(np.arange(matrix.shape[0]))
    return blocks


def _halves(place: np.ndarray, part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    points = place[part]
    along = points[:, np.ptp(points, axis=0).argmax()]
    order = part[np.argsort(along, kind="stable")]
    return order[: len(part) // 2], order[len(part) // 2 :]
