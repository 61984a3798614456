"""Two fingers close on a cloth, lift it, carry it and let it go: held by friction, and lost beyond Coulomb's limit."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Grasp,
    Gripper,
    InputError,
    Inputs,
    Material,
    Pose,
    SettingError,
    SolverConfig,
)
from cloth_core.kernels import pinching, shapes
from cloth_core.obstacles import Box, Capsule, Plane
from cloth_core.scene import Scene

HANGING = Pose(orientation=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
THICK = 0.02
ALONG_X = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def finger(shape, side):
    """One that waits 3 cm to a side of the cloth, near its upper edge."""
    center = (0.0, side * (0.03 + 0.5 * THICK), 0.12)
    if shape == "box":
        return Box(extents=(0.04, THICK, 0.04), center=center)
    return Capsule(radius=0.5 * THICK, length=0.04, center=center, orientation=ALONG_X)


def built(shape="box", side=21, force=20.0, material=None, **config):
    """A cloth of 0.3 m that hangs by its upper corners between two open fingers."""
    mesh = ClothMesh.grid(width=0.3, height=0.3, columns=side, rows=side)
    solver = ClothSolver(
        mesh,
        material or Material(friction=0.5, damping=1.0),
        SolverConfig(**config),
        obstacles={"left": finger(shape, -1), "right": finger(shape, 1)},
        grippers={"claw": Gripper(left="left", right="right", force=force)},
    )
    solver.pin(mesh.group("corners")[:2])
    return solver, solver.initial_state(HANGING)


def fingers(solver, gap, height=0.12, shift=0.0):
    way = 0.5 * (gap + THICK)
    turn = solver.obstacles["left"].pose.orientation
    return Inputs(
        obstacles={
            "left": Pose((shift, -way, height), turn),
            "right": Pose((shift, way, height), turn),
        }
    )


def played(solver, state, gaps, heights, seconds, each=lambda state: None):
    """Fingers go evenly from one gap and height to the other; the last state, and ``each`` hears of all."""
    count = round(seconds / solver.config.dt)
    for n in range(1, count + 1):
        share = n / count
        gap, height = (a + (b - a) * share for a, b in (gaps, heights))
        state = solver.step(state, fingers(solver, gap, height))
        each(state)
    return state


def weight_of(solver):
    return 9.81 * solver.mesh.vertex_mass(solver.material).sum()


@pytest.mark.parametrize(
    ("shape", "side", "integrator"),
    [
        ("box", 9, "implicit_midpoint"),
        ("box", 21, "implicit_midpoint"),
        ("box", 35, "implicit_midpoint"),
        ("capsule", 21, "implicit_midpoint"),
        ("box", 15, "meyer2000"),
    ],
)
def test_fingers_close_lift_carry_and_let_go(shape, side, integrator):
    solver, state = built(shape, side, integrator=integrator)

    def is_calm(state):
        assert np.abs(state.velocity).max() < 0.5  # nothing is thrown out from between them

    def is_held(state):
        assert solver.report.slips == () and len(state.held) > 0
        assert integrator == "meyer2000" or solver.report.max_stretch < 1.03 + 0.05

    state = played(solver, state, (0.06, 0.006), (0.12, 0.12), 0.5, is_calm)
    solver.unpin()
    state = played(solver, state, (0.006, 0.006), (0.12, 0.42), 1.0, is_held)
    state = played(solver, state, (0.006, 0.006), (0.42, 0.42), 8.0 if integrator == "meyer2000" else 2.0, is_held)
    assert np.abs(state.position[state.held, 1]).max() < 1e-6  # in the middle
    assert state.position[:, 2].max() > 0.4 and state.position[:, 2].mean() < 0.4
    felt = np.array(solver.report.grasp_wrenches["claw"].force)
    np.testing.assert_allclose(felt, [0.0, 0.0, -weight_of(solver)], atol=0.02 * weight_of(solver))
    state = played(solver, state, (0.006, 0.06), (0.42, 0.42), 0.6)
    assert len(state.held) == 0 and not state.grips["claw"].closed
    assert state.position[:, 2].max() < 0.42 and solver.report.grasp_wrenches["claw"].force == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_it_slips_where_the_weight_is_more_than_both_frictions_bear(factor):
    """Both fingers together bear 2 mu N along themselves; the cloth hangs still in a grip that could bear any."""
    friction, weight = 0.5, weight_of(built()[0])
    fabric = Material(friction=friction, damping=4.0)
    solver, state = built(material=fabric)
    state = played(solver, state, (0.06, 0.006), (0.12, 0.12), 0.5)
    solver.unpin()
    state = played(solver, state, (0.006, 0.006), (0.12, 0.12), 3.0)
    weaker, _ = built(force=factor * weight / (2 * friction), material=fabric)
    weaker.unpin()
    slips = []
    state = played(weaker, state, (0.006, 0.006), (0.12, 0.12), 0.6, lambda _: slips.extend(weaker.report.slips))
    if factor > 1.0:
        assert slips == [] and len(state.held) > 0 and state.position[:, 2].max() > 0.1
    else:
        assert [slip.name for slip in slips] == ["claw"] and slips[0].load == pytest.approx(weight, rel=0.01)
        assert len(state.held) == 0 and state.position[:, 2].max() < 0.0


def test_what_pulls_across_the_fingers_is_no_reason_to_slip():
    """A cloth that is drawn aside with twice its weight pulls along them with its weight at most, as before."""
    weight = weight_of(built()[0])
    solver, state = built(force=0.75 * weight, material=Material(friction=1.0, damping=4.0))
    state = played(solver, state, (0.06, 0.006), (0.12, 0.12), 0.5)
    solver.unpin()
    state = played(solver, state, (0.006, 0.006), (0.12, 0.12), 2.0)
    for n in range(200):
        sideways = Inputs(obstacles=fingers(solver, 0.006).obstacles, gravity=(0.0, 0.1 * n, -9.81))
        state = solver.step(state, sideways)
        assert solver.report.slips == ()
    force = np.array(solver.report.grasp_wrenches["claw"].force)
    assert np.linalg.norm(force) > 2 * 0.75 * weight > abs(force[2])


def test_fingers_pinch_cloth_that_lies_on_a_table_and_come_back_bit_equal():
    mesh = ClothMesh.grid(width=0.4, height=0.4, columns=21, rows=21)
    plate = Box(extents=(0.04, 0.04, 0.01))

    def fresh():
        return ClothSolver(
            mesh, Material(friction=0.6), obstacles={"ground": Plane(), "pad": plate, "spoon": plate},
            grippers={"claw": Gripper(left="spoon", right="pad")},
        )  # fmt: skip

    def inputs(n):
        down, up = 0.05 - 0.044 * min(1.0, n / 20), 0.3 * max(0.0, (n - 30) / 60)
        # The spoon lies under the edge of the cloth; the pad comes from above.
        return Inputs(obstacles={"spoon": Pose((0.2, 0.0, up)), "pad": Pose((0.2, 0.0, down + 0.01 + up))})

    solver = fresh()
    state, at = solver.initial_state(Pose((0.0, 0.0, 0.0105))), {}
    for n in range(90):
        state = solver.step(state, inputs(n))
        at[n] = (state, solver.snapshot(state))
        assert solver.report.max_stretch < 1.08
    assert len(state.held) > 0 and state.position[:, 2].max() > 0.28
    stream = io.BytesIO()
    np.savez(stream, **at[25][1])
    stream.seek(0)
    again = fresh()
    state = again.restore(np.load(stream))
    for n in range(26, 90):
        state = again.step(state, inputs(n))
    assert state.digest == at[89][0].digest


def test_a_gripper_needs_two_fingers_that_there_are():
    mesh, box = ClothMesh.grid(width=0.1, height=0.1, columns=3, rows=3), Box(extents=(0.1, 0.1, 0.1))
    for wrong, said in (({"right": "thumb"}, "no obstacle 'thumb'"), ({"right": "left"}, "is the left finger already")):
        with pytest.raises(SettingError, match=said):
            ClothSolver(mesh, obstacles={"left": box}, grippers={"claw": Gripper(left="left", **wrong)})
    solver, state = built()
    with pytest.raises(InputError, match="claw is a gripper of two obstacles"):
        solver.step(state, Inputs(grasps={"claw": Grasp(pose=Pose())}))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("grippers: {g: {left: a}}", "grippers.g.right: is missing"),
        ("grippers: {g: {left: a, right: b, force: -1}}", "grippers.g.force: -1 is out of range"),
        (
            "obstacles: {a: {sphere: {radius: 1}}}\ngrippers: {g: {left: a, right: b}}",
            "no obstacle 'b'; this scene has a",
        ),
    ],
)
def test_a_scene_with_a_wrong_gripper_is_refused(text, said):
    with pytest.raises(SettingError) as refused:
        Scene.parse("cloth: {grid: {width: 1.0, height: 0.5, columns: 5, rows: 4}}\n" + text)
    assert said in str(refused.value)


def test_the_gap_between_two_fingers_is_that_of_their_surfaces():
    kind = np.array([shapes.SPHERE, shapes.SPHERE])
    size, origin = np.array([[0.1, 0, 0], [0.2, 0, 0]]), np.array([[0.0, 0.0, 0.0], [0.31, 0.0, 0.0]])
    place = np.array([[0.102, 0.0, 0.0], [0.0, 0.101, 0.0], [-0.1, 0.0, 0.0]])
    gap, shift = np.empty(3), np.empty((3, 3))
    pinching.squeeze(place, kind, size, np.tile(np.eye(3), (2, 1, 1)), origin, size[:, 0], 0.05, gap, shift)
    assert gap[0] == pytest.approx(0.01) and np.isinf(gap[1:]).all()
    np.testing.assert_allclose(shift, [[0.003, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], atol=1e-12)
