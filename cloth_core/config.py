"""How the cloth is computed: step, integrator, iterations, and the speeds that keep a user from breaking it."""

from __future__ import annotations

from dataclasses import dataclass

from cloth_core.settings import Settings, setting

INTEGRATORS = ("implicit_midpoint", "meyer2000")


@dataclass(frozen=True, slots=True, kw_only=True)
class SolverConfig(Settings):
    """Numerical settings of :class:`~cloth_core.solver.ClothSolver`.

    Zero for ``substeps``, ``iterations`` or ``stretch_sweeps`` means the integrator's own choice.
    """

    dt: float = setting("float", 0.02, unit="s", low=1e-3, high=0.1, help="time that one step advances")
    integrator: str = setting(
        "str",
        "implicit_midpoint",
        choices=INTEGRATORS,
        help="implicit_midpoint: second order, local/global on W; meyer2000: the paper's step",
    )
    substeps: int = setting(
        "int",
        0,
        low=0,
        high=200,
        help="substeps in a step; 0: the integrator's own (implicit_midpoint: one for every 2.5 ms)",
    )
    iterations: int = setting("int", 0, low=0, high=200, help="solves with W in a substep; 0: the integrator's own")
    stretch_sweeps: int = setting(
        "int", 0, low=0, high=500, help="passes over the overlong springs in a substep; 0: the integrator's own"
    )
    contact_shell: float = setting(
        "float",
        0.005,
        unit="m",
        low=1e-4,
        high=0.1,
        help="distance that the cloth keeps from obstacles (the paper's epsilon)",
    )
    dense_limit: int = setting(
        "int", 150, low=0, high=5000, help="vertices up to which W is stored as a dense inverse; above, a sparse factor"
    )
    max_grasp_speed: float = setting(
        "float", 10.0, unit="m/s", low=0.01, high=100.0, help="fastest that a gripper or a moved group is followed"
    )
    max_grasp_turn: float = setting(
        "float", 20.0, unit="rad/s", low=0.01, high=1000.0, help="fastest that the rotation of either is followed"
    )
    max_grasp_force: float = setting(
        "float",
        100.0,
        unit="N",
        low=0.1,
        high=1e4,
        help="most that a gripper bears, as a mean of 0.2 s: the cloth slips out of it otherwise; "
        "in a jerk it pulls with no more, and stays behind (implicit_midpoint only)",
    )
    max_push_speed: float = setting(
        "float", 2.0, unit="m/s", low=0.01, high=100.0, help="fastest that a contact pushes out what is already inside"
    )
    max_obstacle_speed: float = setting(
        "float",
        10.0,
        unit="m/s",
        low=0.01,
        high=1000.0,
        help="an obstacle that moves faster is teleported: it drags nothing along",
    )
    self_collision: bool = setting(
        "bool", False, help="whether the cloth, and the pieces of it, collide with each other"
    )
    max_wind_speed: float = setting("float", 40.0, unit="m/s", low=0.0, high=200.0, help="wind above this is capped")
    air_density: float = setting(
        "float", 1.2, unit="kg/m^3", low=0.0, high=2000.0, help="density of the medium around the cloth"
    )
