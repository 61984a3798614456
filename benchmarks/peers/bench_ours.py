"""The solver of this package, used as any user would.

Variants: ``default``, the solver's own integrator; ``meyer2000``, the paper's. Obstacles have the radius of the scene,
so that the contact shell (5 mm) shows as a gap. No other engine has air, so there is none here either: in air the
cloth would fall more slowly than the free fall that the quality gate asks for.
"""

from __future__ import annotations

from dataclasses import replace
from importlib import metadata
from typing import Any

import common
import numpy as np
from workload import AREAL_DENSITY, FRICTION, SPHERE_CENTER, SPHERE_RADIUS, Scene

STRETCH_LIMIT = 1.03


class Engine:
    """Hanging corners are pinned; the dragged one is in a hand that holds it alone."""

    name = "ours"
    variants = ("default", "meyer2000")

    @staticmethod
    def collides_with_itself(variant: str) -> bool:
        """Not yet."""
        return False

    @staticmethod
    def settings(n: int, scenario: str, variant: str) -> dict[str, Any]:
        """None: zero leaves the choice to the solver."""
        return dict(substeps=0, iters=0)

    @staticmethod
    def load() -> None:
        """Import the solver."""
        global core, obstacles
        import cloth_core as core
        from cloth_core import obstacles

    @staticmethod
    def version() -> str:
        """Of the package, and of what compiles its kernels."""
        return f"cloth_sim_ros {metadata.version('cloth_sim_ros')} numba {metadata.version('numba')}"

    def __init__(self, scene: Scene, settings: dict[str, Any], variant: str) -> None:
        self.scene, self.frame = scene, 0
        mesh = core.ClothMesh.grid(width=1.0, height=1.0, columns=scene.n, rows=scene.n)
        self.solver = core.ClothSolver(
            mesh, _material(settings["stiffness"]), _config(scene, settings, variant), obstacles=_obstacles(scene)
        )
        if scene.name == "hang":
            self.solver.pin([_number(vertex, scene.n) for vertex in scene.held])
        self.state = self.solver.initial_state(core.Pose(tuple(scene.start.mean(axis=0))))
        self.hand: core.Grasp | None = None
        if scene.name == "drag":
            self._take(scene.held[0])
        self.solver.prepare(self.state)

    def _take(self, vertex: int) -> None:
        """Put the vertex into the hand before the clock starts: at its first target the hand is 20 mm away."""
        pose = core.Pose(tuple(self.scene.start[vertex]))
        self.hand = core.Grasp(pose=pose, closure=1.0, radius=0.25 * self.scene.spacing)
        held = np.array([_number(vertex, self.scene.n)], np.int32)
        grip = core.Grip(pose, closed=True, vertex=held, offset=np.zeros((1, 3)))
        self.state = replace(self.state, grips={"hand": grip})

    def step(self, targets: np.ndarray | None) -> None:
        """Move hand and ball, advance."""
        self.frame += 1
        inputs = core.Inputs(grasps=self._grasps(targets), obstacles=self._poses())
        self.state = self.solver.step(self.state, inputs)

    def _grasps(self, targets: np.ndarray | None) -> dict[str, Any]:
        if self.hand is None:
            return {}
        try:
            self.hand = replace(self.hand, pose=core.Pose(tuple(targets[0])))
        except core.InputError as refused:  # a NaN: the hand stays where it was last
            self.note = str(refused)
        return {"hand": self.hand}

    def _poses(self) -> dict[str, Any]:
        if not self.scene.spin:
            return {}
        half = 0.5 * self.scene.spin * self.frame * self.scene.frame_dt
        return {"ball": core.Pose(tuple(SPHERE_CENTER), (0.0, 0.0, np.sin(half), np.cos(half)))}

    def positions(self) -> np.ndarray:
        """As the solver numbers them, along x first."""
        return self.state.position


def _number(vertex: int, n: int) -> int:
    """Ours of the scene's: there columns come first, here rows."""
    column, row = divmod(vertex, n)
    return row * n + column


def _material(stiffness: float) -> Any:
    usual = core.Material()
    stiffer = {name: stiffness * getattr(usual, name) for name in ("stretch_warp", "stretch_weft", "shear", "bend")}
    return core.Material(areal_density=AREAL_DENSITY, friction=FRICTION, stretch_limit=STRETCH_LIMIT, **stiffer)


def _config(scene: Scene, settings: dict[str, Any], variant: str) -> Any:
    integrator = {} if variant == "default" else {"integrator": variant}
    return core.SolverConfig(
        dt=scene.frame_dt,
        substeps=settings["substeps"],
        iterations=settings["iters"],
        air_density=0.0,
        **integrator,
    )


def _obstacles(scene: Scene) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if scene.sphere:
        found["ball"] = obstacles.Sphere(radius=SPHERE_RADIUS, center=tuple(SPHERE_CENTER))
    if scene.ground:
        found["ground"] = obstacles.Plane()
    return found


if __name__ == "__main__":
    common.run(Engine)
