"""After prepare() nothing is compiled or loaded any more, whatever happens."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from cloth_core import ClothSolver
from cloth_core.rehearsal import ACTS, Kind, rehearse

KINDS = [
    Kind(integrator, cloth, single)
    for integrator in ("implicit_midpoint", "meyer2000")
    for cloth in ("grid", "sheet", "net")
    for single in (False, True)
] + [Kind(integrator, "grid", False, fields=True) for integrator in ("implicit_midpoint", "meyer2000")]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_everything_that_can_happen_happens_in_a_rehearsal(kind):
    reports = rehearse(kind, ClothSolver)
    assert len(reports) == len(ACTS)
    for event in ("contacts", "slowed", "taut", "slipped"):
        assert any(getattr(report, event) for report in reports), event
    assert any(report.restrained for report in reports) == (kind.integrator == "implicit_midpoint")
    held = [report.held for report in reports]
    assert max(held) > held[0] == held[-1] == 2  # pinned
    assert not any(report.recovered for report in reports)


PLAY = """
import importlib
import pkgutil
import sys

import numpy as np
from numba.core.dispatcher import Dispatcher

from cloth_core import ClothMesh, ClothSolver, Grasp, Inputs, Material, Pose, SolverConfig, Wind, kernels
from cloth_core.fields import Compound
from cloth_core.obstacles import Box, Plane, Sphere

shape, integrator, dense_limit, fields = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4] == "True"
mesh = ClothMesh.grid(width=0.5, height=0.5, columns=24, rows=24)
if shape == "sheet":
    place = mesh.rest_position.copy()
    place[:, 2] = 0.1 * np.cos(6.0 * place[:, 0])
    mesh = ClothMesh.from_triangles(place, mesh.triangles)
elif shape == "net":
    mesh = ClothMesh.from_springs(mesh.rest_position, mesh.spring_vertex, stiffness=300.0, mass=1e-4)
around = {"ball": Sphere(radius=0.1, center=(0.1, 0.0, -0.1)), "box": Box(extents=(0.1, 0.1, 0.1)), "z": Plane()}
if fields:
    around = {"ball": Compound(parts={"ball": around["ball"]}, voxel=0.02), "box": around["box"]}
solver = ClothSolver(
    mesh, Material(), SolverConfig(integrator=integrator, dense_limit=dense_limit), obstacles=around
)
solver.pin([0])
dispatchers = [
    each
    for module in pkgutil.iter_modules(kernels.__path__)
    for each in vars(importlib.import_module(f"cloth_core.kernels.{module.name}")).values()
    if isinstance(each, Dispatcher)
]


def known():
    return {f"{each.py_func.__module__}.{each.py_func.__name__}": list(each.signatures) for each in dispatchers}


nothing = known()
solver.prepare()
before = known()
assert sum(map(len, nothing.values())) == 0 < sum(map(len, before.values()))

state, seen = solver.initial_state(), set()
state.position.setflags(write=False)
for n in range(45):
    away = 0.1 * max(0, n - 8)
    hands = {
        name: Grasp(pose=Pose((x + way * away, 0.25, 0.0)), closure=float(2 <= n < 35), radius=0.06, slip_distance=slip)
        for name, x, way, slip in (("left", -0.25, -1.0, 0.2), ("right", 0.25, 1.0, 9.0))
    }
    wind = Wind(velocity=(3.0, 1.0, 0.5), gust_intensity=0.4 * (n > 4))
    ball = Pose((0.1, 0.01 * n, 0.01 * n - 0.1))
    state = solver.step(state, Inputs(grasps=hands, wind=wind, obstacles={"ball": ball}))
    report = solver.report
    seen |= {what for what in ("contacts", "slowed", "taut", "slipped", "restrained") if getattr(report, what)}
grown = {name: signatures for name, signatures in known().items() if signatures != before[name]}
assert not grown, grown
print(*sorted(seen))
"""


@pytest.mark.parametrize(
    ("shape", "integrator", "dense_limit", "fields"),
    [
        ("grid", "implicit_midpoint", 0, False),
        ("grid", "implicit_midpoint", 5000, False),  # one block, large enough for single precision
        ("grid", "implicit_midpoint", 0, True),
        ("sheet", "implicit_midpoint", 0, False),
        ("net", "implicit_midpoint", 0, False),
        ("grid", "meyer2000", 0, False),
        ("sheet", "meyer2000", 5000, False),
    ],
)
def test_no_kernel_is_compiled_or_loaded_after_prepare(shape, integrator, dense_limit, fields):
    run = subprocess.run(
        [sys.executable, "-c", PLAY, shape, integrator, str(dense_limit), str(fields)],
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[2],
        env=dict(os.environ),
    )
    assert run.returncode == 0, run.stderr
    restrained = {"restrained"} if integrator == "implicit_midpoint" else set()
    assert set(run.stdout.split()) == {"contacts", "slowed", "taut", "slipped"} | restrained
