"""Behind an obstacle the air is still, beside it it is not, and everything in between is smooth."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import trimesh
import twins
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, Pose, SolverConfig, Wind
from cloth_core.fields import VoxelField, closed
from cloth_core.kernels import wakes as kernels
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Obstacle, Plane, Sphere
from cloth_core.physics.contacts import Contacts
from cloth_core.physics.wakes import Wakes
from cloth_core.validation import medium

MESH = ClothMesh.grid(width=1.0, height=1.0, columns=2, rows=2)
FINITE = (
    lambda a, **at: Sphere(radius=0.5 * a, **at),
    lambda a, **at: Box(extents=(a, a, a), **at),
    lambda a, **at: Capsule(radius=0.3 * a, length=0.4 * a, **at),
    lambda a, **at: Ellipsoid(radii=(0.5 * a, 0.4 * a, 0.3 * a), **at),
)
ANGLES = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


def felt(
    obstacles: dict[str, Obstacle],
    point: np.ndarray,
    wind: tuple[float, float, float],
    moved: dict[str, Pose] | None = None,
    flow: np.ndarray | None = None,
) -> np.ndarray:
    """Velocity of the air at each ``point`` (V, 3) m while obstacles move; the wind's own by default."""
    config = SolverConfig()
    contacts = Contacts(obstacles, MESH, Material(), np.ones(4), config)
    before = {name: shape.pose for name, shape in obstacles.items()}
    contacts.begin_step(before, {**before, **(moved or {})})
    flow = np.tile(np.array(wind, float), (len(point), 1)) if flow is None else flow.copy()
    Wakes(obstacles, contacts, config).shelter(point, Wind(velocity=wind), flow)
    return flow


def line(*ends: tuple[float, float, float], count: int = 200) -> np.ndarray:
    return np.linspace(*map(np.array, ends), count)


@given(
    st.sampled_from(FINITE),
    st.floats(0.05, 20.0),
    ANGLES,
    st.tuples(*[st.floats(-5.0, 5.0)] * 3),
    st.floats(0.0, 2.0 * math.pi),
    st.floats(-1.0, 1.0),
    st.floats(0.1, 30.0),
)
@settings(max_examples=60)
def test_still_behind_and_windy_before_and_beside_whatever_the_shape_size_and_direction(
    shape, size, turn, center, heading, climb, speed
):
    flat = math.sqrt(1.0 - climb * climb)
    toward = np.array([flat * math.cos(heading), flat * math.sin(heading), climb])
    aside = np.cross(toward, np.eye(3)[np.argmin(np.abs(toward))])
    aside /= np.linalg.norm(aside)
    body = shape(size, center=center, orientation=tuple(np.array(turn) / np.linalg.norm(turn)))
    wind = tuple(speed * toward)
    # Width and reach are those of the shapes at a size of 1, and at least.
    points = np.array(center) + body.reach * np.array([1.02 * toward, -1.02 * toward, toward + 1.3 * aside])
    behind, before, beside = felt({"it": body}, points, wind)
    assert np.linalg.norm(behind) < 1e-9 * speed
    np.testing.assert_array_equal([before, beside], [wind, wind])
    far = np.array([center]) + (body.reach + 7.0 * size * 3**0.5) * toward
    np.testing.assert_array_equal(felt({"it": body}, far, wind), [wind])


def test_the_wake_of_a_cube_is_full_for_one_and_a_half_widths_and_closes_smoothly_until_six():
    box, wind = {"box": Box(extents=(2.0, 2.0, 2.0))}, (3.0, 0.0, 0.0)
    x = line((0.9, 0.1, 0.2), (15.0, 0.1, 0.2), count=2000)
    share = felt(box, x, wind)[:, 0] / 3.0
    behind = (x[:, 0] - 1.0) / 2.0  # widths
    np.testing.assert_array_equal(share[behind < 1.49], 0.0)
    np.testing.assert_array_equal(share[behind > 6.0], 1.0)
    assert (np.diff(share) >= 0.0).all() and np.diff(share).max() < 0.003
    assert share[np.searchsorted(behind, 3.75)] == pytest.approx(0.5, abs=0.01)


def test_the_edge_of_the_shadow_grows_downwind_and_is_smooth():
    box, wind = {"box": Box(extents=(2.0, 2.0, 2.0))}, (3.0, 0.0, 0.0)
    thickness = []
    for behind in (0.5, 1.5, 2.5):
        share = felt(box, line((1.0 + behind, 0.9, 0), (1.0 + behind, 1.9, 0), count=4000), wind)[:, 0] / 3.0
        y = np.linspace(0.9, 1.9, 4000)
        np.testing.assert_array_equal(share[y < 1.0], 0.0)
        assert (np.diff(share) >= -1e-12).all() and np.diff(share).max() < 0.02
        thickness.append(y[share >= 1.0][0] - 1.0)
    # It begins at the front edge, two metres before the back.
    np.testing.assert_allclose(thickness, kernels.SPREAD * np.array([2.5, 3.5, 4.5]), rtol=0.02)


def test_a_mesh_that_stands_off_its_own_origin_has_the_wake_of_the_shape_it_is():
    """In the shadow there is no wind, beside it all of it, and about its edge what a box gives, to a few per cent."""
    mesh = trimesh.creation.box((1.0, 0.8, 0.6))
    mesh.apply_translation((2.0, 0.0, 0.5))
    turn, wind = (0.1, -0.2, 0.3, 0.9), (0.0, 3.0, 0.5)
    quaternion = tuple(np.array(turn) / np.linalg.norm(turn))
    field = VoxelField(surface=closed(mesh.vertices, mesh.faces), voxel=0.04, orientation=quaternion)
    middle = field.pose.apply(np.array([[2.0, 0.0, 0.5]]))[0]
    box = Box(extents=(1.0, 0.8, 0.6), center=tuple(middle), orientation=quaternion)
    random = np.random.default_rng(4)
    toward = np.array(wind) / np.linalg.norm(wind)
    points = middle + random.normal(size=(400, 3)) * 0.6 + random.uniform(0.0, 4.0, (400, 1)) * toward
    points = points[np.linalg.norm(points - middle, axis=1) > box.reach]
    shares = [felt({"it": it}, points, wind) @ toward / np.linalg.norm(wind) for it in (field, box)]
    assert np.abs(shares[0] - shares[1]).max() < 0.15 and np.abs(shares[0] - shares[1]).mean() < 0.01
    behind, beside = middle + 1.2 * toward, middle + 1.5 * np.cross(toward, [1.0, 0.0, 0.0])
    quiet, windy = felt({"it": field}, np.array([behind, beside]), wind)
    assert np.linalg.norm(quiet) < 1e-9
    np.testing.assert_array_equal(windy, wind)


def test_a_pole_has_the_wake_of_its_thickness_and_a_plate_that_of_its_face():
    """Not of its length, and not of its thickness."""
    pole = {"it": Capsule(radius=0.02, length=2.0)}
    plate = {"it": Box(extents=(0.01, 1.0, 1.0))}
    x = line((0.03, 0.0, 0.0), (8.0, 0.0, 0.0), count=4000)
    ends = [x[np.argmax(felt(it, x, (4.0, 0.0, 0.0))[:, 0] == 4.0), 0] for it in (pole, plate)]
    np.testing.assert_allclose(ends, [0.02 + 6.0 * 0.04, 0.005 + 6.0], atol=0.005)


@given(ANGLES, st.tuples(*[st.floats(0.05, 2.0)] * 3), st.floats(-1.0, 1.0), st.floats(0.0, 6.28))
def test_the_least_width_of_a_box_is_that_of_its_picture(turn, half, climb, heading):
    flat = math.sqrt(1.0 - climb * climb)
    toward = np.array([flat * math.cos(heading), flat * math.sin(heading), climb])
    rotation = Pose(orientation=tuple(np.array(turn) / np.linalg.norm(turn))).rotation
    found = kernels.least_width(rotation, np.array(half), *toward)
    expected = twins.least_width(rotation, np.array(half), toward)
    assert expected * (1.0 - 1e-2) <= found <= expected * (1.0 + 1e-9)


@given(st.integers(0, 10**6))
@settings(max_examples=6)
def test_shelter_is_that_of_rays_walked_in_small_steps(seed):
    random = np.random.default_rng(seed)
    quaternion = random.normal(size=4)
    body = FINITE[random.integers(4)](1.0, orientation=tuple(quaternion / np.linalg.norm(quaternion)))
    toward = random.normal(size=3)
    toward /= np.linalg.norm(toward)
    points = 0.5 * random.normal(size=(12, 3)) + random.uniform(0.5, 5.0, (12, 1)) * toward
    wind = 2.0 * toward
    width = kernels.least_width(body.pose.rotation, np.array(body.half_extents), *toward)
    shares = [twins.shelter(body, width, toward, point) for point in points]
    expected = (1.0 - np.array(shares))[:, None] * wind
    np.testing.assert_allclose(felt({"it": body}, points, tuple(wind)), expected, atol=0.06)


def test_the_wake_of_what_moves_points_along_the_relative_wind_and_goes_with_it():
    ball, step = {"ball": Sphere(radius=0.5)}, np.array([0.0, 0.06, 0.0])  # 3 m/s
    drift, wind = step / SolverConfig().dt, np.array([4.0, 0.0, 0.0])
    toward = (wind - drift) / 5.0
    points = np.array([0.7 * toward, [1.5, 0.0, 0.0], [-1.5, 0.0, 0.0]])
    there, downwind, upwind = felt(ball, points, tuple(wind), {"ball": Pose(tuple(step))})
    np.testing.assert_allclose(there, drift, atol=1e-12)
    np.testing.assert_array_equal([downwind, upwind], [wind, wind])
    still = felt(ball, points, (0.0, 0.0, 0.0), {"ball": Pose(tuple(step))})
    np.testing.assert_array_equal(still, np.zeros((3, 3)))
    behind = felt(ball, np.array([[0.0, -0.7, 0.0]]), (0.0, 0.0, 0.0), {"ball": Pose(tuple(step))})
    np.testing.assert_allclose(behind, [drift], atol=1e-12)


def test_what_is_teleported_drags_no_air():
    ball = {"ball": Sphere(radius=0.5)}
    jump = felt(ball, np.array([[8.8, 0.0, 0.0], [9.0, 0.0, 0.0]]), (0.0, 0.0, 0.0), {"ball": Pose((10.0, 0.0, 0.0))})
    assert not jump.any()


def test_no_wind_comes_out_of_the_ground_and_gusts_stay():
    ground = {"ground": Plane(center=(0.0, 0.0, -1.0))}
    points, gusts = np.random.default_rng(1).uniform(0, 5, (2, 50, 3))
    rising, sinking = (4.0, 1.0, 0.5), (4.0, 1.0, -0.5)
    np.testing.assert_allclose(
        felt(ground, points, rising, flow=np.array(rising) + gusts), np.array([4.0, 1.0, 0.0]) + gusts, atol=1e-12
    )
    np.testing.assert_array_equal(
        felt(ground, points, sinking, flow=np.array(sinking) + gusts), np.array(sinking) + gusts
    )


def test_shadows_of_several_obstacles_add_up_in_any_order():
    named = {
        "ball": Sphere(radius=0.4),
        "box": Box(extents=(0.5, 0.5, 0.5), center=(0.0, 0.3, 0.0)),
        "egg": Ellipsoid(radii=(0.2, 0.3, 0.4), center=(-1.0, -0.2, 0.1)),
    }
    points = line((2.0, -1.5, 0.05), (2.0, 1.5, 0.05))
    alone = [felt({name: shape}, points, (2.0, 0.0, 0.0))[:, 0] / 2.0 for name, shape in named.items()]
    for order in itertools.permutations(named):
        together = felt({name: named[name] for name in order}, points, (2.0, 0.0, 0.0))[:, 0] / 2.0
        np.testing.assert_allclose(together, np.prod(alone, axis=0), atol=1e-12)
    assert 0.0 < np.prod(alone, axis=0).mean() < 1.0


@pytest.mark.parametrize(("integrator", "lively"), [("implicit_midpoint", 1.0), ("meyer2000", 0.01)])
@pytest.mark.parametrize(("aside", "still"), [(0.0, True), (1.2, False)])
def test_behind_an_obstacle_a_hanging_cloth_does_not_flap(integrator, lively, aside, still):
    """The paper's sentence: gusts of 6 m/s, and a scarf in the lee of a box, or next to it."""
    mesh = ClothMesh.grid(width=0.3, height=0.3, columns=8, rows=8)
    solver = ClothSolver(
        mesh, Material(damping=1.0), SolverConfig(integrator=integrator),
        obstacles={"box": Box(extents=(0.8, 0.8, 0.8), center=(-0.6, aside, 0.0))},
    )  # fmt: skip
    solver.pin(mesh.group("top"))
    state = solver.initial_state(Pose((0.0, 0.0, 0.0), (0.5, 0.5, 0.5, 0.5)))
    inputs, speeds = Inputs(wind=Wind(velocity=(6.0, 0.0, 0.0), gust_intensity=0.3)), []
    for _ in range(150):
        state = solver.step(state, inputs)
        speeds.append(np.linalg.norm(state.velocity, axis=1).max())
    assert (max(speeds[100:]) < 1e-6) if still else (max(speeds[100:]) > lively)


def test_the_law_of_the_shadow_sees_when_there_is_none(monkeypatch):
    law = next(law for law in medium.LAWS if law.name == "wind shadow")
    monkeypatch.setattr(Wakes, "shelter", lambda *_: None)
    assert not law.check("implicit_midpoint").passed


@given(st.integers(0, 10**6))
@settings(max_examples=30)
def test_a_cloth_is_passed_over_only_if_none_of_it_is_sheltered(seed):
    """The ball about the whole must miss nothing that its single points meet."""
    random = np.random.default_rng(seed)
    body = {"it": FINITE[random.integers(4)](1.0)}
    cloth = random.normal(0, 4.0, 3) + random.normal(0, random.uniform(0.1, 3.0), (40, 3))
    wind = tuple(random.normal(0, 5, 3))
    alone = np.concatenate([felt(body, point[None], wind) for point in cloth])
    np.testing.assert_array_equal(felt(body, cloth, wind), alone)
