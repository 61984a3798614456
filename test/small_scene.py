"""A scene that computes in no time, for the tests of the node and of what it drives; its last section is ``grasps``."""

from __future__ import annotations

SMALL_SCENE = """
cloth: {grid: {width: 0.4, height: 0.4, columns: 9, rows: 9}, position: [0.0, 0.0, 0.5]}
obstacles:
  ball: {sphere: {radius: 0.1, center: [0.0, 0.0, 0.2]}}
  floor: {plane: {}}
grasps:
  hand: {radius: 0.08, position: [0.2, 0.2, 0.5]}
"""
