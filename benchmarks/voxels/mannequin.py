"""Makes the mannequins of the scenes of the human body, as a window dresser would: smooth, without a face or fingers.

    cd benchmarks && python -m voxels.mannequin          writes ../config/meshes/{mannequin,bust}.ply

Needs the extra [render], and the network for the body, see ``voxels.human``. The body's distance field is cut, if
at all, smoothed, and its level 0 drawn with triangles, as few as show the shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyvista as pv
import trimesh
from scipy.ndimage import distance_transform_edt, gaussian_filter, label

from cloth_core.fields import Closed, VoxelField
from voxels import human

FOLDER = Path(__file__).parents[2] / "config" / "meshes"
CELL = 0.005  # m
CLOSED = 0.015  # m, radius of the ball that gets into no hollow of what is left
SMOOTH = 0.007  # m, standard deviation
TRIANGLES = {"mannequin": 4000, "bust": 2000}
CUTS = [
    ((0.0, 0.0, 1.02), (0.0, 0.0, -1.0)),
    ((0.215, 0.0, 1.3), (0.94, 0.0, -0.34)),
    ((-0.215, 0.0, 1.3), (-0.94, 0.0, -0.34)),
]
"""What the bust lacks: points of the planes in m, and the way off them that is left out; the hips and both arms."""


def standing(body: Closed) -> Closed:
    """The body of the file, whose y points up, with its soles on z = 0 and its face towards -y."""
    x, y, z = body.position.T
    return body._replace(position=np.column_stack([x, -z, y - y.min()]))


def sculpted(body: Closed, cuts: Sequence[tuple[Sequence[float], Sequence[float]]], triangles: int) -> trimesh.Trimesh:
    """The smooth body without what lies beyond the cuts."""
    low, high = body.position.min(axis=0) - 6 * CELL, body.position.max(axis=0) + 6 * CELL
    shape = np.ceil((high - low) / CELL).astype(int) + 1
    points = low + CELL * np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    distance = VoxelField(surface=body, voxel=CELL).made(band=4 * CELL).distance(points)[0].clip(-4 * CELL, 4 * CELL)
    distance = filled(distance.reshape(shape)).ravel()
    for point, away in cuts:
        distance = np.maximum(distance, (points - point) @ np.array(away))
    smooth = gaussian_filter(distance.reshape(shape), SMOOTH / CELL)
    grid = pv.ImageData(dimensions=shape, spacing=3 * (CELL,), origin=low)
    grid["distance"] = smooth.ravel(order="F")
    drawn = grid.contour([0.0], scalars="distance").connectivity("largest").triangulate()
    coarse = drawn.decimate(1.0 - triangles / drawn.n_cells)
    return trimesh.Trimesh(coarse.points, coarse.regular_faces)


def filled(distance: np.ndarray) -> np.ndarray:
    """The distance on the grid, of the solid and of all hollows that a ball does not get into: eyes, mouth, ears."""
    parts, _ = label(distance > CLOSED)
    reached = parts == parts[0, 0, 0]
    return np.minimum(distance, CLOSED - CELL * distance_transform_edt(~reached))


def main() -> None:
    """Write both."""
    body = standing(human.body(None))
    for name, cuts in (("mannequin", []), ("bust", CUTS)):
        mesh = sculpted(body, cuts, TRIANGLES[name])
        trimesh.repair.fix_normals(mesh)
        if not mesh.is_watertight:
            raise SystemExit(f"{name}: the decimation left holes; try another number of triangles")
        path = FOLDER / f"{name}.ply"
        path.parent.mkdir(exist_ok=True)
        mesh.export(path)
        print(f"{path}: {len(mesh.faces)} triangles, {path.stat().st_size} bytes, {mesh.bounds.round(3).tolist()} m")


if __name__ == "__main__":
    main()
