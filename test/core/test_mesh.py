"""Meshes: areas, masses, groups, stiffness, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from cloth_core import ClothMesh, Material, MeshError
from cloth_core.linear import bending_matrix
from cloth_core.validation.geometry import irregular_sheet


@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (5, 3), (12, 17)])
def test_grid_areas_add_up_to_the_rectangle(columns, rows):
    mesh = ClothMesh.grid(width=1.2, height=0.7, columns=columns, rows=rows)
    assert mesh.vertex_count == columns * rows
    assert len(mesh.triangles) == 2 * (columns - 1) * (rows - 1)
    assert mesh.vertex_area.sum() == pytest.approx(1.2 * 0.7, rel=1e-13)
    assert mesh.vertex_mass(Material(areal_density=0.25)).sum() == pytest.approx(0.25 * 1.2 * 0.7, rel=1e-13)


def test_grid_is_centred_flat_and_faces_up():
    mesh = ClothMesh.grid(width=1.0, height=0.6, columns=4, rows=3)
    np.testing.assert_allclose(mesh.rest_position.mean(axis=0), 0, atol=1e-15)
    np.testing.assert_allclose(np.ptp(mesh.rest_position, axis=0), [1.0, 0.6, 0.0], atol=1e-15)
    a, b, c = (mesh.rest_position[mesh.triangles[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_groups_lie_where_their_names_say():
    mesh = ClothMesh.grid(width=1.0, height=0.6, columns=4, rows=3)
    x, y, _ = mesh.rest_position.T
    assert (x[mesh.group("left")] == x.min()).all() and len(mesh.group("left")) == 3
    assert (x[mesh.group("right")] == x.max()).all()
    assert (y[mesh.group("top")] == y.max()).all() and len(mesh.group("top")) == 4
    assert (y[mesh.group("bottom")] == y.min()).all()
    np.testing.assert_allclose(
        mesh.rest_position[mesh.group("corners"), :2], [[-0.5, 0.3], [0.5, 0.3], [-0.5, -0.3], [0.5, -0.3]]
    )
    assert set(mesh.group("corners")[:2]) <= set(mesh.group("top"))


def test_an_unknown_group_is_named_with_those_there_are():
    with pytest.raises(MeshError, match=r"'collar'.*bottom.*corners.*left.*right.*top"):
        ClothMesh.grid(width=1, height=1, columns=2, rows=2).group("collar")


def test_arrays_are_read_only():
    mesh = ClothMesh.grid(width=1, height=1, columns=3, rows=3)
    for array in (mesh.rest_position, mesh.triangles, mesh.spring_rest, mesh.vertex_area, mesh.uv):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_bending_costs_nothing_when_flat_turned_or_moved():
    mesh = irregular_sheet(1.0, 0.6, 8)
    bend = bending_matrix(mesh, Material(bend=1.0))
    turned = mesh.rest_position @ np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].T + [1, 2, 3]
    np.testing.assert_allclose(bend @ turned, 0, atol=1e-9)
    assert (np.linalg.eigvalsh(bend.toarray()) > -1e-9).all()


def test_from_triangles_weighs_an_irregular_sheet_right():
    mesh = irregular_sheet(1.3, 0.8, 11)
    assert mesh.vertex_area.sum() == pytest.approx(1.3 * 0.8, rel=1e-13)
    assert (mesh.vertex_area > 0).all()
    assert len(np.unique(mesh.spring_vertex, axis=0)) == len(mesh.spring_vertex)


def test_from_springs_takes_any_topology():
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [5, 5, 5]], float)
    pairs = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    mesh = ClothMesh.from_springs(x, pairs, stiffness=np.arange(6.0), mass=0.1, limited=[True] * 3 + [False] * 3)
    assert mesh.component.tolist() == [0, 0, 0, 0, 1]
    np.testing.assert_array_equal(mesh.spring_stiffness(Material()), np.arange(6.0))
    np.testing.assert_allclose(mesh.spring_rest, [1, 1, 1] + [2**0.5] * 3)
    assert mesh.vertex_mass(Material()).tolist() == [0.1] * 5


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
HALVES = [[0, 1, 2], [1, 3, 2]]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (
            lambda: ClothMesh.grid(width=1, height=1, columns=1, rows=5),
            "columns: 1 is not a whole number of at least 2",
        ),
        (lambda: ClothMesh.grid(width=1, height=1, columns=5, rows="5"), "rows: '5' is not a whole number of at least"),
        (lambda: ClothMesh.grid(width=1, height=1, columns=5, rows=True), "rows: True is not a whole number"),
        (
            lambda: ClothMesh.grid(width=-1, height=1, columns=3, rows=3),
            r"width: -1 is not a positive number up to 2e\+06 m",
        ),
        (lambda: ClothMesh.grid(width=np.inf, height=1, columns=3, rows=3), "width: inf is not a positive number"),
        (lambda: ClothMesh.grid(width=1, height="1", columns=3, rows=3), "height: '1' is not a positive number"),
        (lambda: ClothMesh.grid(width=1, height=3e6, columns=3, rows=3), r"height: 3000000.0 is not .* up to 2e\+06 m"),
        (lambda: ClothMesh.from_trimesh("sheet.stl"), "'sheet.stl' is not a trimesh.Trimesh; ClothMesh.load"),
        (lambda: ClothMesh.load(None), "path: None is not the path of a mesh file"),
        (
            lambda: ClothMesh.from_triangles(np.where(SQUARE == 1, np.nan, SQUARE), HALVES),
            "vertices not finite .*: 1, 2, 3;",
        ),
        (
            lambda: ClothMesh.from_triangles(SQUARE, [[0, 1, 2], [1, 7, 2]]),
            r"triangles that name vertices outside 0 \.\. 3: 1;",
        ),
        (
            lambda: ClothMesh.from_triangles(SQUARE, [[0, 1, 2], [1, 3, 3]]),
            "triangles that name the same vertex twice: 1;",
        ),
        (lambda: ClothMesh.from_triangles(SQUARE, HALVES[:1]), "vertices that belong to no triangle: 3;"),
        (
            lambda: ClothMesh.from_triangles(SQUARE * [1, 0, 0] + [[0, 0, 0], [0, 0, 0], [3, 0, 0], [0, 0, 0]], HALVES),
            "triangles without area.*: 0, 1;",
        ),
        (lambda: ClothMesh.from_triangles(np.zeros((0, 3)), np.zeros((0, 3), int)), r"shape \(V, 3\)"),
        (
            lambda: ClothMesh.from_springs(SQUARE, [[0, 4]], stiffness=1, mass=1),
            "springs that name vertices outside .*: 0;",
        ),
        (lambda: ClothMesh.from_springs(SQUARE, [[0, 1]], stiffness=-1, mass=1), r"stiffness \(N/m\) .*: 0;"),
        (
            lambda: ClothMesh.from_springs(SQUARE, [[0, 1]], stiffness=1, mass=[1, 0, 1, np.nan]),
            r"mass \(kg\) .*: 1, 3;",
        ),
        (lambda: ClothMesh.from_springs(SQUARE, [[0, 1]], stiffness=1, mass=1, rest_length=[-2]), r"rest length \(m\)"),
        (lambda: ClothMesh.from_triangles(SQUARE, HALVES, groups={"hem": [4]}), "group 'hem'"),
    ],
)
def test_bad_meshes_are_refused_with_the_elements_at_fault(build, message):
    with pytest.raises(MeshError, match=message):
        build()


def test_digest_tells_meshes_apart():
    one, same = (ClothMesh.grid(width=1, height=1, columns=3, rows=3) for _ in range(2))
    assert one.digest == same.digest
    assert one.digest != ClothMesh.grid(width=1, height=1.0001, columns=3, rows=3).digest
