"""The motion that all are compared with, computed once and kept beside this file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from motion.cloth import release_test
from motion.contestants import Contestant
from motion.integrators import bdf2
from motion.measure import FRAME, SAMPLED, STIFFNESSES, frames_of, play

PATH = Path(__file__).with_name("reference.json")
STEP, ITERATIONS = 0.00025, 60  # s, solves in each: far beyond what still changes the figures


def compute() -> None:
    """Write the reference; takes minutes."""
    document = {"made by": "python benchmarks/motion.py --reference"}
    for k in STIFFNESSES:
        cloth = release_test(k)
        played = play(
            cloth, frames_of(cloth, Contestant("reference", bdf2), round(FRAME / STEP), ITERATIONS, hinge=False)
        )
        height = played.height[SAMPLED - 1 :: SAMPLED]
        document[str(k)] = {"mean_height": height.round(7).tolist(), "stretch": round(played.stretch, 4)}
    PATH.write_text(json.dumps(document, indent=1) + "\n")


def read() -> tuple[dict[int, np.ndarray], dict[int, float]]:
    """By stiffness: the mean height (m) every 0.1 s of the first second, and the largest stretch."""
    document = json.loads(PATH.read_text())
    entries = {k: document[str(k)] for k in STIFFNESSES}
    return {k: np.array(e["mean_height"]) for k, e in entries.items()}, {k: e["stretch"] for k, e in entries.items()}
