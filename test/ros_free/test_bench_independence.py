"""The comparison of meshes: shadows have their areas, the meshes are one cloth, the verdict follows the figures."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "benchmarks"))

import mesh_independence
from independence import scenes
from independence.meshes import grid, irregular, mean_over_area, on_edge
from independence.shadow import shadow_area


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.2])
def test_the_shadow_of_a_tilted_sheet_is_its_area_times_the_cosine(angle):
    mesh = irregular(6)(0.3, 0.2, 1)
    x, y, _ = mesh.rest_position.T
    tilted = np.stack([x * math.cos(angle), y, x * math.sin(angle)], axis=1)
    assert shadow_area(tilted, mesh.triangles) == pytest.approx(0.06 * math.cos(angle), rel=5e-3)


def test_what_overlaps_casts_one_shadow():
    mesh = grid(4)(0.2, 0.2, 0)
    folded = np.abs(mesh.rest_position)
    assert shadow_area(folded, mesh.triangles) == pytest.approx(0.01, rel=1e-2)


@pytest.mark.parametrize("mesher", [grid(8), irregular(8)], ids=["grid", "irregular"])
def test_meshers_make_the_same_piece(mesher):
    mesh = mesher(0.4, 0.8, 3)
    assert mesh.vertex_area.sum() == pytest.approx(0.32, rel=1e-12)
    np.testing.assert_allclose(np.ptp(mesh.rest_position, axis=0), [0.4, 0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(mesh.rest_position[on_edge(mesh, 1, -1.0), 1], -0.4, atol=1e-12)
    assert mean_over_area(mesh, mesh.rest_position[:, 0]) == pytest.approx(0.0, abs=2e-3)


def test_a_softer_ribbon_sags_by_the_cube_root():
    assert scenes.sag_of_a_ribbon(50.0) == pytest.approx(2.0 * scenes.sag_of_a_ribbon(400.0))
    assert scenes.sag(grid(12), 0) == pytest.approx(scenes.sag_of_a_ribbon(400.0), rel=0.03)


@pytest.mark.parametrize(
    ("off", "verdict", "good"), [(0.0, "aim", True), (0.02, "bar", True), (-0.05, "missed", False)]
)
def test_the_verdict_is_that_of_the_worst_mesh(off, verdict, good, capsys):
    told = iter([1.0, 1.0 + off, 1.0 + off, 1.0 + off / 2])
    row = mesh_independence.Row("length", "m", lambda mesher, seed: next(told), 4)
    assert mesh_independence._show(row, range(2)) is good
    assert capsys.readouterr().out.rstrip().endswith(f"| {verdict} |")
