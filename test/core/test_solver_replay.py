"""The same bits again: from the same inputs, from a snapshot, from a log."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from busy import OBSTACLES, assert_same, busy_inputs, busy_solver, played

from cloth_core import (
    ClothMesh,
    ClothSolver,
    Grasp,
    InputError,
    Inputs,
    MeshError,
    Pose,
    State,
    Wind,
)

BOTH = pytest.mark.parametrize("integrator", ["implicit_midpoint", "meyer2000"])


@BOTH
@pytest.mark.parametrize("dense_limit", [0, 5000])
def test_the_same_inputs_give_the_same_bits(integrator, dense_limit):
    one, other = (busy_solver(integrator, dense_limit=dense_limit) for _ in range(2))
    assert_same(played(one, one.initial_state(), 0, 30), played(other, other.initial_state(), 0, 30))


@BOTH
def test_a_used_solver_gives_the_same_bits_as_a_fresh_one(integrator):
    used, fresh = busy_solver(integrator), busy_solver(integrator)
    played(used, used.initial_state(), 0, 12)
    used.prepare()
    assert_same(played(used, used.initial_state(), 0, 30), played(fresh, fresh.initial_state(), 0, 30))


@BOTH
def test_a_step_leaves_its_arguments_untouched(integrator):
    solver = busy_solver(integrator)
    state = played(solver, solver.initial_state(), 0, 10)
    copy, inputs = State.from_arrays({k: v.copy() for k, v in state.as_arrays().items()}), busy_inputs(10)
    mapping = json.dumps(inputs.as_mapping())
    state.position.setflags(write=False)
    state.velocity.setflags(write=False)
    solver.step(state, inputs)
    assert_same(state, copy)
    assert json.dumps(inputs.as_mapping()) == mapping


THREADS = """
import numpy as np
from cloth_core import *
from cloth_core.obstacles import Sphere
for size, reach, shear in ((12, 0.2, 50), (32, 0.5, 50), (50, 0.2, 50), (50, 0.2, 50_000)):
    mesh = ClothMesh.grid(width=1.0, height=1.0, columns=size, rows=size)
    obstacles = {"ball": Sphere(radius=0.2, center=(0.0, 0.0, -0.21))}
    solver = ClothSolver(mesh, Material(shear=shear), obstacles=obstacles)
    assert mesh.is_membrane(solver.material) is (shear > 1000)
    solver.pin(mesh.group("corners")[:2])
    state = solver.initial_state()
    for n in range(12):
        hand = Grasp(pose=Pose((-0.5, -0.5, 0.01 * n)), closure=1.0, radius=reach)
        state = solver.step(state, Inputs(grasps={"hand": hand} if n > 2 else {}))
    print(solver.representation, state.digest)
"""


def test_the_number_of_threads_changes_no_bit():
    """With the dense inverse, with the sparse factor, with many vertices in the hand, and where threads share loops."""
    printed = []
    for threads in ("1", "2"):
        settings = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), threads)
        path = os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
        run = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(THREADS)],
            env={**os.environ, **settings, "PYTHONPATH": path}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        printed.append(run.stdout)
    assert printed[0] == printed[1]
    assert printed[0].startswith("dense")


@BOTH
@pytest.mark.parametrize("at", [2, 10, 20])
def test_a_snapshot_continues_bit_equal_through_a_file(integrator, at):
    solver = busy_solver(integrator)
    state = played(solver, solver.initial_state(), 0, at)
    file = io.BytesIO()
    np.savez(file, **solver.snapshot(state))
    straight = played(solver, state, at, 30)
    file.seek(0)
    other = ClothSolver(solver.mesh, solver.material, solver.config, obstacles=OBSTACLES)
    with np.load(file) as arrays:
        restored = other.restore(arrays)
    assert_same(restored, state)
    np.testing.assert_array_equal(other.pinned, solver.pinned)
    assert_same(played(other, restored, at, 30), straight)


def test_a_snapshot_of_another_cloth_is_refused():
    small = ClothSolver(ClothMesh.grid(width=1, height=1, columns=3, rows=3))
    with pytest.raises(MeshError, match="9 vertices, this cloth 120"):
        busy_solver("meyer2000").restore(small.snapshot(small.initial_state()))


def grasping_snapshot() -> tuple[ClothSolver, dict[str, np.ndarray]]:
    """Of a solver with pins, obstacles and a closed hand, in the middle of a run."""
    solver = busy_solver("implicit_midpoint")
    state = played(solver, solver.initial_state(), 0, 12)
    assert any(len(grip.vertex) for grip in state.grips.values())
    return solver, solver.snapshot(state)


def test_whatever_is_missing_from_a_snapshot_is_named_and_the_solver_stays_as_it_is():
    solver, whole = grasping_snapshot()
    other = busy_solver("implicit_midpoint")
    other.unpin()
    for name in whole:
        with pytest.raises(InputError, match=f"^{re.escape(name)}: missing; there are "):
            other.restore({key: array for key, array in whole.items() if key != name})
        assert len(other.pinned) == 0
    assert_same(other.restore(whole), solver.restore(whole))


def changed_rest(arrays, **changes):
    rest = json.loads(bytes(arrays["rest"]))
    return np.frombuffer(json.dumps({**rest, **changes}).encode(), np.uint8)


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda a: {"rest": a["rest"][:-5]}, "rest: is not the JSON text of step"),
        (lambda a: {"rest": np.frombuffer(b"[1, 2]", np.uint8)}, "rest: is not the JSON text"),
        (lambda a: {"rest": np.frombuffer(b"{}", np.uint8)}, "rest: is not the JSON text .*KeyError"),
        (lambda a: {"rest": changed_rest(a, time=None)}, "rest: is not the JSON text"),
        (lambda a: {"rest": changed_rest(a, time=float("nan"))}, "state: step 12 at nan s"),
        (lambda a: {"rest": changed_rest(a, step_index=-3)}, "state: step -3 at"),
        (lambda a: {"rest": changed_rest(a, obstacles={"ball": [0.0] * 7})}, "orientation .* is not a quaternion"),
        (lambda a: {"rest": changed_rest(a, obstacles={"ball": 1})}, "rest: is not the JSON text"),
        (lambda a: {"rest": changed_rest(a, obstacles={})}, "the state does not say where ball, floor stands"),
        (lambda a: {"rest": changed_rest(a, grips={"hand": [[0.0] * 3, True]})}, "rest: is not the JSON text"),
        (
            lambda a: {"rest": changed_rest(a, grips={"left": [[0, 0, 0, 0, 0, 0, 1], True, [0, 0, 0]]})},
            "grip_vertex/left: missing",
        ),
        (lambda a: {"history/lag": a["history/lag"] * np.nan}, "state.history/lag: not finite"),
        (lambda a: {"history/lag": a["history/lag"][:, :2]}, r"state.history/lag: the shape \(120, 2\)"),
        (lambda a: {"history/tension": a["history/tension"][1:]}, "state.history/tension: the shape"),
        (lambda a: {"position": a["position"] * 1e160}, r"state.position: not finite or beyond \+-1e\+07 m"),
        (lambda a: {"position": np.array(["a"])}, "position: is not an array of numbers"),
        (lambda a: {"velocity": a["velocity"][1:]}, r"state.velocity: the shape \(119, 3\)"),
        (lambda a: {"velocity": None}, "velocity"),
    ],
)
def test_a_damaged_snapshot_is_refused_by_name_and_the_solver_stays_as_it_is(damage, words):
    solver, whole = grasping_snapshot()
    pinned = solver.pinned
    with pytest.raises(InputError, match=words):
        solver.restore({**whole, **damage(whole)})
    assert solver.pinned is pinned


def test_what_is_no_snapshot_at_all_is_refused():
    with pytest.raises(InputError, match="None is not a mapping from names to arrays, as snapshot"):
        busy_solver("implicit_midpoint").restore(None)


def test_a_file_of_arrays_that_was_overwritten_in_the_middle_is_refused_by_the_array():
    solver, whole = grasping_snapshot()
    file = io.BytesIO()
    np.savez(file, **whole)
    content = bytearray(file.getvalue())
    at = content.index(whole["velocity"].tobytes()[:64])
    content[at : at + 64] = bytes(64)
    with np.load(io.BytesIO(bytes(content))) as arrays, pytest.raises(InputError, match=r"^velocity: cannot be read: "):
        solver.restore(arrays)


@BOTH
def test_a_run_that_was_short_of_time_is_repeated_bit_for_bit(integrator):
    """The clock says stop at odd moments; the recorded sweeps alone give the same states."""
    hurried, forced, free = (busy_solver(integrator, substeps=4, stretch_sweeps=8) for _ in range(3))
    state = start = hurried.initial_state()
    recorded, states, late = [], [], []
    for n in range(25):
        asked = iter(range(100))
        state = hurried.step(state, busy_inputs(n), out_of_time=lambda n=n, asked=asked: next(asked) >= n % 4)
        recorded.append(hurried.report.sweeps)
        late.append(hurried.report.out_of_time)
        states.append(state)
    assert 5 < sum(late) < 25
    again = start
    for n, sweeps in enumerate(recorded):
        again = forced.step(again, busy_inputs(n), sweeps=sweeps)
        assert_same(again, states[n])
    assert played(free, start, 0, 25).digest != again.digest


def test_inputs_survive_json_bit_for_bit():
    random = np.random.default_rng(2)
    for _ in range(20):
        pose = lambda: Pose(tuple(random.normal(size=3)), tuple(random.normal(size=4)))  # noqa: E731
        inputs = Inputs(
            grasps={
                name: Grasp(pose=pose(), closure=random.random(), radius=0.01 + random.random() / 2)
                for name in ("a", "b")
            },
            wind=Wind(
                velocity=tuple(random.normal(size=3)),
                gust_intensity=random.random(),
                gust_seed=int(random.integers(9e8)),
            ),
            obstacles={"ball": pose()},
            gravity=tuple(random.normal(size=3)),
        )
        assert Inputs.from_mapping(json.loads(json.dumps(inputs.as_mapping()))) == inputs
