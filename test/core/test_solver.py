"""The solver as a whole: where it stands does not matter, and bad input touches nothing."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from busy import assert_same, busy_inputs, busy_solver, played

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Grasp,
    InputError,
    Inputs,
    Material,
    MeshError,
    Pose,
    SolverConfig,
    State,
    Wind,
)
from cloth_core.obstacles import Box, Sphere

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
        ("not finite at vertices \\[7\\]", lambda: solver.step(broken, Inputs())),
        (
            "the state has 4 vertices, this cloth 120",
            lambda: solver.step(State(np.zeros((4, 3)), np.zeros((4, 3))), Inputs()),
        ),
        ("does not say where ball, floor stands", lambda: solver.step(State(state.position, state.velocity), Inputs())),
        ("cannot pin \\[120\\]: vertices are whole numbers from 0 to 119", lambda: solver.pin([120])),
    ):
        with pytest.raises((InputError, MeshError), match=message):
            attempt()
        assert solver.report is report
    assert_same(solver.step(state, busy_inputs(6)), expected)


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
