"""Reach: between the straight line and the way along the threads, and no farther than the cloth can be pulled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose
from cloth_core.meshing.flatness import flat_and_convex
from cloth_core.physics.reach import PINS, Reach, Tethers
from cloth_core.physics.ways import DETOUR, Ways
from cloth_core.validation.geometry import irregular_sheet

LIMIT = 1.1


def reached(mesh, first, second):
    """(N, M) m at rest, between the rims of a grasp and of the pins; infinite where nothing joins them."""
    tethers = Reach(mesh, LIMIT).tethers({"hand": np.sort(first), PINS: np.sort(second)})
    if not len(tethers):
        return None
    (tether,) = tethers
    assert (tether.straight <= tether.longest).all()
    assert (tether.first, tether.second) == ("hand", PINS)
    return tether.first_rim, tether.second_rim, tether.longest / LIMIT


def along_springs(mesh, first, second):
    i, j = mesh.spring_vertex.T
    ways = coo_matrix((mesh.spring_rest, (i, j)), shape=(mesh.vertex_count,) * 2)
    return dijkstra(ways, directed=False, indices=first)[:, second]


FLAT = [ClothMesh.grid(width=1.0, height=height, columns=12, rows=9) for height in (0.7, 0.2)]


@pytest.mark.parametrize("mesh", [*FLAT, irregular_sheet(1, 1, 9)], ids=["square", "long cells", "irregular"])
def test_a_flat_sheet_reaches_the_straight_line(mesh):
    random = np.random.default_rng(1)
    for _ in range(10):
        first, second = np.split(random.choice(mesh.vertex_count, 9, replace=False), [4])
        a, b, reach = reached(mesh, first, second)
        straight = np.linalg.norm(mesh.rest_position[a][:, None] - mesh.rest_position[b][None], axis=2)
        np.testing.assert_allclose(reach, straight, rtol=1e-12)


def tube(around=24, rows=10, radius=0.2):
    angle = np.arange(around) * 2.0 * np.pi / around
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    place = np.concatenate([np.column_stack([ring, np.full(around, 0.05 * row)]) for row in range(rows)])
    triangles = []
    for row in range(rows - 1):
        for n in range(around):
            a, b = row * around + n, row * around + (n + 1) % around
            triangles += [(a, b, b + around), (a, b + around, a + around)]
    return ClothMesh.from_triangles(place, np.array(triangles), warp=(0.0, 0.0, 1.0)), around


def test_a_tube_reaches_along_its_surface():
    mesh, around = tube()
    row = 5 * around
    half_way = around // 2 * 2 * 0.2 * np.sin(np.pi / around)  # along the ring's edges
    _, _, reach = reached(mesh, np.array([row]), np.array([row + around // 2]))
    assert 0.9 * half_way < reach[0, 0] <= half_way * (1 + 1e-12)
    assert reach[0, 0] > 1.3 * 0.4  # the straight line goes through the hole
    _, _, across = reached(mesh, np.array([0]), np.array([9 * around + around // 2]))
    geodesic = np.hypot(half_way, 9 * 0.05)
    assert 0.9 * geodesic < across[0, 0] <= geodesic * (1 + 1e-12)


def rope(place, **options):
    links = np.stack([np.arange(len(place) - 1), np.arange(1, len(place))], axis=1)
    return ClothMesh.from_springs(place, links, stiffness=100.0, mass=0.01, **options)


def coil(count=60):
    angle = np.linspace(0.0, 6.0 * np.pi, count)
    return np.column_stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), 0.02 * angle])


@pytest.mark.parametrize("options", [{}, {"rest_length": np.full(59, 0.01)}, {"rest_length": np.full(59, 0.2)}])
def test_a_coiled_rope_reaches_its_whole_length(options):
    mesh = rope(coil(), **options)
    first, second = np.array([3, 4, 5, 6]), np.array([40, 41])
    a, b, reach = reached(mesh, first, second)
    assert a.tolist() == [3, 6] and b.tolist() == [40, 41]  # what lies inside a hand pulls at nothing
    np.testing.assert_allclose(reach, along_springs(mesh, a, b), rtol=1e-12)


def test_what_nothing_joins_or_only_what_has_no_limit_reaches_anywhere():
    two = rope(coil(), limited=np.arange(59) != 30)
    assert reached(two, np.array([3]), np.array([40])) is None
    assert reached(two, np.array([3]), np.array([20])) is not None


def test_the_reach_follows_from_what_is_held_alone():
    mesh, around = tube()
    held = {"a": np.array([0, 1, around]), "b": np.array([100, 101]), PINS: np.array([200, 201])}
    often = Reach(mesh, LIMIT)
    for some in ({"a": held["a"]}, {"a": held["b"], PINS: held["a"]}, held):
        tethers = often.tethers(some)
    again = Reach(mesh, LIMIT).tethers(dict(reversed(held.items())))
    assert [(t.first, t.second) for t in tethers] == [("a", PINS), ("b", PINS), ("b", "a")]
    for one, other in zip(tethers, again, strict=True):
        assert (one.first, one.second) == (other.first, other.second)
        assert (one.longest == other.longest).all()


def landmark_reach(mesh, first, second, marks):
    """The reach at rest with full searches by scipy from ``marks``, (side, vertex), between two rims."""
    hinge, rest, place = mesh.hinge_vertex, mesh.spring_rest, mesh.rest_position
    links = {}
    for (i, j), length in zip(mesh.spring_vertex, rest, strict=True):
        links[min(i, j), max(i, j)] = length
    for a, b, c, d in hinge:
        axis = (place[b] - place[a]) / np.linalg.norm(place[b] - place[a])
        heights = [np.linalg.norm(np.cross(axis, place[v] - place[a])) for v in (c, d)]
        across = np.hypot((place[d] - place[c]) @ axis, sum(heights))
        links[min(c, d), max(c, d)] = min(across, links.get((min(c, d), max(c, d)), np.inf))
    i, j = np.array(list(links)).T
    ways = coo_matrix((list(links.values()), (i, j)), shape=(len(place),) * 2)
    reach = np.linalg.norm(place[first][:, None] - place[second][None], axis=2)
    for side, mark in marks:
        way = dijkstra(ways, directed=False, indices=mark)
        there, back = (second, first) if side == 0 else (first, second)
        beyond = way[there][None] / DETOUR - way[back][:, None]
        reach = np.maximum(reach, beyond if side == 0 else beyond.T)
    return reach


def extremes(place, rim):
    one = np.argmax(np.linalg.norm(place[rim] - place[rim].mean(axis=0), axis=1))
    return rim[one], rim[np.argmax(np.linalg.norm(place[rim] - place[rim[one]], axis=1))]


@pytest.mark.parametrize("seed", range(4))
def test_a_search_that_stops_early_finds_what_full_searches_find(seed):
    mesh = tube()[0]
    random = np.random.default_rng(seed)
    held = {name: np.unique(random.choice(mesh.vertex_count, 5)) for name in ("one", "two")}
    held[PINS] = np.setdiff1d(random.choice(mesh.vertex_count, 3), np.concatenate(list(held.values())))
    held["two"] = np.setdiff1d(held["two"], held["one"])
    for tether in Reach(mesh, LIMIT).tethers(held):
        rims, marks = (tether.first_rim, tether.second_rim), []
        for side, name in enumerate((tether.first, tether.second)):
            if name != PINS:
                marks += [(side, mark) for mark in extremes(mesh.rest_position, rims[side])]
        expected = LIMIT * landmark_reach(mesh, *rims, marks)
        np.testing.assert_allclose(tether.longest, expected, rtol=1e-12)
        assert (tether.longest > tether.straight).any()


@pytest.mark.parametrize("mesh", [tube()[0], irregular_sheet(1, 0.6, 11, seed=2)], ids=["tube", "irregular"])
def test_ways_are_those_of_scipy_to_the_last_bit_as_far_as_they_are_wanted(mesh):
    ways, random = Ways(mesh), np.random.default_rng(6)
    graph = ways._lengths(True)
    ways._graph = graph
    stopped = 0
    for _ in range(20):
        begin, wanted = random.integers(mesh.vertex_count), random.choice(mesh.vertex_count, 3)
        way, expected = ways.of(begin, wanted), dijkstra(graph, indices=begin)
        sure = expected <= expected[wanted].max()
        np.testing.assert_array_equal(way[sure], expected[sure])
        assert np.isinf(way[~sure]).all()
        stopped += not sure.all()
    assert stopped > 10


def moved(mesh, place):
    fields = {name: getattr(mesh, name) for name in mesh.__dataclass_fields__}
    return ClothMesh(**{**fields, "rest_position": place})


def two_sheets():
    one = ClothMesh.grid(width=1.0, height=1.0, columns=5, rows=4)
    notched = np.delete(one.triangles, [0], axis=0)
    place = np.concatenate([one.rest_position, one.rest_position + np.array([3.0, 0.0, 0.0])])
    return ClothMesh.from_triangles(place, np.concatenate([notched, one.triangles + one.vertex_count]))


def flat_ones(mesh):
    return flat_and_convex(mesh.rest_position, mesh.triangles, mesh.component)


@pytest.mark.parametrize("mesh", [*FLAT, irregular_sheet(1, 1, 9)], ids=["square", "long cells", "irregular"])
def test_a_convex_sheet_is_known_wherever_it_lies_and_however_it_is_turned(mesh):
    turn = Pose((300.0, -20.0, 5.0), (0.3, -0.5, 0.2, 0.7))
    assert flat_ones(mesh).all() and flat_ones(moved(mesh, turn.apply(mesh.rest_position))).all()


def test_a_bump_a_fold_a_notch_and_a_hole_are_no_convex_sheet():
    mesh, middle = FLAT[0], 50
    bump = mesh.rest_position.copy()
    bump[middle, 2] += 1e-6
    dent = mesh.rest_position.copy()
    dent[1, 1] += 1e-6 * np.sign(dent[middle, 1] - dent[1, 1])
    fold = mesh.rest_position.copy()
    fold[:, 0] = np.abs(fold[:, 0] + 0.03)
    for place in (bump, dent, fold):
        assert not flat_ones(moved(mesh, place)).any()
    holed = ClothMesh.from_triangles(mesh.rest_position, np.delete(mesh.triangles, [80], axis=0))
    assert not flat_ones(holed).any() and not flat_ones(tube()[0]).any()


def test_of_two_sheets_each_is_judged_for_itself():
    mesh = two_sheets()
    np.testing.assert_array_equal(flat_ones(mesh), np.arange(mesh.vertex_count) >= mesh.vertex_count // 2)


@pytest.mark.parametrize("shape", ["tube", "sheet"])
def test_asking_straight_lines_first_changes_no_bit(shape, monkeypatch):
    """Two hands go round each other and pull, beyond the straight line and beyond the way round."""
    mesh = tube(16, 8)[0] if shape == "tube" else FLAT[0]
    ends = mesh.rest_position[[0, mesh.vertex_count - 3]]

    def played():
        solver = ClothSolver(mesh, Material())
        solver.pin([5])
        state, said = solver.initial_state(), []
        for n in range(25):
            way = 0.02 * n * (ends[0] - ends[1]) / np.linalg.norm(ends[0] - ends[1])
            hands = {"a": ends[0] + way, "b": ends[1] - 0.3 * way}
            grasps = {
                name: Grasp(pose=Pose(tuple(place)), closure=1.0, radius=0.06, slip_distance=0.05)
                for name, place in hands.items()
            }
            state = solver.step(state, Inputs(grasps=grasps))
            said.append((state.digest, solver.report.taut, solver.report.slipped))
        return said

    quick = played()
    monkeypatch.setattr(Tethers, "slack", lambda *_: False)
    assert played() == quick
    assert any(taut for _, taut, _ in quick) and any(slipped for _, _, slipped in quick)
