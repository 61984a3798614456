"""The solver as a whole: where it stands does not matter, and bad input touches nothing."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from busy import assert_same, busy_inputs, busy_solver, played

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Grasp,
    Grip,
    InputError,
    Inputs,
    Material,
    MeshError,
    Pose,
    SettingError,
    SolverConfig,
    State,
    Wind,
)
from cloth_core.obstacles import Box, Sphere
from cloth_core.state import FARTHEST, FASTEST

BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])


def placed_run(integrator: str, pose: Pose, seconds: float = 0.4) -> np.ndarray:
    """Wind, gravity, ball and hand all placed by ``pose``; the result seen from it."""
    mesh = ClothMesh.grid(width=0.6, height=0.5, columns=9, rows=8)
    turn = lambda vector: tuple(pose.rotation @ np.array(vector))  # noqa: E731
    ball = Sphere(radius=0.12, center=tuple(pose.apply(np.array([[0.05, 0.02, -0.15]]))[0]))
    box = pose.compose(Pose((-0.2, 0.0, -0.3), (0.1, 0.2, 0.3, 1.0)))
    obstacles = {"ball": ball, "box": Box(extents=(0.3, 0.3, 0.1), center=box.position, orientation=box.orientation)}
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator), obstacles=obstacles)
    state = solver.initial_state(pose)
    for n in range(round(seconds / 0.02)):
        hand = Grasp(pose=pose.compose(Pose((0.3 - 0.004 * n, 0.25, 0.01 * n))), closure=1.0, radius=0.1)
        wind = Wind(velocity=turn((1.0, 0.5, 0.3)))
        state = solver.step(state, Inputs(grasps={"hand": hand}, wind=wind, gravity=turn((0.0, 0.0, -9.81))))
    return pose.inverse_apply(state.position)


@BOTH
@pytest.mark.parametrize("pose", [Pose((3.0, -2.0, 5.0)), Pose((0.5, 0.2, 0.1), (0.3, -0.5, 0.2, 0.7))])
def test_nothing_depends_on_where_the_world_has_its_origin_or_its_axes(integrator, pose):
    np.testing.assert_allclose(placed_run(integrator, pose), placed_run(integrator, Pose()), atol=1e-6)


@BOTH
def test_pinned_and_grasped_vertices_are_held_alike(integrator):
    """Eliminated from W before factorising, or held through the Schur complement: the same cloth."""
    mesh = ClothMesh.grid(width=0.6, height=0.5, columns=9, rows=8)
    corner = mesh.group("corners")[0]
    results = []
    for pinned in (True, False):
        solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator, dense_limit=0))
        hand = Grasp(pose=Pose(tuple(mesh.rest_position[corner])), closure=0.0 if pinned else 1.0, radius=0.01)
        if pinned:
            solver.pin([corner])
        state = solver.initial_state()
        for _ in range(25):
            state = solver.step(state, Inputs(grasps={"hand": hand}))
        assert solver.report.held == 1
        results.append(state.position)
    np.testing.assert_allclose(*results, atol=1e-8)


def test_pinned_vertices_stay_and_unpinned_fall():
    solver = busy_solver("implicit_midpoint")
    state = played(solver, solver.initial_state(), 0, 10)
    corner = solver.pinned[0]
    np.testing.assert_array_equal(state.position[corner], solver.initial_state().position[corner])
    solver.unpin()
    fallen = played(solver, state, 10, 15)
    assert fallen.position[corner, 2] < state.position[corner, 2] - 0.01


def test_bad_input_raises_and_touches_nothing():
    solver = busy_solver("implicit_midpoint")
    state = played(solver, solver.initial_state(), 0, 6)
    expected = solver.step(state, busy_inputs(6))
    report = solver.report
    broken = State(state.position.copy(), state.velocity, obstacles=state.obstacles)
    broken.position[7, 1] = np.nan
    for message, attempt in (
        (
            "no obstacle wall; this scene has ball, floor",
            lambda: solver.step(state, Inputs(obstacles={"wall": Pose()})),
        ),
        (f"3 sweep counts for {solver.substeps} substeps", lambda: solver.step(state, Inputs(), sweeps=(1, 2, 3))),
        ("state.position: not finite or beyond .* m in the rows \\[7\\]", lambda: solver.step(broken, Inputs())),
        (
            r"state.position: the shape \(4, 3\) is not that of this cloth, \(120, 3\) \(m\)",
            lambda: solver.step(State(np.zeros((4, 3)), np.zeros((4, 3))), Inputs()),
        ),
        ("does not say where ball, floor stands", lambda: solver.step(State(state.position, state.velocity), Inputs())),
        ("cannot pin \\[120\\]: vertices are whole numbers from 0 to 119", lambda: solver.pin([120])),
    ):
        with pytest.raises((InputError, MeshError), match=message):
            attempt()
        assert solver.report is report
    assert_same(solver.step(state, busy_inputs(6)), expected)


MESH = ClothMesh.grid(width=0.6, height=0.5, columns=12, rows=10)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: ClothSolver("mesh"), "mesh: 'mesh' is not of the type ClothMesh; write .*ClothMesh.load"),
        (
            lambda: ClothSolver(MESH, "denim"),
            r"material: 'denim' is not of .* Material; write Material.preset\('denim'\)",
        ),
        (
            lambda: ClothSolver(MESH, {"bend": 1e-5}),
            "material: {'bend': 1e-05} is not of the type Material; write Material",
        ),
        (lambda: ClothSolver(MESH, SolverConfig()), "material: SolverConfig.* is not of the type Material"),
        (
            lambda: ClothSolver(MESH, None, 0.02),
            r"config: 0.02 is not of the type SolverConfig; write SolverConfig\(dt",
        ),
        (
            lambda: ClothSolver(MESH, obstacles=[Sphere(radius=0.1)]),
            r"obstacles: \[Sphere.* does not map names to values; write {'name': Sphere\(radius=0.1\)}",
        ),
        (lambda: ClothSolver(MESH, obstacles=Sphere(radius=0.1)), "obstacles: Sphere.* does not map names"),
        (lambda: ClothSolver(MESH, obstacles={"ball": Pose()}), "obstacles.ball: Pose.* is not of the type Obstacle"),
        (lambda: ClothSolver(MESH, obstacles={3: Sphere(radius=0.1)}), "obstacles: 3 is no name"),
        (lambda: ClothSolver(MESH).changed(material="denim"), r"material: 'denim' .* Material.preset\('denim'\)"),
        (lambda: ClothSolver(MESH).initial_state((0, 0, 1)), r"pose: \(0, 0, 1\) is not of the type Pose; write Pose"),
    ],
)
def test_what_no_solver_is_made_of_is_named_with_what_to_write_instead(build, words):
    with pytest.raises(SettingError, match=words):
        build()


def test_pins_by_the_name_of_a_group_are_answered_with_the_way_to_its_vertices():
    with pytest.raises(MeshError, match=r"cannot pin \['top'\]: .*; mesh.group\(name\) gives those of a group"):
        ClothSolver(MESH).pin("top")


def state_with(**changes) -> State:
    """Of ``MESH`` after some steps, with changes."""
    solver = ClothSolver(MESH)
    return replace(solver.step(solver.initial_state(), Inputs()), **changes)


def with_row(values: np.ndarray, row: int, number: float) -> np.ndarray:
    changed = values.copy()
    changed[row] = number
    return changed


REST, STILL = MESH.rest_position, np.zeros_like(MESH.rest_position)
BAD_STATES = [
    (dict(velocity=STILL[:-1]), r"state.velocity: the shape \(119, 3\) is not that of this cloth, \(120, 3\) \(m/s\)"),
    (dict(position=REST[:, :2]), r"state.position: the shape \(120, 2\) is not that"),
    (dict(position=REST.tolist()), r"state.position: \[\[.* is not an array of numbers \(m\)"),
    (dict(velocity=None), r"state.velocity: None is not an array of numbers \(m/s\)"),
    (dict(position=with_row(REST, 7, 1e160)), r"state.position: not finite or beyond \+-1e\+07 m in the rows \[7\]"),
    (dict(position=with_row(REST, 3, -1.01e7)), r"state.position: not finite or beyond \+-1e\+07 m in the rows \[3\]"),
    (dict(velocity=with_row(STILL, 2, 1e160)), r"state.velocity: not finite or beyond \+-1e\+06 m/s in the rows \[2\]"),
    (dict(velocity=with_row(STILL, 2, np.nan)), r"state.velocity: not finite or beyond .* in the rows \[2\]"),
    (dict(history={"lag": STILL[1:]}), r"state.history/lag: the shape \(119, 3\) is not"),
    (
        dict(history={"lag": STILL + np.nan}),
        r"state.history/lag: not finite or beyond \+-1e\+06 m/s in the rows \[0, 1,",
    ),
    (
        dict(history={"tension": np.zeros(7)}),
        r"state.history/tension: the shape \(7,\) is not that of this cloth, \(\d+,\) or",
    ),
    (dict(history={"tension": np.full(len(MESH.spring_rest), np.inf)}), r"state.history/tension: not finite or beyond"),
    (dict(history={"past": STILL}), "state.history: 'past' is unknown; allowed are lag, tension"),
    (
        dict(grips={"hand": Grip(Pose(), True, np.array([120]), np.zeros((1, 3)))}),
        r"state.grips.hand: holds \[120\]; .* 0 to 119",
    ),
    (
        dict(grips={"hand": Grip(Pose(), True, np.array([4, 2]), np.zeros((2, 3)))}),
        r"hand: holds \[4, 2\]; .* rising order",
    ),
    (dict(grips={"hand": Grip(Pose(), True, np.array([0.5]), np.zeros((1, 3)))}), r"state.grips.hand: holds \[0.5\]"),
    (
        dict(grips={"hand": Grip(Pose(), True, np.array([4]), np.zeros((2, 3)))}),
        r"its offsets, of the shape \(2, 3\), are not",
    ),
    (
        dict(grips={"hand": Grip(Pose(), True, np.array([4]), np.full((1, 3), np.nan))}),
        "its offsets, .* are not rows of",
    ),
    (dict(time=np.nan), "state: step 1 at nan s; allowed are"),
]


@pytest.mark.parametrize(("changes", "words"), BAD_STATES)
def test_a_state_that_cannot_be_is_refused_with_what_of_it_and_the_bound(changes, words):
    solver, state = ClothSolver(MESH), state_with(**changes)
    with pytest.raises(InputError, match=words):
        solver.step(state, Inputs())
    if "velocity" in changes or "position" in changes:
        return  # snapshots of these are of another cloth, or cannot be taken
    with pytest.raises(InputError, match=words):
        solver.restore({**solver.snapshot(state)})


@pytest.mark.parametrize(("state", "inputs"), [(None, Inputs()), (REST, Inputs()), ("good", None), ("good", {})])
def test_a_step_wants_a_state_and_inputs(state, inputs):
    solver = ClothSolver(MESH)
    state = solver.initial_state() if isinstance(state, str) else state
    with pytest.raises(
        InputError, match=r"is not of the type (State; begin with initial_state|Inputs; write Inputs\()"
    ):
        solver.step(state, inputs)


@BOTH
@pytest.mark.parametrize("size", [1.0, 0.5])
def test_any_state_within_the_bounds_can_be_stepped_and_gives_one(integrator, size):
    """Vertices strewn over the whole space that there is, as fast as any may be."""
    solver = ClothSolver(MESH, config=SolverConfig(integrator=integrator))
    random = np.random.default_rng(3)
    strewn = random.uniform(-size, size, (2, *REST.shape)) * np.array([FARTHEST, FASTEST])[:, None, None]
    state = State(*strewn)
    for _ in range(4):
        state = solver.step(state, Inputs())


def test_a_cloth_that_leaves_all_bounds_is_put_to_rest_where_it_was():
    solver = ClothSolver(MESH)
    place = REST + np.array([FARTHEST - 1.0, 0.0, 0.0])
    speed = np.tile([1000.0, 0.0, 0.0], (len(REST), 1))
    state = solver.step(State(place, speed), Inputs())
    assert solver.report.recovered
    np.testing.assert_array_equal(state.position, place)
    np.testing.assert_array_equal(state.velocity, 0.0)
    solver.step(state, Inputs())
    assert not solver.report.recovered


@pytest.mark.parametrize("limited", [True, False])
def test_what_has_no_limited_spring_is_not_stretched(limited):
    place = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    springs = np.zeros((0, 2), int) if limited else [[0, 1]]
    loose = ClothMesh.from_springs(place, springs, stiffness=100.0, mass=0.1, limited=limited)
    solver = ClothSolver(loose)
    solver.step(solver.initial_state(), Inputs())
    assert solver.report.max_stretch == 1.0


def test_a_mesh_with_massless_vertices_is_refused_before_anything_is_computed():
    mesh = ClothMesh.grid(width=1, height=1, columns=3, rows=3)
    fields = {name: getattr(mesh, name) for name in mesh.__dataclass_fields__}
    bare = ClothMesh(**{**fields, "vertex_area": np.where(np.arange(9) == 4, 0.0, mesh.vertex_area)})
    with pytest.raises(MeshError, match=r"vertices \[4\] have no mass"):
        ClothSolver(bare)


def test_the_quick_start_of_the_readme_runs(capsys):
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    names: dict = {}
    exec(compile(code, "README.md", "exec"), names)
    state, solver = names["state"], names["solver"]
    assert capsys.readouterr().out.startswith("(2500, 3) 1.")
    assert 1.0 < solver.report.max_stretch < 1.2
    assert state.time == pytest.approx(4.0)
    assert -1.1 < state.position[:, 2].min() < -0.4
    assert np.linalg.norm(state.position - [0.0, 0.0, -0.5], axis=1).min() > 0.3


def test_a_grasp_that_closes_on_nothing_is_reported_once():
    solver = busy_solver("implicit_midpoint")
    state = solver.initial_state()
    far = Inputs(grasps={"hand": Grasp(pose=Pose((9.0, 9.0, 9.0)), closure=1.0)})
    said = []
    for _ in range(3):
        state = solver.step(state, far)
        said.append(solver.report.empty)
    assert said == [("hand",), (), ()]


@pytest.mark.parametrize("vertices", [[-1], [10**6], [1.7], [True, False], [float("nan")], ["top"]], ids=str)
def test_pins_are_numbers_of_vertices(vertices):
    solver = busy_solver("implicit_midpoint")
    before, snapshot = solver.pinned.copy(), solver.snapshot(solver.initial_state())
    for refused in (solver.pin, solver.unpin, lambda pins: solver.restore({**snapshot, "pinned": np.array(pins)})):
        with pytest.raises(MeshError, match="vertices are whole numbers from 0 to"):
            refused(vertices)
        np.testing.assert_array_equal(solver.pinned, before)


@pytest.mark.parametrize("count", [-1, 0, 1.5, "a"])
def test_sweeps_to_repeat_are_counts(count):
    solver = busy_solver("implicit_midpoint")
    with pytest.raises(InputError, match="sweep counts"):
        solver.step(solver.initial_state(), Inputs(), sweeps=[count] * solver.substeps)


@pytest.mark.parametrize("ratio", [10.0, 100.0])
def test_a_grid_hangs_however_stiff_its_shear(ratio):
    """Where springs along the diagonals would do nearly all, triangles take over."""
    material = Material(stretch_warp=500.0, stretch_weft=500.0, shear=ratio * 500.0, damping=2.0)
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=12, rows=12)
    solver = ClothSolver(mesh, material)
    solver.pin([0])
    state = solver.initial_state()
    for _ in range(150):
        state = solver.step(state, Inputs())
        assert solver.report.restrained == 0
    assert state.position[:, 2].min() < -1.2
