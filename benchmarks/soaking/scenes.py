"""What the node simulates in the rows of ``soak.py``."""

from __future__ import annotations

from pathlib import Path

HANGING = """
cloth:
  grid: {{width: 1.0, height: 1.0, columns: {side}, rows: {side}}}
  position: [0, 0, 1.2]
  orientation: [0.5, 0.5, -0.5, 0.5]
material: {{areal_density: 0.15, stretch_warp: 500.0, stretch_weft: 500.0, shear: 15.0, damping: 0.8}}
obstacles:
  floor: {{plane: {{}}}}
  ball: {{sphere: {{radius: 0.2, center: [0.0, -0.5, 0.6]}}}}
fluids: {{pool: {{box: {{extents: [1, 1, 1], center: [0, 0, -50]}}}}}}
pins: [left]
grasps: {{hand: {{radius: 0.06}}}}
"""


def hanging(folder: Path, side: int) -> Path:
    """A scene file of ``side`` x ``side`` vertices that hang by one edge, with a hand, a ball and a floor."""
    file = folder / f"hanging_{side}.yaml"
    file.write_text(HANGING.format(side=side))
    return file
