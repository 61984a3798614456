"""In a fluid cloth is dragged along and lifted, where it is wet, and nowhere else; whatever the fluid and the step."""

from __future__ import annotations

import json

import numpy as np
import pytest
import twins
from hypothesis import given, settings
from hypothesis import strategies as st

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Fluid,
    InputError,
    Inputs,
    Material,
    Pose,
    SettingError,
    SolverConfig,
    Wind,
)
from cloth_core.obstacles import Box, Capsule, Ellipsoid, Plane, Sphere
from cloth_core.physics.immersion import Immersion, regions_of
from cloth_core.scene import Scene
from cloth_core.validation import INTEGRATORS
from cloth_core.validation.geometry import irregular_sheet

STILL = (0.0, 0.0, 0.0)
QUATERNIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)


def pose(turn: tuple[float, ...], at: tuple[float, float, float] = STILL) -> Pose:
    return Pose(at, tuple(np.array(turn) / np.linalg.norm(turn)))


def forces(
    mesh: ClothMesh, x: np.ndarray, v: np.ndarray, fluids: dict[str, Fluid], material: Material, gravity=(0, 0, -9.81),
    h: float = 0.002,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """(V, 3) N, and the dry share (V,) of a cloth at ``x`` m with ``v`` m/s."""
    shown, force = twins.area_vectors(x, mesh.triangles), np.zeros_like(x)
    before = shown.copy()
    wet = Immersion(mesh, material, mesh.vertex_mass(material))
    dry = wet.add_forces(x, v, np.array(gravity, float), h, regions_of(fluids, material), shown, force)
    share = dry / mesh.vertex_area
    np.testing.assert_allclose(shown, share[:, None] * before, atol=1e-15)
    return force, share


@given(st.integers(0, 10**6), st.sampled_from([5e-4, 0.0025, 0.1]))
@settings(max_examples=40)
def test_forces_are_those_of_the_twin(seed, h):
    random = np.random.default_rng(seed)
    mesh, fabric = irregular_sheet(0.4, 0.3, 4), Material(thickness=random.uniform(1e-4, 0.02), drag=1.1)
    turns = random.normal(size=(2, 4))
    at = random.uniform(-0.1, 0.1, (2, 3))
    shapes = [
        (Plane, {}), (Box, {"extents": (0.3, 0.2, 0.2)}), (Sphere, {"radius": 0.15}),
        (Capsule, {"radius": 0.1, "length": 0.2}), (Ellipsoid, {"radii": (0.2, 0.1, 0.15)}),
    ]  # fmt: skip
    fluids = {}
    for name, turn, center in zip("ab", turns, at, strict=True):
        kind, size = shapes[random.integers(5)]
        fluids[name] = Fluid(
            shape=kind(**size, center=tuple(center), orientation=pose(turn).orientation),
            velocity=tuple(random.normal(size=3)), density=random.uniform(0, 2000), drag=random.choice([None, 0.7]),
            skin_drag=random.uniform(0, 0.1), displaced=random.uniform(0, 1),
        )  # fmt: skip
    x = mesh.rest_position + random.normal(0, 0.03, mesh.rest_position.shape)
    v, gravity = random.normal(size=x.shape), random.normal(0, 5, 3)
    given_as = [
        (f.shape, np.array(f.velocity), f.density, 1.1 if f.drag is None else f.drag, f.skin_drag, f.displaced)
        for f in fluids.values()
    ]
    mass = mesh.vertex_mass(fabric)
    expected, dry = twins.immersed(
        x, v, mesh.vertex_area, mass, fabric.thickness, gravity, h, given_as, twins.area_vectors(x, mesh.triangles)
    )
    found, share = forces(mesh, x, v, fluids, fabric, gravity, h)
    np.testing.assert_allclose(share, dry, atol=1e-5)
    np.testing.assert_allclose(found, expected, atol=1e-4 * max(1.0, np.abs(expected).max()))


@given(QUATERNIONS, st.floats(0.05, 3.0), st.integers(2, 12))
@settings(max_examples=30)
def test_lift_and_drag_of_a_sheet_do_not_depend_on_its_mesh_or_place(turn, size, count):
    """Face-on rho C_D / 2 v^2 per area, along it rho C / 2 v^2, and up rho t g."""
    mesh, fabric, placed = ClothMesh.grid(width=size, height=size, columns=count, rows=3), Material(), pose(turn)
    x, normal, side = placed.apply(mesh.rest_position), placed.rotation[:, 2], placed.rotation[:, 0]
    for direction, drag in ((normal, fabric.drag), (side, 0.01)):
        sea = {"sea": Fluid(shape=Plane(center=(0.0, 0.0, 10.0)), velocity=tuple(0.01 * direction))}
        force, dry = forces(mesh, x, np.zeros_like(x), sea, fabric)
        expected = 500.0 * drag * 1e-4 * direction + [0.0, 0.0, 1000.0 * fabric.thickness * 9.81]
        np.testing.assert_allclose(force.sum(axis=0), size * size * expected, rtol=1e-9, atol=1e-9 * size * size)
        assert not dry.any()


@given(QUATERNIONS, st.sampled_from([1e-3, 0.01, 0.1]), st.floats(1e-3, 30.0), st.floats(10.0, 2e4))
@settings(max_examples=40)
def test_no_stream_makes_the_cloth_faster_than_itself(turn, h, speed, density):
    """Left alone, no vertex overshoots: neither through the cloth nor along it."""
    mesh, fabric = irregular_sheet(0.4, 0.3, 5), Material()
    x, stream = pose(turn).apply(mesh.rest_position), np.array([speed, 0.0, 0.0])
    sea = {"sea": Fluid(shape=Plane(center=(0.0, 0.0, 10.0)), velocity=tuple(stream), density=density)}
    force, _ = forces(mesh, x, np.zeros_like(x), sea, fabric, STILL, h)
    gained, normal = h * force / mesh.vertex_mass(fabric)[:, None], pose(turn).rotation[:, 2]
    left = stream - gained
    for direction in (normal, stream - (stream @ normal) * normal):
        way = stream @ direction
        assert (left @ direction * np.sign(way) >= -1e-9 * speed**2).all()
        assert (gained @ direction * np.sign(way) >= -1e-9 * speed**2).all()


@given(st.floats(0.0, 1.0), st.booleans())
def test_half_a_cloth_is_wet_where_half_of_it_is_below(level, upright):
    """Standing, by its height; lying, by its thickness."""
    fabric, mesh = Material(thickness=0.004), ClothMesh.grid(width=1.0, height=1.0, columns=41, rows=41)
    turn, height = ((2**-0.5, 0.0, 0.0, 2**-0.5), 1.0) if upright else ((0.0, 0.0, 0.0, 1.0), fabric.thickness)
    x = pose(turn).apply(mesh.rest_position)
    sea = {"sea": Fluid(shape=Plane(center=(0.0, 0.0, (level - 0.5) * height)))}
    force, dry = forces(mesh, x, np.zeros_like(x), sea, fabric, h=1e-4)
    # The outermost half patch counts as far out as its vertex.
    assert 1.0 - mesh.vertex_area @ dry == pytest.approx(level, abs=0.02 if upright else 1e-7)
    assert force[:, 2].sum() == pytest.approx(level * 1000.0 * fabric.thickness * 9.81, abs=0.8 if upright else 1e-5)


def test_where_fluids_overlap_the_first_name_counts_and_the_rest_goes_on_below():
    mesh, fabric = ClothMesh.grid(width=0.1, height=0.1, columns=3, rows=3), Material()
    east, west = Fluid(shape=Plane(), velocity=(1.0, 0, 0)), Fluid(shape=Plane(), velocity=(-1.0, 0, 0))
    below = mesh.rest_position - [0.0, 0.0, 1.0]
    for fluids, sign in (({"a": east, "b": west}, 1.0), ({"a": west, "b": east}, -1.0), ({"b": west, "a": east}, 1.0)):
        force, dry = forces(mesh, below, np.zeros_like(below), fluids, fabric)
        assert (sign * force[:, 0] > 0.0).all() and not dry.any()
    oil = Fluid(shape=Plane(), density=0.0)
    force, dry = forces(mesh, mesh.rest_position, 0 * below, {"a": oil, "b": east}, fabric)
    np.testing.assert_allclose(dry, 0.25)  # half in oil, and half of what is left in water


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_fluid_that_is_not_touched_changes_no_bit(integrator):
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=8, rows=8)
    ends = []
    for fluids in ({}, {"pond": Fluid(shape=Box(extents=(1.0, 1.0, 1.0), center=(0.0, 5.0, 0.0)))}):
        solver = ClothSolver(mesh, config=SolverConfig(integrator=integrator))
        solver.pin([0])
        state = solver.initial_state()
        for _ in range(10):
            state = solver.step(state, Inputs(wind=Wind(velocity=(3.0, 0, 0)), fluids=fluids))
        ends.append(state)
    np.testing.assert_array_equal(ends[0].position, ends[1].position)
    np.testing.assert_array_equal(ends[0].velocity, ends[1].velocity)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("dt", [0.005, 0.02, 0.1])
@pytest.mark.parametrize("density", [1000.0, 2e4])
def test_a_cloth_that_is_thrown_into_a_river_is_carried_along_and_stays_whole(integrator, dt, density):
    """Started upright above the water, one substep or many: it falls in, floats, and goes with the stream."""
    config = SolverConfig(integrator=integrator, dt=dt)
    solver = ClothSolver(ClothMesh.grid(width=0.4, height=0.4, columns=9, rows=9), Material(), config)
    state = solver.initial_state(pose((0.6, 0.2, 0.1, 0.7), (0.0, 0.0, 0.4)))
    river = Inputs(fluids={"river": Fluid(shape=Plane(), velocity=(0.8, 0.0, 0.0), density=density, skin_drag=0.1)})
    for _ in range(round(6.0 / dt)):
        state = solver.step(state, river)
        assert not solver.report.recovered
    assert solver.report.max_stretch < solver.material.stretch_limit + 0.05
    assert state.velocity.mean(axis=0)[0] == pytest.approx(0.8, abs=0.03)
    assert np.abs(state.velocity - [0.8, 0.0, 0.0]).max() < 0.1
    fabric, h = solver.material, dt / solver.substeps  # the surface is as thick as the step needs
    thick = 4.0 * density * fabric.thickness * 9.81 * h * h / fabric.areal_density
    assert np.abs(state.position[:, 2]).max() < 0.25 + 0.5 * thick


def test_a_region_moves_from_step_to_step_and_flows_as_it_is_told():
    mesh = ClothMesh.grid(width=0.2, height=0.2, columns=4, rows=4)
    solver = ClothSolver(mesh)
    jet = Fluid(shape=Box(extents=(1.0, 1.0, 1.0)), velocity=(0.0, 0.0, 1.0))
    away, state = jet.at(Pose((0.0, 2.0, 0.0), (0.0, 0.0, 0.6, 0.8))), solver.initial_state()
    assert away.shape.center == (0.0, 2.0, 0.0) and away.velocity == jet.velocity
    none = Inputs(gravity=STILL)
    np.testing.assert_array_equal(
        solver.step(state, Inputs(fluids={"jet": away}, gravity=STILL)).position, solver.step(state, none).position
    )
    assert (solver.step(state, Inputs(fluids={"jet": jet}, gravity=STILL)).velocity[:, 2] > 0.1).all()


def test_a_turned_plane_faces_along_its_frame():
    level = Fluid(shape=Plane(normal=(1.0, 0.0, 0.0))).at(Pose((0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0)))
    np.testing.assert_allclose(level.shape.pose.rotation[:, 2], [0.0, 0.0, 1.0], atol=1e-12)


@given(QUATERNIONS, st.floats(0.1, 50.0), st.one_of(st.none(), st.floats(0.0, 10.0)))
def test_inputs_with_fluids_survive_being_written_down(turn, size, drag):
    shape = Ellipsoid(radii=(size, 1.0, 2.0), orientation=pose(turn).orientation)
    fluids = {"river": Fluid(shape=shape, velocity=(size, 0.0, -1.0), drag=drag), "sea": Fluid(shape=Plane())}
    inputs = Inputs(fluids=fluids)
    assert Inputs.from_mapping(json.loads(json.dumps(inputs.as_mapping()))) == inputs
    old = inputs.as_mapping()
    del old["fluids"]
    assert Inputs.from_mapping(old).fluids == {}


GRID = "cloth: {grid: {width: 1.0, height: 0.5, columns: 5, rows: 4}}\n"


def test_a_scene_has_fluids_by_name():
    scene = Scene.parse(
        GRID + "fluids: {river: {box: {extents: [9, 2, 1], center: [0, 0, -0.5]}, velocity: [0.5, 0, 0], drag: 2}}"
    )
    expected = Fluid(shape=Box(extents=(9.0, 2.0, 1.0), center=(0.0, 0.0, -0.5)), velocity=(0.5, 0.0, 0.0), drag=2.0)
    assert scene.inputs.fluids == {"river": expected}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("river: {velocity: [1, 0, 0]}", "fluids.river: needs exactly one shape of plane, sphere"),
        ("river: {box: {extents: [1, 1, 1]}, plane: {}}", "exactly one shape of plane, sphere, box"),
        ("river: {boxx: {}}", "fluids.river.boxx: no such key; did you mean box?"),
        ("river: {box: {extents: [1, 1]}}", "fluids.river.box.extents: [1, 1] has 2 components, not 3 numbers"),
        ("river: {plane: {friction: 0.3}}", "fluids.river.plane.friction: 0.3: a fluid has none"),
        ("river: {plane: {}, density: -1}", "fluids.river.density: -1 is out of range: a number 0 .. 20000 kg/m^3"),
        ("river: {plane: {}, velocity: [200, 0, 0]}", "out of range: 3 numbers -100 .. 100 m/s"),
        ("river: {plane: {}, displaced: 2}", "fluids.river.displaced: 2 is out of range: a number 0 .. 1"),
        ("river: {sphere: {radius: 1, orientation: [0, 0, 0, 0]}}", "fluids.river.sphere.orientation"),
        ("1: {plane: {}}", "fluids: 1 is not a name of letters"),
    ],
)
def test_a_wrong_fluid_is_refused_with_its_key(text, said):
    with pytest.raises(SettingError) as refused:
        Scene.parse(GRID + f"fluids: {{{text}}}")
    assert said in str(refused.value)


def test_wrong_fluids_of_a_step_are_refused():
    with pytest.raises(InputError, match=r"fluids.sea: .* is not of the type Fluid; write Fluid\(shape=Plane"):
        Inputs(fluids={"sea": Plane()})
    with pytest.raises(SettingError, match="shape: 3 is not of the type Obstacle"):
        Fluid(shape=3)
