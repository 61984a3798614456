"""Mesh files: what is read, what is mended with a warning, and what is refused; messages count as the file does."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import ClothMesh, MeshError, MeshWarning
from cloth_core.validation.geometry import irregular_sheet

SHEET = irregular_sheet(1.0, 0.8, 7)
POSITION, TRIANGLES = SHEET.rest_position, SHEET.triangles
V, T = len(POSITION), len(TRIANGLES)
some_triangles = st.sets(st.integers(0, T - 1), min_size=1, max_size=12).map(sorted)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("meshes")


def write(path: Path, position, triangles) -> Path:
    """All digits, all vertices, all triangles, in order."""
    if path.suffix == ".obj":
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(position, float).tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(triangles).tolist()]
        path.write_text("\n".join(lines) + "\n")
    else:
        trimesh.Trimesh(position, triangles, process=False).export(path)
    return path


def loaded(path: Path) -> tuple[ClothMesh, list[str]]:
    """The mesh, and what was said about it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        mesh = ClothMesh.load(path)
    assert all(warning.category is MeshWarning for warning in caught)
    return mesh, [str(warning.message) for warning in caught]


def assert_mended(folder, position, triangles, what, elements) -> None:
    """Both kinds of file give the good sheet and one warning that names the file and ``elements``."""
    shown = ", ".join(map(str, elements[:8])) + (f" and {len(elements) - 8} more" if len(elements) > 8 else "")
    for name in ("planted.obj", "planted.off"):
        mesh, said = loaded(write(folder / name, position, triangles))
        assert said == [f"{folder / name}: {what}: {shown}"]
        np.testing.assert_array_equal(mesh.triangles, TRIANGLES)
        np.testing.assert_allclose(mesh.rest_position, POSITION, atol=1e-7)


@pytest.mark.parametrize("extension", ["obj", "stl", "ply"])
def test_files_are_read_through_trimesh(tmp_path, extension):
    """STL holds every corner anew: vertices must come back joined."""
    sheet = ClothMesh.grid(width=0.4, height=0.3, columns=5, rows=4)
    path = tmp_path / f"sheet.{extension}"
    trimesh.Trimesh(sheet.rest_position * 1000, sheet.triangles, process=False).export(path)
    mesh = ClothMesh.load(path, scale=0.001)
    assert mesh.vertex_count == 20
    assert len(mesh.component) == 20 and mesh.component.max() == 0
    assert mesh.vertex_area.sum() == pytest.approx(0.12, rel=1e-5)
    np.testing.assert_allclose(np.ptp(mesh.rest_position, axis=0), [0.4, 0.3, 0.0], atol=1e-6)


def test_a_good_file_comes_back_to_the_last_digit_and_without_a_word(folder):
    mesh, said = loaded(write(folder / "good.obj", POSITION, TRIANGLES))
    assert (mesh.digest, said) == (SHEET.digest, [])


def test_an_obj_may_have_normals_texture_polygons_comments_and_numbers_from_the_end(tmp_path):
    path = tmp_path / "rich.obj"
    path.write_text(
        "# a box lid\nmtllib lid.mtl\no lid\nv 0 0 0 0.5 0.5 0.5 # with a colour\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "vt 0 0\nvt 1 0\nvn 0 0 1\nusemtl red\ns off\nf 1/1/1 2/2/1 \\\n 3/1/1 4/2/1\n"
        "v 2 0 0\nv 2 1 0\nf -5//1 -2//1 -1//1\nf 3 2 6 # the last\n"
    )
    mesh = ClothMesh.load(path)
    assert mesh.triangles.tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 5], [2, 1, 5]]
    assert mesh.vertex_area.sum() == pytest.approx(2.0)


@given(st.sets(st.integers(0, V - 1), min_size=1, max_size=12).map(sorted), st.sampled_from([9.0, np.nan]))
def test_vertices_without_a_triangle_are_dropped(folder, places, coordinate):
    position = np.insert(POSITION, np.array(places) - np.arange(len(places)), coordinate, axis=0)
    moved = np.setdiff1d(np.arange(len(position)), places)
    assert_mended(folder, position, moved[TRIANGLES], "vertices that belong to no triangle were dropped", places)


@given(some_triangles, st.permutations(range(3)))
def test_repeated_triangles_are_dropped(folder, chosen, order):
    """Seen from behind, as double-sided exports have them, too."""
    triangles = np.concatenate([TRIANGLES, TRIANGLES[chosen][:, order]])
    later = list(range(T, T + len(chosen)))
    assert_mended(folder, POSITION, triangles, "triangles that repeat an earlier one were dropped", later)


@given(some_triangles)
def test_triangles_wound_the_wrong_way_are_turned(folder, chosen):
    triangles = TRIANGLES.copy()
    triangles[chosen] = triangles[chosen][:, ::-1]
    assert_mended(folder, POSITION, triangles, "triangles wound against their neighbours were turned", chosen)


@given(some_triangles, st.floats(1e-3, 1.0))
def test_dust_is_dropped(folder, places, size):
    """Triangles all alone, however large."""
    count, places = len(places), np.array(places)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) * size
    position = np.concatenate([POSITION, *(corners + np.array([0, 0, 1 + n]) for n in range(count))])
    triangles = np.insert(TRIANGLES, places - np.arange(count), V + np.arange(3 * count).reshape(-1, 3), axis=0)
    what = "triangles of small parts that hang together with nothing were dropped"
    assert_mended(folder, position, triangles, what, places)


def test_a_tiny_part_of_several_triangles_is_dust_and_a_small_one_is_not(folder):
    for size, kept in ((0.005, False), (0.02, True)):
        speck = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]) * size + [0, 0, 2]
        position, triangles = (
            np.concatenate([POSITION, speck]),
            [*TRIANGLES.tolist(), [V, V + 1, V + 2], [V + 1, V + 3, V + 2]],
        )
        mesh, said = loaded(write(folder / "speck.obj", position, triangles))
        assert mesh.vertex_count == (V + 4 if kept else V)
        assert [re.sub(".*: ", "", text) for text in said] == ([] if kept else [f"{T}, {T + 1}"])


def test_several_faults_are_mended_at_once_and_counted_as_in_the_file(folder):
    position = np.concatenate([[[7, 7, 7]], POSITION, [[0, 0, 9], [1, 0, 9], [0, 1, 9]]])
    triangles = TRIANGLES + 1
    triangles[5] = triangles[5, ::-1]
    triangles = np.concatenate([triangles[:1], triangles[:1], triangles[1:], [[V + 1, V + 2, V + 3]]])
    mesh, said = loaded(write(folder / "many.obj", position, triangles))
    assert mesh.digest == SHEET.digest
    assert [re.sub(".*: ", "", text) for text in said] == ["0", "1", "6", str(T + 1)]


@pytest.mark.parametrize("extension", ["obj", "ply", "off", "glb"])
def test_corners_at_the_same_place_become_one(folder, extension):
    corners = POSITION[TRIANGLES].reshape(-1, 3)
    mesh, said = loaded(write(folder / f"soup.{extension}", corners, np.arange(3 * T).reshape(-1, 3)))
    assert (mesh.vertex_count, len(mesh.triangles), said) == (V, T, [])
    assert mesh.component.max() == 0


def with_changed(array, rows, value):
    changed = np.array(array)
    changed[rows] = value
    return changed


@pytest.mark.parametrize(
    ("position", "triangles", "message"),
    [
        (with_changed(POSITION, [4, 9], np.nan), TRIANGLES, "vertices not finite or beyond .*: 4, 9;"),
        (with_changed(POSITION, [4], POSITION[5] + 1e-12), TRIANGLES, r"triangles without area.*: \d+"),
        (POSITION, with_changed(TRIANGLES, [3, 7], V), r"triangles that name vertices outside 0 \.\. \d+: 3, 7;"),
        (POSITION, with_changed(TRIANGLES, [3, 7], [0, 1, 1]), "triangles that name the same vertex twice: 3, 7;"),
        (POSITION, TRIANGLES[:0], "no triangles"),
        (POSITION * 1e9, TRIANGLES, "vertices not finite or beyond .* m: 1, 2, 3"),
    ],
)
def test_what_cannot_be_mended_is_refused_by_file_and_element(folder, position, triangles, message):
    with pytest.raises(MeshError, match=f"bad.obj: {message}"):
        ClothMesh.load(write(folder / "bad.obj", position, triangles))


def test_three_flaps_are_refused_as_the_file_counts_them(folder):
    """Behind a repeated triangle and an unused vertex, which are dropped before."""
    path = folder / "flaps.obj"
    path.write_text("v 9 9 9\nv 0 0 0\nv 0 1 0\nv 1 0 0\nv -1 0 0\nv 0 0 1\nf 2 3 4\nf 4 3 2\nf 3 2 5\nf 2 3 6\n")
    with pytest.raises(MeshError, match=r"edges of more than two triangles: 1-2; .*\(0, 2, 3\)"):
        ClothMesh.load(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", r"triangles that name vertices outside 0 \.\. 2: 0;"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -9\n", r"triangles that name vertices outside 0 \.\. 2: 0;"),
        ("v 0 0 0\nv 1 0\n", "line 2 is not a vertex or face of an OBJ file: 'v 1 0'"),
        ("v 0 0 0\nf 1 2 x\n", "line 2 is not a vertex or face of an OBJ file: 'f 1 2 x'"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "triangles without area.*: 0;"),
        ("v 0 0 0\n", "no triangles"),
        ("", "no triangles"),
    ],
)
def test_a_broken_obj_is_refused_with_the_place(tmp_path, text, message):
    path = tmp_path / "broken.obj"
    path.write_text(text)
    with pytest.raises(MeshError, match=f"broken.obj: .*{message}"):
        ClothMesh.load(path)


@pytest.mark.parametrize("name", ["missing.obj", "missing.stl", "what.xyzzy"])
def test_a_file_that_is_not_there_is_named(tmp_path, name):
    with pytest.raises(MeshError, match=rf"{name}: cannot be read as a mesh: there is no such file"):
        ClothMesh.load(tmp_path / name)
    (tmp_path / name).mkdir()
    with pytest.raises(MeshError, match=rf"{name}: cannot be read as a mesh: it is a folder"):
        ClothMesh.load(tmp_path / name)


def test_an_ending_that_names_no_format_is_answered_with_those_that_do(tmp_path):
    path = tmp_path / "sheet.txt"
    path.write_text("hello")
    with pytest.raises(MeshError, match=r"sheet.txt: cannot be read as a mesh: \.txt is not one of .*obj, .*ply, stl"):
        ClothMesh.load(path)


@pytest.mark.parametrize("extension", ["ply", "stl", "glb"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
def test_a_file_that_was_cut_off_is_refused_without_a_word_of_the_library_that_reads_it(folder, extension, share):
    path = folder / f"cut.{extension}"
    trimesh.Trimesh(POSITION, TRIANGLES, process=False).export(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(
        MeshError, match=rf"cut.{extension}: .* does not hold a whole and sound .{extension} file"
    ) as told:
        ClothMesh.load(path)
    assert told.value.__cause__ is None and told.value.__suppress_context__


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf, "x", None])
def test_a_scale_that_is_none_is_refused(folder, scale):
    with pytest.raises(MeshError, match=r"any.obj: scale .* is not a positive number"):
        ClothMesh.load(folder / "any.obj", scale=scale)
