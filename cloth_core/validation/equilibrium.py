"""Laws of rest: what hangs, what blows in a steady wind, what falls at a steady speed."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from cloth_core.config import SolverConfig
from cloth_core.inputs import Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.solver import ClothSolver
from cloth_core.validation.law import Law, Measurement
from cloth_core.validation.scenes import GRAVITY, UNLIMITED, fine, hanging_strip, last

WIND_ALONE = "eq. (5) takes the wind alone, not the velocity relative to it: still air does not brake a falling sheet"


def hanging_chain(integrator: str) -> Measurement:
    """n links of stiffness k with a mass m below each lengthen by (m g / k) n (n + 1) / 2."""
    links, mass, stiffness = 10, 0.2 / 11, 100.0
    down = np.stack([np.zeros(links + 1), np.zeros(links + 1), -0.1 * np.arange(links + 1.0)], axis=1)
    pairs = np.stack([np.arange(links), np.arange(1, links + 1)], axis=1)
    chain = ClothMesh.from_springs(down, pairs, stiffness=stiffness, mass=mass, limited=False)
    solver = ClothSolver(chain, Material(damping=4.0), fine(integrator))
    solver.pin([0])
    hung = last(solver, solver.initial_state(), Inputs(), 8.0)
    expected = mass * GRAVITY / stiffness * links * (links + 1) / 2
    return Measurement(expected, float(-1.0 - hung.position[-1, 2]), 1e-6, "m")


def catenary(integrator: str) -> Measurement:
    """A strip of length S between points d apart sags by a (cosh(d / 2a) - 1), where S = 2 a sinh(d / 2a).

    Started as a V of the same length, not as the answer.
    """
    length, span, columns = 1.2, 1.0, 41
    mesh = ClothMesh.grid(width=length, height=0.06, columns=columns, rows=2)
    # The paper's viscosity is k dt: it creeps to rest within a few seconds only if dt is small.
    config = fine(integrator, iterations=20) if integrator == "implicit_midpoint" else fine(integrator, substeps=40)
    solver = ClothSolver(mesh, Material(bend=0.0, damping=4.0, shear=10.0, stretch_limit=UNLIMITED), config)
    solver.pin(np.concatenate([mesh.group("left"), mesh.group("right")]))
    start = solver.initial_state()
    along = start.position[:, 0] / length
    depth = 0.5 * math.sqrt(length**2 - span**2)
    start.position[:, 0] = span * along
    start.position[:, 2] = depth * (2 * np.abs(along) - 1)
    hung = last(solver, start, Inputs(), 4.0 if integrator == "implicit_midpoint" else 16.0)
    a = brentq(lambda a: 2 * a * math.sinh(span / (2 * a)) - length, 0.2, 10.0)
    return Measurement(a * (math.cosh(span / (2 * a)) - 1), float(-hung.position[:, 2].min()), 0.004, "m")


def wind_angle(integrator: str) -> Measurement:
    """A strip in a level wind v hangs at tan(angle) = C v^2 / (sigma g), C = rho C_D / 2.

    sigma is the areal density; both forces grow alike along the strip, so that it is straight.
    """
    speed, length = 2.0, 0.5
    mesh, top = hanging_strip(length, 11)
    # The angle does not depend on the stiffness; a soft strip settles sooner.
    soft = Material(bend=0.0, damping=4.0, stretch_warp=100.0, stretch_weft=100.0, shear=20.0, stretch_limit=UNLIMITED)
    solver = ClothSolver(mesh, soft, fine(integrator, air_density=1.2, iterations=20))
    solver.pin(top)
    blown = last(solver, solver.initial_state(), Inputs(wind=Wind(velocity=(speed, 0.0, 0.0))), 12.0)
    low = blown.position[mesh.rest_position[:, 2] < -0.99 * length].mean(axis=0)
    material = solver.material
    expected = 0.5 * 1.2 * material.drag * speed**2 / (material.areal_density * GRAVITY)
    # The paper's step creeps to rest, and is not quite there yet.
    return Measurement(expected, float(low[0] / -low[2]), 0.003 if integrator == "meyer2000" else 1e-6)


def terminal_speed(integrator: str) -> Measurement:
    """A sheet that falls face-on in still air ends at sqrt(sigma g / C), C = rho C_D / 2, sigma its density."""
    mesh = ClothMesh.grid(width=0.5, height=0.5, columns=6, rows=6)
    solver = ClothSolver(mesh, Material(), SolverConfig(integrator=integrator))
    fallen = last(solver, solver.initial_state(), Inputs(), 3.0)
    c = 0.5 * solver.config.air_density * solver.material.drag
    return Measurement(
        math.sqrt(solver.material.areal_density * GRAVITY / c), float(-fallen.velocity[:, 2].mean()), 1e-9, "m/s"
    )


LAWS = (
    Law("hanging chain", hanging_chain),
    Law("catenary", catenary),
    Law("wind angle", wind_angle),
    Law("terminal speed", terminal_speed, exempt={"meyer2000": WIND_ALONE}),
)
