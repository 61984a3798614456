"""Laws of what flows about the cloth: shelter from the wind, drag and lift in water."""

from __future__ import annotations

import math

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.fluids import Fluid
from cloth_core.inputs import Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Box, Plane
from cloth_core.pose import Pose
from cloth_core.solver import ClothSolver
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import GRAVITY, fine, last

WIDTH = 0.4
"""m, edge of the box that keeps the wind off."""


def _share_of_drag(integrator: str, behind: float, aside: float) -> float:
    """Push of a wind on a sheet of half a box's width, face-on, as a share of that without the box.

    The sheet is ``behind`` m from the back of the box, and ``aside`` m from the line through its middle.
    """
    mesh, wind = ClothMesh.grid(width=0.5 * WIDTH, height=0.5 * WIDTH, columns=9, rows=9), Wind(velocity=(5.0, 0, 0))
    upright = Pose((0.5 * WIDTH + behind, aside, 0.0), (0.0, 0.5**0.5, 0.0, 0.5**0.5))
    speeds = []
    for obstacles in ({"box": Box(extents=(WIDTH, WIDTH, WIDTH))}, {}):
        solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator, dt=0.005), obstacles=obstacles)
        pushed = solver.step(solver.initial_state(upright), Inputs(wind=wind, gravity=(0.0, 0.0, 0.0)))
        speeds.append(float(np.mean(pushed.velocity[:, 0])))
    return speeds[0] / speeds[1]


def wind_shadow(integrator: str) -> Measurement:
    """One width behind a box the wind drags at a cloth with less than 5 % of its force."""
    return Measurement(0.0, _share_of_drag(integrator, WIDTH, 0.0), 0.05)


def wind_beside(integrator: str) -> Measurement:
    """One width to the side of a box, and of the place in its shadow, the wind drags with more than 90 %."""
    return Measurement(1.0, min(_share_of_drag(integrator, behind, WIDTH) for behind in (-0.5 * WIDTH, WIDTH)), 0.1)


def _sheet(integrator: str, **fabric: float) -> ClothSolver:
    return ClothSolver(ClothMesh.grid(width=0.5, height=0.5, columns=6, rows=6), Material(**fabric), fine(integrator))


def sinking_speed(integrator: str) -> Measurement:
    """In still water a sheet sinks face-on with sqrt((sigma - rho t) g / C), C = rho C_D / 2.

    sigma is its areal density and t its thickness, whose volume lifts it.
    """
    solver, rho = _sheet(integrator, areal_density=1.0), 1000.0
    sea = {"sea": Fluid(shape=Plane(center=(0.0, 0.0, 50.0)), density=rho)}
    sunk = last(solver, solver.initial_state(), Inputs(fluids=sea), 2.0)
    fabric = solver.material
    weight = (fabric.areal_density - rho * fabric.thickness) * GRAVITY
    expected = math.sqrt(weight / (0.5 * rho * fabric.drag))
    return Measurement(expected, float(-sunk.velocity[:, 2].mean()), 1e-9, "m/s")


def floating_depth(integrator: str) -> Measurement:
    """On water floats a sheet whose wet part, sigma / rho of the thickness t, displaces its weight (Archimedes).

    Its middle is then t / 2 - sigma / rho above the surface. It is let go 3 cm above.
    """
    solver, rho = _sheet(integrator), 1000.0
    floating = last(
        solver, solver.initial_state(Pose((0.0, 0.0, 0.03))), Inputs(fluids={"sea": Fluid(shape=Plane())}), 3.0
    )
    fabric = solver.material
    expected = 0.5 * fabric.thickness - fabric.areal_density / rho
    return Measurement(expected, float(floating.position[:, 2].mean()), 1e-3, "m")


def carried_along(integrator: str) -> Measurement:
    """A sheet along a stream w takes its speed: after t it lags by w / (1 + w k t / sigma), k = rho C / 2.

    sigma is its areal density and C the drag coefficient along it.
    """
    solver, speed, duration, rho = _sheet(integrator), 0.5, 2.0, 1000.0
    river = Fluid(shape=Plane(center=(0.0, 0.0, 1.0)), velocity=(speed, 0.0, 0.0), density=rho)
    inputs = Inputs(fluids={"river": river}, gravity=(0.0, 0.0, 0.0))
    carried = last(solver, solver.initial_state(), inputs, duration)
    rate = 0.5 * rho * river.skin_drag / solver.material.areal_density
    expected = speed - speed / (1.0 + speed * rate * duration)
    return Measurement(expected, float(carried.velocity[:, 0].mean()), 2e-3, "m/s")


LAWS = (
    Law("wind shadow", wind_shadow),
    Law("wind beside", wind_beside),
    Law("sinking speed", sinking_speed),
    Law("floating depth", floating_depth),
    Law("carried along", carried_along),
)
