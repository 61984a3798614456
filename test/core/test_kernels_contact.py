"""Distances, push-out, friction and impact against their slow twins."""

from __future__ import annotations

import numpy as np
import pytest
import twins
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from cloth_core.kernels import approach, bodies, contact, impulses, nearest, shapes

SEEDS = st.integers(0, 10**6)
SHAPES = range(5)


def capsule_point(size: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Where the ray from the centre along ``d`` leaves the capsule: through its side, or through an end."""
    radius, half = size[:2]
    across = np.hypot(d[0], d[1])
    if radius * abs(d[2]) < half * across:
        return radius / across * d
    return (half * abs(d[2]) + np.sqrt((half * d[2]) ** 2 - half**2 + radius**2)) * d


# A point of the surface for each direction.
POINTS = {
    shapes.SPHERE: lambda s, d: s[0] * d,
    shapes.BOX: lambda s, d: s * d / np.abs(d).max(),
    shapes.CAPSULE: capsule_point,
    shapes.ELLIPSOID: lambda s, d: s * d,
}


def random_size(random: np.random.Generator, kind: int) -> np.ndarray:
    return np.zeros(3) if kind == shapes.PLANE else random.uniform(0.2, 1.5, 3)


@given(SEEDS, st.sampled_from(SHAPES))
def test_distance_is_that_of_the_twin(seed, kind):
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance = shapes.signed_distance(kind, size, *point)[0]
    assert distance == pytest.approx(twins.DISTANCE[kind](size, point), abs=1e-9)


@given(SEEDS, st.sampled_from([shapes.SPHERE, shapes.BOX, shapes.CAPSULE, shapes.ELLIPSOID]))
def test_no_point_of_the_surface_is_nearer_than_the_distance(seed, kind):
    """Points of the surface by direction, the nearest refined by scipy: the formula under test is not used."""
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance = shapes.signed_distance(kind, size, *point)[0]

    def gap(angles):
        u, v = angles
        direction = np.array([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)])
        return float(np.linalg.norm(POINTS[kind](size, direction) - point))

    grid = [(u, v) for u in np.linspace(-3.1, 3.1, 40) for v in np.linspace(-1.5, 1.5, 21)]
    starts = sorted(grid, key=gap)[:6]
    nearest = min(
        minimize(gap, start, method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-9}).fun for start in starts
    )
    assert nearest >= abs(distance) - 1e-9
    assert nearest == pytest.approx(abs(distance), abs=0.01)


@given(SEEDS, st.sampled_from(SHAPES))
def test_normal_is_the_gradient_and_leads_to_the_surface(seed, kind):
    random = np.random.default_rng(seed)
    size, point = random_size(random, kind), random.normal(0, 1.0, 3)
    distance, *normal = shapes.signed_distance(kind, size, *point)
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-9)
    assert shapes.signed_distance(kind, size, *(point - distance * np.array(normal)))[0] == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("kind", SHAPES)
def test_distance_and_normal_are_finite_at_the_centre_on_axes_and_on_the_surface(kind):
    size = np.array([0.5, 0.5, 0.5]) if kind == shapes.ELLIPSOID else np.array([0.5, 0.4, 0.3])
    for sizes in (size, np.array([0.5, 0.2, 0.2]), np.array([0.3, 0.5, 0.1])):
        for point in np.concatenate(
            [np.zeros((1, 3)), 0.1 * np.eye(3), np.diag(sizes), 3 * np.eye(3), -np.diag(sizes)]
        ):
            distance, *normal = shapes.signed_distance(kind, sizes, *point)
            assert np.isfinite(distance)
            assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("radii", [(1.0, 1.0, 1.0), (1.0, 0.5, 0.5), (0.3, 0.3, 0.9), (0.2, 0.4, 0.8)])
def test_ellipsoid_on_its_axes(radii):
    """Outside on an axis the vertex is nearest; at the centre, the end of the shortest axis."""
    for axis in range(3):
        point = np.zeros(3)
        point[axis] = 2.0
        assert shapes.ellipsoid_distance(*point, *radii)[0] == pytest.approx(2.0 - radii[axis], abs=1e-7)
    assert shapes.ellipsoid_distance(0.0, 0.0, 0.0, *radii)[0] == pytest.approx(-min(radii), abs=1e-7)


@given(SEEDS)
def test_into_frame_is_the_inverse_pose(seed):
    random = np.random.default_rng(seed)
    rotation, origin, point = Rotation.random(rng=random).as_matrix(), *random.normal(size=(2, 3))
    np.testing.assert_allclose(bodies.into_frame(rotation, origin, *point), rotation.T @ (point - origin), atol=1e-13)


def crowd(seed: int):
    """40 vertices around five obstacles in random poses."""
    random = np.random.default_rng(seed)
    kind = np.arange(5)
    size = np.array([random_size(random, k) for k in kind])
    reach = np.array([1e9, size[1, 0], np.linalg.norm(size[2]), size[3, 0] + size[3, 1], size[4].max()])
    return (
        random,
        random.normal(0, 1, (40, 3)),
        kind,
        size,
        reach,
        Rotation.random(5, rng=random).as_matrix(),
        random.normal(0, 0.5, (5, 3)),
    )


def placed(random: np.random.Generator, kind, size, reach, rotation, origin, **given: np.ndarray) -> bodies.Bodies:
    """Obstacles that stand still unless ``given`` something else."""
    count = len(kind)
    still = {
        "friction": np.zeros(count),
        "rotation_before": rotation,
        "origin_before": origin,
        "turn": np.zeros((count, 3)),
        "travel": np.zeros(count),
    }
    return bodies.Bodies(
        **{"kind": kind, "size": size, "reach": reach, "rotation": rotation, "origin": origin, **still, **given}
    )


def points_on(random: np.random.Generator, vertices: int, count: int, body: np.ndarray, yielding: np.ndarray):
    """Vertices, points of edges and points of triangles, in turn."""
    corners = (np.arange(count) % 3 + 1).astype(np.int8)
    corner = np.array([random.permutation(vertices)[:3] for _ in range(count)], dtype=np.uint32)
    weight = random.uniform(0.1, 1.0, (count, 3)) * (np.arange(3) < corners[:, None])
    weight /= weight.sum(axis=1, keepdims=True)
    yields = (weight**2 * yielding[corner]).sum(axis=1)
    room = {
        "depth": np.zeros(count),
        "plane": np.zeros((count, 4)),
        "left": np.full((count, 3), np.nan),
        "pushed": np.zeros(count),
        "spent": np.zeros(count),
        "normal": np.zeros((count, 3)),
        "shift": np.zeros((count, 3)),
        "gap": np.zeros(count),
    }
    return contact.Points(corners=corners, corner=corner, weight=weight, yields=yields, body=body, **room)


def whereabouts(x: np.ndarray, points: contact.Points) -> np.ndarray:
    return np.einsum("pn,pna->pa", points.weight, x[points.corner])


def moved(x: np.ndarray, points: contact.Points, p: int, yielding: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Slow twin: the corners of point p by as little as takes it along ``way``, weighed by mass; a vertex as it is."""
    x = x.copy()
    if points.corners[p] == 1:
        x[points.corner[p, 0]] += way
        return x
    for v, w in zip(points.corner[p], points.weight[p], strict=True):
        x[v] += w * yielding[v] / points.yields[p] * way
    return x


@pytest.mark.parametrize("seed", range(8))
def test_found_vertices_are_all_that_may_touch(seed):
    random, x, kind, size, reach, rotation, origin = crowd(seed)
    shell, recover, travel = 0.05, 0.004, random.uniform(0, 0.02, 5)
    predicted, free = x + random.normal(0, 0.01, x.shape), random.random(40) < 0.8
    found = placed(random, kind, size, reach, rotation, origin, travel=travel)
    room = points_on(random, 40, 200, np.zeros(200, np.int32), np.ones(40))
    room.left[:] = 0.0
    scratch = np.zeros(40), np.zeros(40), np.zeros((40, 3))
    no_edge, no_triangle, blunt = np.zeros((0, 2), np.uint32), np.zeros((0, 3), np.uint32), np.zeros(5, np.bool_)
    count = approach.find_points(
        x, predicted, no_edge, no_triangle, 0.1, free, 1.0 * free, found, blunt, blunt, np.full(5, shell),
        np.zeros(2), shell, recover, room, *scratch,
    )  # fmt: skip
    expected = {}
    for v in np.flatnonzero(free):
        way = np.linalg.norm(predicted[v] - x[v])
        for o in range(5):
            distance = twins.DISTANCE[kind[o]](size[o], rotation[o].T @ (x[v] - origin[o]))
            if distance < 2 * shell + way + travel[o]:
                expected[v, o] = max(0.0, shell - distance - recover)
    listed = list(zip(room.corner[:count, 0].tolist(), room.body[:count].tolist(), strict=True))
    assert set(listed) == set(expected)
    assert count == len(expected)
    np.testing.assert_allclose(room.depth[:count], [expected[pair] for pair in listed], atol=1e-8)
    np.testing.assert_array_equal(np.isnan(room.left).any(axis=1), np.arange(200) < count)


def test_what_there_is_no_room_for_is_counted():
    random, x, kind, size, reach, rotation, origin = crowd(1)
    found = placed(random, kind, size, reach, rotation, origin)
    counts = []
    for room in (3, 200):
        points = points_on(random, 40, room, np.zeros(room, np.int32), np.ones(40))
        scratch = np.zeros(40), np.zeros(40), np.zeros((40, 3))
        nothing = np.zeros((0, 2), np.uint32), np.zeros((0, 3), np.uint32)
        blunt, free = np.zeros(5, np.bool_), np.ones(40, np.bool_)
        count = approach.find_points(
            x, x, *nothing, 0.1, free, np.ones(40), found, blunt, blunt, np.full(5, 0.05), np.zeros(2), 0.05,
            0.0, points, *scratch,
        )  # fmt: skip
        counts.append(count)
    assert counts[0] == counts[1] > 3


@given(SEEDS, st.sampled_from([shapes.SPHERE, shapes.BOX, shapes.CAPSULE, shapes.ELLIPSOID]))
def test_the_nearest_point_of_an_edge_and_of_a_triangle_is_that_of_a_fine_grid(seed, kind):
    random = np.random.default_rng(seed)
    size, corner, weight = random_size(random, kind), random.normal(0, 2.0, (3, 3)), np.zeros(3)
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)))
    inside = u + v <= 1.0 + 1e-12
    samples = {
        2: np.column_stack([1 - u, u, 0 * u]),
        3: np.column_stack([1 - u - v, u, v])[inside],
    }
    extent = np.linalg.norm(corner - corner.mean(axis=0), axis=1).max()
    for corners, shares in samples.items():
        distance = nearest.nearest(kind, size, corner, corners, weight)[0]
        least = min(shapes.signed_distance(kind, size, *point)[0] for point in shares @ corner)
        assert weight[:corners].sum() == pytest.approx(1.0)
        assert (weight[:corners] >= 0.0).all()
        assert distance == pytest.approx(shapes.signed_distance(kind, size, *(weight[:corners] @ corner[:corners]))[0])
        # Each of the two searches stops within 2^-8 of a line.
        assert least - 0.05 * extent < distance < least + 2.0**-7 * 2.0 * extent


@given(SEEDS)
def test_what_passes_a_plate_within_a_step_is_stopped_where_it_first_touches(seed):
    """A vertex, an edge and a triangle that fly through a thin box along its short axis."""
    random = np.random.default_rng(seed)
    thickness, shell, height = random.uniform(1e-3, 1e-2), random.uniform(1e-3, 5e-3), random.uniform(0.03, 0.2)
    size = np.array([1.0, 1.0, 0.5 * thickness])
    for corners in (1, 2, 3):
        begin = np.column_stack([random.uniform(-0.3, 0.3, (3, 2)), height + random.uniform(0, 0.02, 3)])
        end, weight = begin - [0.0, 0.0, 1.0], np.zeros(3)
        stopped, distance, *normal = approach.first_touch(shapes.BOX, size, begin, end, corners, shell, weight)
        assert stopped
        np.testing.assert_allclose(normal, [0.0, 0.0, 1.0], atol=1e-12)
        assert distance == pytest.approx(shell, rel=0.3)
        assert begin[:corners, 2].min() == pytest.approx(
            0.5 * thickness + distance, abs=2.0**-7 * 0.1
        )  # two searches by halves
        begin[:, 2] = -height  # from below the plate, and away
        stopped, *_ = approach.first_touch(shapes.BOX, size, begin, begin - [0.0, 0.0, 1.0], corners, shell, weight)
        assert not stopped


@pytest.mark.parametrize("seed", range(8))
def test_push_out_moves_along_the_normal_to_the_allowed_depth(seed):
    """Points one by one, in their order, each from where the last one left the vertices; one is where it was left."""
    random, x, kind, size, reach, rotation, origin = crowd(seed)
    found = placed(random, kind, size, reach, rotation, origin)
    yielding = random.uniform(0.0, 2.0, 40) * (random.random(40) < 0.9)
    points = points_on(random, 40, 60, random.integers(0, 5, 60).astype(np.int32), yielding)
    points.depth[:] = random.uniform(0, 0.02, 60)
    points.pushed[:] = 0.5
    rooted = points.yields < 1e-3
    points.left[rooted] = whereabouts(x, points)[rooted]
    expected, ways = x.copy(), np.zeros(60)
    for p in np.flatnonzero(~rooted):
        o, here = points.body[p], whereabouts(expected, points)[p]
        distance = bodies.distance_in_world(kind[o], size[o], rotation[o], origin[o], *here)
        assert distance[0] == pytest.approx(
            twins.DISTANCE[kind[o]](size[o], rotation[o].T @ (here - origin[o])), abs=1e-7
        )
        ways[p] = max(0.0, 0.01 - points.depth[p] - distance[0])
        expected = moved(expected, points, p, yielding, ways[p] * np.array(distance[1:]))
    most = contact.push_out(x, found, points, 60, yielding, 0.01)
    np.testing.assert_allclose(x, expected, atol=1e-8)
    np.testing.assert_allclose(points.pushed - 0.5, ways, atol=1e-8)
    assert most == pytest.approx(ways.max(), abs=1e-8)
    assert 5 < np.count_nonzero(ways) < 60


def test_a_plane_that_was_touched_first_counts_whatever_is_behind_it():
    random = np.random.default_rng(4)
    rotation, origin = Rotation.random(1, rng=random).as_matrix(), random.normal(size=(1, 3))
    found = placed(random, np.array([shapes.SPHERE]), np.full((1, 3), 0.1), np.array([0.1]), rotation, origin)
    points = contact.Points(
        corners=np.ones(1, np.int8), corner=np.zeros((1, 3), np.uint32), weight=np.ones((1, 3)), yields=np.ones(1),
        body=np.zeros(1, np.int32), depth=np.zeros(1), plane=np.array([[0.0, 0.0, 1.0, 0.1]]),
        left=np.full((1, 3), np.nan), pushed=np.zeros(1), spent=np.zeros(1), normal=np.zeros((1, 3)),
        shift=np.zeros((1, 3)), gap=np.zeros(1),
    )  # fmt: skip
    x = origin + np.array([[0.02, 0.03, -0.5]]) @ rotation[0].T  # far behind the sphere
    assert contact.push_out(x, found, points, 1, np.ones(1), 0.01) == pytest.approx(0.61)
    np.testing.assert_allclose((x - origin) @ rotation[0], [[0.02, 0.03, 0.11]], atol=1e-12)
    np.testing.assert_allclose(points.normal[0], rotation[0][:, 2], atol=1e-12)


def touching(seed: int):
    """Nine points of twelve vertices that touch two moving, turning obstacles."""
    random = np.random.default_rng(seed)
    start = random.normal(size=(12, 3))
    x = start + 0.1 * random.normal(size=(12, 3))
    origin, origin_before, turn = random.normal(size=(3, 2, 3))
    yielding = random.uniform(0.5, 2.0, 12)
    points = points_on(random, 12, 9, random.integers(0, 2, 9).astype(np.int32), yielding)
    points.normal[:] = random.normal(size=(9, 3))
    points.normal[:] /= np.linalg.norm(points.normal, axis=1, keepdims=True)
    points.pushed[:] = random.uniform(0, 0.3, 9) * (random.random(9) < 0.8)
    eye = np.tile(np.eye(3), (2, 1, 1))
    found = placed(
        random, np.ones(2, np.int64), np.ones((2, 3)), np.ones(2), eye, origin,
        origin_before=0.05 * origin_before + origin, turn=0.1 * turn, friction=random.uniform(0, 1, 2),
    )  # fmt: skip
    return random, start, x, yielding, found, points


@given(SEEDS)
def test_friction_takes_back_at_most_mu_times_the_push(seed):
    random, start, x, yielding, found, points = touching(seed)
    points.spent[:] = random.uniform(0, 0.05, 9)
    expected, used = x.copy(), points.spent.copy()
    points.left[2] = whereabouts(x, points)[2]
    for p in np.flatnonzero(points.pushed):
        o, here = points.body[p], whereabouts(expected, points)[p]
        if p == 2 and (here == points.left[2]).all():
            continue  # it is where it was left
        surface = twins.surface_way(here, found.origin[o], found.origin_before[o], found.turn[o])
        most = found.friction[o] * points.pushed[p] - used[p]
        wanted, taken = twins.friction(whereabouts(start, points)[p], here, surface, points.normal[p], most)
        expected = moved(expected, points, p, yielding, wanted - here)
        used[p] += taken
    contact.apply_friction(start, x, found, points, 9, yielding)
    np.testing.assert_allclose(x, expected, atol=1e-12)
    np.testing.assert_allclose(points.spent, used, atol=1e-12)


@given(SEEDS, st.sampled_from([0.0, 0.5, 1.0]))
def test_impact_gives_back_its_share_of_the_approach(seed, restitution):
    random, _, x, yielding, found, points = touching(seed)
    velocity, earlier = random.normal(0, 2, (2, 12, 3))
    h, rest_speed, expected = 0.02, 0.6, velocity.copy()
    for p in np.flatnonzero(points.pushed):
        o, here, normal = points.body[p], whereabouts(x, points)[p], points.normal[p]
        surface = twins.surface_way(here, found.origin[o], found.origin_before[o], found.turn[o]) @ normal / h
        now, before = whereabouts(expected, points)[p], whereabouts(earlier, points)[p]
        wanted = twins.impact(now, before, surface, normal, restitution, rest_speed)
        expected = moved(expected, points, p, yielding, wanted - now)
    contact.contact_velocity(velocity, earlier, x, h, found, points, 9, yielding, restitution, rest_speed)
    np.testing.assert_allclose(velocity, expected, atol=1e-10)


@given(SEEDS)
def test_impulses_of_contacts_are_what_they_gave_to_the_vertices(seed):
    random, start, x, yielding, found, points = touching(seed)
    points.pushed[:] = 0.0
    h, pushed, velocity = 0.02, x.copy(), random.normal(0, 2, (12, 3))
    settled = velocity.copy()
    contact.push_out(pushed, found, points, 9, yielding, 0.5)
    contact.apply_friction(start, pushed, found, points, 9, yielding)
    contact.contact_velocity(settled, velocity, pushed, h, found, points, 9, yielding, 0.5, 0.1)
    component, pressed, press = np.arange(12) % 2, np.zeros((12, 3)), np.zeros((2, 2, 19))
    impulses.add_impulses(pushed, h, found, points, 9, yielding, component, pressed, press)
    given_to = ((pushed - x) / h + settled - velocity) / yielding[:, None]
    np.testing.assert_allclose(pressed, given_to, atol=1e-8)
    np.testing.assert_allclose(press[:, :, :3].sum(axis=(0, 1)), -pressed.sum(axis=0), atol=1e-8)
    for o in range(2):
        for part in range(2):
            of = np.flatnonzero((points.body == o) & (points.pushed > 0) & (points.corner[:, 0] % 2 == part))
            arm = whereabouts(pushed, points)[of] - found.origin[o]
            force = -points.shift[of] / (
                h * np.where(points.corners == 1, yielding[points.corner[:, 0]], points.yields)[of, None]
            )
            np.testing.assert_allclose(press[o, part], twins.pressed(arm, force), atol=1e-7)


@given(SEEDS, st.integers(1, 5 * impulses.BLOCK), st.sampled_from([1, 2]))
def test_impulses_of_many_points_are_all_added_up(seed, count, parts):
    random = np.random.default_rng(seed)
    kind, size = np.full(3, shapes.SPHERE), np.full((3, 3), 0.1)
    rotation, origin = Rotation.random(3, rng=random).as_matrix(), random.normal(size=(3, 3))
    found = placed(random, kind, size, np.full(3, 0.1), rotation, origin)
    position, yielding, h = random.normal(size=(40, 3)), random.uniform(0.5, 2.0, 40), 0.01
    body = np.sort(random.integers(0, 3, count)).astype(np.int32)
    points = points_on(random, 40, count, body, yielding)
    points.pushed[:] = random.random(count) < 0.9
    points.shift[:] = random.normal(size=(count, 3))
    component, pressed, press = np.arange(40) % parts, np.zeros((40, 3)), np.zeros((3, 2, 19))
    impulses.add_impulses(position, h, found, points, count, yielding, component, pressed, press)
    inert = np.where(points.corners == 1, yielding[points.corner[:, 0]], points.yields)
    force, place = points.shift / (h * inert[:, None]), whereabouts(position, points)
    expected = np.zeros((40, 3))
    for p in np.flatnonzero(points.pushed):
        share = [1.0] if points.corners[p] == 1 else points.weight[p, : points.corners[p]]
        np.add.at(expected, points.corner[p, : points.corners[p]], np.outer(share, force[p]))
    np.testing.assert_allclose(pressed, expected, rtol=1e-9, atol=1e-9 * np.abs(force).max(initial=1.0))
    for o in range(3):
        for part in range(2):
            its = (body == o) & (points.pushed > 0) & (component[points.corner[:, 0]] == part)
            sums = twins.pressed(place[its] - origin[o], -force[its])
            np.testing.assert_allclose(press[o, part], sums, rtol=1e-9, atol=1e-9 * max(1.0, sums[6]))
