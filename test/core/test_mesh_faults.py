"""Every fault planted anywhere in a good mesh is refused, and exactly the planted elements are named."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cloth_core import ClothMesh, ClothSolver, Material, MeshError, SolverConfig
from cloth_core.meshing import faults
from cloth_core.physics.stiffness import check_stiffness
from cloth_core.validation.geometry import irregular_sheet

SHEET = irregular_sheet(1.0, 0.8, 7)
POSITION, TRIANGLES = SHEET.rest_position, SHEET.triangles
V, T = len(POSITION), len(TRIANGLES)
some_vertices = st.sets(st.integers(0, V - 1), min_size=1, max_size=12).map(sorted)
some_triangles = st.sets(st.integers(0, T - 1), min_size=1, max_size=12).map(sorted)
corner = st.integers(0, 2)


def refusal(position=POSITION, triangles=TRIANGLES, **more) -> str:
    """What ``from_triangles`` has against a mesh."""
    with pytest.raises(MeshError) as refused:
        ClothMesh.from_triangles(position, triangles, **more)
    return str(refused.value)


def assert_names(message: str, what: str, elements) -> None:
    """``message`` says ``what``, names the first eight of ``elements``, says how many more there are, and a remedy."""
    shown = ", ".join(map(str, elements[:8])) + (f" and {len(elements) - 8} more" if len(elements) > 8 else "")
    assert re.search(rf"{what}.*: {shown}; \w", message), message


@given(some_vertices, st.integers(0, 2), st.sampled_from([np.nan, np.inf, -np.inf, 1.1e6, -1e300]))
def test_vertices_without_a_place(vertices, axis, value):
    position = POSITION.copy()
    position[vertices, axis] = value
    assert_names(refusal(position), "vertices not finite or beyond", vertices)


@given(some_triangles, corner, st.sampled_from([-1, V, 2**40, -(2**40)]))
def test_triangles_of_vertices_that_do_not_exist(triangles, at, vertex):
    bad = TRIANGLES.astype(np.int64)
    bad[triangles, at] = vertex
    assert_names(refusal(triangles=bad), rf"triangles that name vertices outside 0 \.\. {V - 1}", triangles)


@given(some_triangles, corner)
def test_triangles_that_name_a_vertex_twice(triangles, at):
    bad = TRIANGLES.copy()
    bad[triangles, at] = bad[triangles, at - 1]
    assert_names(refusal(triangles=bad), "triangles that name the same vertex twice", triangles)


@given(some_triangles, st.permutations(range(3)), st.randoms(use_true_random=False))
def test_triangles_that_come_again(chosen, order, random):
    """In whatever order of the vertices, and wherever it stands: the later one is named."""
    bad = [*map(tuple, TRIANGLES.tolist())]
    for t in chosen:
        bad.insert(random.randint(0, len(bad)), tuple(int(TRIANGLES[t, k]) for k in order))
    seen: set[frozenset[int]] = set()
    later = [n for n, t in enumerate(bad) if frozenset(t) in seen or seen.add(frozenset(t))]
    assert_names(refusal(triangles=bad), "triangles that repeat an earlier one", later)


@given(some_triangles, st.floats(0.0, 0.99e-6), corner, st.floats(0.01, 0.99))
def test_triangles_without_a_shape(places, height, longest, along):
    """Each stands alone beside the sheet: its longest edge of 1 m is as high as told."""
    sliver = np.array([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [along, height, 3.0]])
    extra = np.concatenate([sliver + np.array([0.0, 0.0, n]) for n in range(len(places))])
    new = V + np.arange(len(extra)).reshape(-1, 3)
    bad = np.insert(TRIANGLES, np.array(places) - np.arange(len(places)), np.roll(new, longest, axis=1), axis=0)
    assert_names(refusal(np.concatenate([POSITION, extra]), bad), "triangles without area", places)


def test_a_flat_triangle_that_still_has_a_shape_is_taken():
    mesh = ClothMesh.from_triangles([[0, 0, 0], [1, 0, 0], [0.4, 1.1e-6, 0]], [[0, 1, 2]])
    assert np.isfinite(mesh.spring_weight).all()


def test_nothing_is_smaller_than_an_atom():
    with pytest.raises(MeshError, match=r"triangles without area.*: 0;"):
        ClothMesh.from_triangles(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]) * 1e-11, [[0, 1, 2]])


@given(some_vertices)
def test_vertices_without_a_triangle(places):
    places = np.array(places)
    position = np.insert(POSITION, places - np.arange(len(places)), [5.0, 5.0, 5.0], axis=0)
    moved = np.setdiff1d(np.arange(len(position)), places)
    assert_names(refusal(position, moved[TRIANGLES]), "vertices that belong to no triangle", places)


def edge_table(triangles) -> dict[tuple[int, int], list[int]]:
    """Triangles at every edge, the slow way."""
    table: dict[tuple[int, int], list[int]] = {}
    for t, (a, b, c) in enumerate(triangles):
        for i, j in ((a, b), (b, c), (c, a)):
            table.setdefault((int(min(i, j)), int(max(i, j))), []).append(t)
    return table


INNER = sorted(edge for edge, around in edge_table(TRIANGLES).items() if len(around) == 2)


@given(st.sets(st.sampled_from(INNER), min_size=1, max_size=12).map(sorted), st.integers(0, T))
def test_edges_of_more_than_two_triangles(edges, place):
    tips = V + np.arange(len(edges))
    position = np.concatenate([POSITION, POSITION[[i for i, _ in edges]] + [0.0, 0.0, 0.3]])
    bad = np.insert(TRIANGLES, place, [[i, j, tip] for (i, j), tip in zip(edges, tips, strict=True)], axis=0)
    message = refusal(position, bad)
    assert_names(message, "edges of more than two triangles", [f"{i}-{j}" for i, j in edges])
    around = sorted({t for here in edge_table(bad).values() if len(here) > 2 for t in here})
    assert ", ".join(map(str, around[:8])) in message
    assert faults.crowded(bad)[1].tolist() == around


@given(some_triangles)
def test_triangles_wound_the_wrong_way(triangles):
    """Those that are fewer are named: at most 12 of the sheet's triangles are planted."""
    bad = TRIANGLES.copy()
    bad[triangles] = bad[triangles][:, ::-1]
    assert_names(refusal(triangles=bad), "triangles wound against their neighbours", triangles)


def test_of_two_halves_that_face_apart_the_one_that_comes_later_is_wound_wrong():
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
    for halves in ([[0, 1, 2], [1, 2, 3]], [[1, 2, 3], [0, 1, 2]]):
        assert_names(refusal(square, halves), "triangles wound against their neighbours", [1])


def test_pieces_may_face_either_way():
    two = np.concatenate([TRIANGLES, TRIANGLES[:, ::-1] + V])
    mesh = ClothMesh.from_triangles(np.concatenate([POSITION, POSITION + np.array([0, 0, 1])]), two)
    assert mesh.component.max() == 1
    assert faults.turned(two)[0].size == 0


def test_a_moebius_strip_has_no_sides():
    turn, across = np.arange(20) / 20 * 2 * np.pi, np.array([-0.2, 0.2])[:, None]
    radius = 1 + across * np.cos(turn / 2)
    strip = np.stack([radius * np.cos(turn), radius * np.sin(turn), across * np.sin(turn / 2)], -1).reshape(-1, 3)
    low, high = np.arange(20), 20 + np.arange(20)
    next_low, next_high = np.append(low[1:], high[0]), np.append(high[1:], low[0])
    triangles = np.concatenate([np.stack([low, next_low, high], 1), np.stack([next_low, next_high, high], 1)])
    assert_names(refusal(strip, triangles), "triangles of a surface with one side only", list(range(40)))


@given(some_vertices, st.sampled_from([np.nan, np.inf]))
def test_texture_coordinates_that_are_not_finite(vertices, value):
    uv = POSITION[:, :2].copy()
    uv[vertices, 1] = value
    assert_names(refusal(uv=uv), "vertices whose uv is not finite", vertices)


@given(st.lists(st.sampled_from([-1, V, 10**6]), min_size=1, max_size=12), st.randoms(use_true_random=False))
def test_members_of_a_group_that_do_not_exist(wrong, random):
    members = list(range(10))
    places = sorted(random.sample(range(10 + len(wrong)), len(wrong)))
    for place, vertex in zip(places, wrong, strict=True):
        members.insert(place, vertex)
    assert_names(refusal(groups={"hem": members}), "members of the group 'hem' outside", wrong)


@given(st.sets(st.integers(0, 29), min_size=1, max_size=12).map(sorted), st.booleans())
def test_springs_that_come_again(repeats, reversed_):
    springs = [[n, n + 1] for n in range(30)]
    again = [springs[n][::-1] if reversed_ else springs[n] for n in repeats]
    with pytest.raises(MeshError) as refused:
        ClothMesh.from_springs(np.eye(31, 3) + np.arange(31)[:, None], springs + again, stiffness=1.0, mass=1.0)
    assert_names(str(refused.value), "springs that repeat an earlier one", list(range(30, 30 + len(again))))


LINE = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float)
LINKS = [[0, 1], [1, 2]]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: ClothMesh.from_triangles([[0, 0, 0], [1, 0]], [[0, 1, 2]]), "positions must be rows of 3 numbers"),
        (lambda: ClothMesh.from_triangles(POSITION[:, :2], TRIANGLES), r"3 numbers \(m\), not .* \(\d+, 2\)"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES + 0.5), "triangles must be vertex numbers: whole"),
        (lambda: ClothMesh.from_triangles(POSITION, [[0, 1, np.nan]]), "triangles must be vertex numbers: whole"),
        (lambda: ClothMesh.from_triangles(POSITION, [["a", "b", "c"]]), "triangles must be vertex numbers: whole"),
        (lambda: ClothMesh.from_triangles(POSITION, [[0, 1, 2], [3, 4]]), "triangles must be vertex numbers: whole"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES.reshape(-1, 6)), r"rows of 3 .* shape \(\d+, 6\)"),
        (lambda: ClothMesh.from_triangles(POSITION, []), "no triangles; chains and nets"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES, uv=POSITION), "uv must be rows of 2 numbers"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES, uv=POSITION[1:, :2]), rf"each of the {V} vertices"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES, warp=(0, 0, 0)), r"warp \(0, 0, 0\) is not a direction"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES, warp=(0, np.nan, 1)), "is not a direction"),
        (lambda: ClothMesh.from_triangles(POSITION, TRIANGLES, groups={"hem": [0.5]}), "members of the group 'hem'"),
        (lambda: ClothMesh.grid(width=1, height=1, columns=2.5, rows=3), "columns: 2.5 is not a whole number"),
        (lambda: ClothMesh.grid(width=1000, height=0.001, columns=2, rows=9), "cells of the grid are 1000 x 0.000125"),
        (
            lambda: ClothMesh.from_springs(LINE, LINKS, stiffness=[1, 2, 3], mass=1),
            r"stiffness .* or 2 numbers, not \[1,",
        ),
        (lambda: ClothMesh.from_springs(LINE, LINKS, stiffness="x", mass=1), r"stiffness \(N/m\) must be .*, not 'x'"),
        (
            lambda: ClothMesh.from_springs(LINE, LINKS, stiffness=1, mass=1, rest_length=[1, 0]),
            "shorter than 1e-10 m: 1;",
        ),
        (lambda: ClothMesh.from_springs(LINE * 0, LINKS, stiffness=1, mass=1), "shorter than 1e-10 m: 0, 1;"),
        (lambda: ClothMesh.from_springs(LINE, LINKS, stiffness=1, mass=1, triangles=[[0, 1, 2]]), "without area.*: 0;"),
    ],
)
def test_arrays_that_cannot_be_meant(build, message):
    with pytest.raises(MeshError, match=message):
        build()


def test_springs_without_length_need_no_limit():
    mesh = ClothMesh.from_springs(LINE * 0, LINKS, stiffness=1, mass=1, limited=False)
    assert mesh.spring_rest.tolist() == [0.0, 0.0]


def test_nets_may_have_edges_of_three_triangles():
    flaps = [[0, 1, 2], [0, 1, 3], [0, 1, 4]]
    x = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0], [0, 0, 1]], float)
    assert len(ClothMesh.from_springs(x, [[0, 1]], stiffness=1, mass=1, triangles=flaps).triangles) == 3


def test_a_mesh_put_together_by_hand_is_looked_at_too():
    weight = SHEET.spring_weight.copy()
    weight[[3, 8]] = np.nan
    with pytest.raises(MeshError, match="spring_weight not finite at: 3, 8;"):
        dataclasses.replace(SHEET, spring_weight=weight)


def test_a_mass_that_the_stiffness_drowns_is_refused_before_the_matrix_fails():
    fine = ClothMesh.grid(width=1e-3, height=1e-3, columns=20, rows=20)
    stiff = Material(areal_density=1e-3, bend=3.0)
    with pytest.raises(MeshError, match=r"vertices too light.*: 0, 1, 2, .* and 392 more; choose softer"):
        check_stiffness(fine, stiff, SolverConfig().dt / 8)
    solver = ClothSolver(fine, Material.preset("denim"))
    check_stiffness(fine, solver.material, solver.config.dt / solver.substeps)
