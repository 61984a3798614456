"""What is a closed surface, what is refused, and what is mended."""

from __future__ import annotations

import warnings

import bodies
import numpy as np
import pytest
import trimesh

from cloth_core.errors import MeshError, MeshWarning
from cloth_core.fields import Closed, Solid, closed, read_closed
from cloth_core.fields import surface as module

BOX = trimesh.creation.box(extents=(0.6, 0.4, 0.2))


def volume(surface: Closed) -> float:
    return float(trimesh.Trimesh(surface.position, surface.triangles, process=False).volume)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "glb"])
def test_every_format_gives_the_same_solid(tmp_path, suffix):
    """STL repeats corners, GLB is in float32: all are closed, and enclose what was written."""
    path = tmp_path / f"box.{suffix}"
    BOX.export(path)
    surface = read_closed(path)
    assert volume(surface) == pytest.approx(0.048, rel=1e-6)
    assert len(np.unique(surface.triangles)) == 8


def test_corners_that_differ_by_rounding_are_joined():
    soup = BOX.triangles + np.random.default_rng(0).uniform(-1e-10, 1e-10, BOX.triangles.shape)
    surface = closed(soup.reshape(-1, 3), np.arange(36).reshape(12, 3))
    assert len(np.unique(surface.triangles)) == 8


def test_a_hole_is_refused_by_its_edges_and_its_place(tmp_path):
    path = tmp_path / "open.ply"
    trimesh.Trimesh(BOX.vertices, BOX.faces[1:], process=False).export(path)
    with pytest.raises(MeshError) as refused:
        read_closed(path)
    text, (a, b, c) = str(refused.value), BOX.faces[0]
    assert text.startswith(f"{path}: not watertight: 1 hole of 3 edges (")
    middle = BOX.vertices[[a, b, c]].mean(axis=0)
    assert "around ({:.4g}, {:.4g}, {:.4g}) m".format(*middle) in text
    for edge in ((a, b), (b, c), (c, a)):
        assert f"{edge[0]}-{edge[1]}" in text or f"{edge[1]}-{edge[0]}" in text


def test_holes_are_filled_with_a_warning():
    """Of a ball without two triangles and a patch around a vertex: closed again, and as large but for the patch."""
    ball = bodies.ball(0.3)
    patch = np.flatnonzero((ball.triangles == ball.triangles[300, 0]).any(axis=1))
    assert 5 <= len(patch) <= 6
    opened = np.delete(ball.triangles, np.union1d([10, 900], patch), axis=0)
    with pytest.warns(MeshWarning, match="scan: 3 holes of .* edges .* filled"):
        mended = closed(ball.position, opened, mend=True, source="scan")
    assert module.hole_loops(mended.triangles) == []
    assert volume(mended) == pytest.approx(volume(Closed(*ball)), rel=2e-3)
    distance = Solid.of_surface(mended).measure(np.zeros((1, 3)))[0]
    assert distance[0] == pytest.approx(-0.3, abs=0.005)


def test_two_holes_that_meet_in_a_vertex_are_two():
    ball = bodies.ball(0.3)
    vertex = ball.triangles[300, 0]
    around = np.flatnonzero((ball.triangles == vertex).any(axis=1))
    first = around[0]
    apart = [t for t in around if len(np.intersect1d(ball.triangles[t], ball.triangles[first])) == 1]
    loops = module.hole_loops(np.delete(ball.triangles, [first, apart[0]], axis=0))
    assert sorted(len(loop) for loop in loops) == [3, 3]


def test_an_edge_that_three_triangles_share_is_a_hole():
    flap = np.vstack([BOX.vertices, [0.0, 0.0, 1.0]])
    fin = np.vstack([BOX.faces, [BOX.faces[0, 0], BOX.faces[0, 1], 8]])
    with pytest.raises(MeshError, match="not watertight: 1 hole of 3 edges"):
        closed(flap, fin)


def test_a_turned_triangle_is_a_fault_that_can_be_mended():
    faces = BOX.faces.copy()
    faces[4] = faces[4, ::-1]
    with pytest.raises(MeshError, match="not watertight"):
        closed(BOX.vertices, faces)
    with pytest.warns(MeshWarning, match="wound against their neighbours turned: 4"):
        assert volume(closed(BOX.vertices, faces, mend=True)) == pytest.approx(0.048)


def test_inside_out_is_refused_or_turned():
    with pytest.raises(MeshError, match="inside out"):
        closed(BOX.vertices, BOX.faces[:, ::-1])
    with pytest.warns(MeshWarning, match="inside out, and turned"):
        assert volume(closed(BOX.vertices, BOX.faces[:, ::-1], mend=True)) == pytest.approx(0.048)


def test_a_sheet_with_two_sides_encloses_nothing():
    sheet = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(MeshError, match="encloses no volume"):
        closed(sheet, np.array([[0, 1, 2], [0, 2, 1]]))


@pytest.mark.parametrize(
    ("position", "triangles", "words"),
    [
        (BOX.vertices, np.zeros((0, 3), int), "no triangles"),
        (BOX.vertices, np.array([[0, 1, 99]]), "outside 0 .. 7"),
        (BOX.vertices * np.nan, BOX.faces, "not finite"),
        (BOX.vertices[:, :2], BOX.faces, "rows of 3 numbers"),
    ],
)
def test_what_is_no_mesh_is_refused(position, triangles, words):
    with pytest.raises(MeshError, match=words):
        closed(position, triangles)


def test_a_file_that_is_none_is_named(tmp_path):
    path = tmp_path / "gone.stl"
    with pytest.raises(MeshError, match=r"gone\.stl"):
        read_closed(path)
    path.write_bytes(b"not a mesh")
    with pytest.raises(MeshError, match=r"gone\.stl"):
        read_closed(path)


def test_a_good_mesh_is_left_alone():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        surface = closed(BOX.vertices, BOX.faces, mend=True)
    assert np.array_equal(surface.position, BOX.vertices)
    assert np.array_equal(surface.triangles, BOX.faces)
