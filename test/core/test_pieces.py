"""Several cloths in one mesh: each moves as it would alone, and they meet."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from cloth_core import ClothMesh, ClothSolver, Inputs, Material, MeshError, Pose, SettingError, SolverConfig, Wind
from cloth_core.config import INTEGRATORS
from cloth_core.scene import Scene
from cloth_core.validation.geometry import irregular_sheet

TOWEL = ClothMesh.grid(width=0.3, height=0.4, columns=7, rows=9)
NAPKIN = ClothMesh.grid(width=0.2, height=0.2, columns=6, rows=5)
AWAY = Pose((2.0, 0.0, 0.5), (0.6, 0.0, 0.0, 0.8))
PAIR = ClothMesh.joined({"towel": TOWEL, "napkin": NAPKIN}, {"napkin": AWAY})
BREEZE = Inputs(wind=Wind(velocity=(0.5, 0.2, 0.0)))  # the energy of a cloth left alone is watched as a whole
FABRIC = Material(areal_density=0.2, damping=0.5)


def falling(mesh, pins, steps=60, pose=None, **config):
    solver = ClothSolver(mesh, FABRIC, SolverConfig(**config))
    solver.pin(pins)
    state = solver.initial_state(pose)
    for _ in range(steps):
        state = solver.step(state, BREEZE)
    return state, solver


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_pieces_that_do_not_meet_move_as_each_does_alone(integrator):
    pins = [PAIR.group("towel_top"), PAIR.group("napkin_left")]
    both, _ = falling(PAIR, np.concatenate(pins), integrator=integrator)
    towel, _ = falling(TOWEL, TOWEL.group("top"), integrator=integrator)
    napkin, _ = falling(NAPKIN, NAPKIN.group("left"), pose=AWAY, integrator=integrator)
    np.testing.assert_allclose(both.position[PAIR.pieces["towel"]], towel.position, atol=1e-9)
    np.testing.assert_allclose(both.position[PAIR.pieces["napkin"]], napkin.position, atol=1e-9)


def test_a_mesh_of_pieces_has_all_that_the_pieces_have():
    assert PAIR.vertex_count == 63 + 30 and len(PAIR.triangles) == len(TOWEL.triangles) + len(NAPKIN.triangles)
    np.testing.assert_array_equal(PAIR.group("napkin"), np.arange(63, 93))
    np.testing.assert_array_equal(PAIR.group("napkin_top"), NAPKIN.group("top") + 63)
    np.testing.assert_array_equal(PAIR.group("towel_corners"), TOWEL.group("corners"))
    assert PAIR.vertex_mass(FABRIC).sum() == pytest.approx(0.2 * (0.3 * 0.4 + 0.2 * 0.2), rel=1e-12)
    assert len(set(PAIR.component[PAIR.pieces["towel"]]) & set(PAIR.component[PAIR.pieces["napkin"]])) == 0
    i, j = PAIR.spring_vertex.T
    np.testing.assert_allclose(np.linalg.norm(PAIR.rest_position[j] - PAIR.rest_position[i], axis=1), PAIR.spring_rest)


@pytest.mark.parametrize("meet", [True, False])
def test_a_piece_stays_on_the_other_if_they_collide_and_falls_through_if_not(meet):
    mesh = ClothMesh.joined({"upper": NAPKIN, "lower": TOWEL}, {"upper": Pose((0.0, 0.0, 0.1))})
    pins = np.concatenate([mesh.group("lower_left"), mesh.group("lower_right")])
    state, solver = falling(mesh, pins, steps=100, self_collision=meet)
    above = state.position[mesh.pieces["upper"], 2].mean() - state.position[mesh.group("lower"), 2].mean()
    if meet:
        assert -0.05 < above < 0.1 and solver.report.crossings == 0
    else:
        assert above < -1.0


def test_where_triangles_carry_one_piece_they_carry_all():
    sheet = irregular_sheet(0.3, 0.3, 6)
    mixed = ClothMesh.joined({"grid": TOWEL, "sheet": sheet}, {"sheet": Pose((1.0, 0.0, 0.0))})
    assert mixed.is_membrane(FABRIC) and not TOWEL.is_membrane(FABRIC)
    state, _ = falling(mixed, np.concatenate([mixed.group("grid_top"), mixed.pieces["sheet"][:2]]))
    alone, _ = falling(dataclasses.replace(TOWEL, spring_weight=0.0 * TOWEL.spring_weight), TOWEL.group("top"))
    np.testing.assert_allclose(state.position[mixed.pieces["grid"]], alone.position, atol=1e-9)


def test_what_cannot_be_joined_is_refused():
    chain = ClothMesh.from_springs(np.eye(3), [[0, 1], [1, 2]], stiffness=10.0, mass=0.1)
    with pytest.raises(MeshError, match="rope are springs only and towel sheets"):
        ClothMesh.joined({"towel": TOWEL, "rope": chain})
    with pytest.raises(MeshError, match="two groups would be called towel_left"):
        ClothMesh.joined({"towel_left": NAPKIN, "towel": TOWEL})
    with pytest.raises(MeshError, match="poses of sock; the pieces are towel"):
        ClothMesh.joined({"towel": TOWEL}, {"sock": Pose()})
    with pytest.raises(MeshError, match="no pieces"):
        ClothMesh.joined({})


SCENE = """
cloth:
  towel:
    grid: {width: 0.3, height: 0.4, columns: 7, rows: 9}
  napkin:
    grid: {width: 0.2, height: 0.2, columns: 6, rows: 5}
    position: [0.0, 0.0, 0.1]
    orientation: [0.0, 0.0, 1.0, 1.0]
solver: {self_collision: true}
pins: [towel_top, towel_bottom]
"""


def test_a_scene_has_pieces_by_name():
    scene = Scene.parse(SCENE)
    assert list(scene.mesh.pieces) == ["towel", "napkin"] and scene.placement == Pose()
    solver, state = scene.build()
    np.testing.assert_allclose(state.position[scene.mesh.group("napkin"), 2], 0.1)
    # turned by 90 degrees about z: its left edge lies along x
    np.testing.assert_allclose(state.position[scene.mesh.group("napkin_left"), 1], -0.1, atol=1e-12)
    assert len(solver.pinned) == 14


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("columns: 6", "columns: 1", "scene: cloth.napkin.grid.columns: 1 is out of range: a whole number 2 .. 1000"),
        ("position: [0.0, 0.0, 0.1]", "posiion: [0.0]", "scene: cloth.napkin.posiion: no such key; did you mean pos"),
        ("position: [0.0, 0.0, 0.1]", "position: [0.0]", "scene: cloth.napkin.position: "),
        ("[0.0, 0.0, 1.0, 1.0]", "[0, 0, 0, 0]", "scene: cloth.napkin: orientation"),
        ("width: 0.2, height: 0.2", "width: 0.001, height: 999", "scene: cloth.napkin: the cells of the grid are"),
        ("  napkin:", "  3napkin:", "scene: cloth: '3napkin' is not a name of letters"),
        ("[towel_top, towel_bottom]", "[top]", "scene: pins: no vertex group 'top'; this cloth has napkin, "),
        ("  napkin:\n", "  towel_left:\n", "scene: cloth: two groups would be called towel_left"),
    ],
)
def test_what_is_wrong_with_a_piece_is_said_with_its_name(old, new, said):
    assert SCENE.count(old) == 1
    with pytest.raises(SettingError) as refused:
        Scene.parse(SCENE.replace(old, new))
    assert str(refused.value).startswith(said)
