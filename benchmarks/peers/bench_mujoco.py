"""MuJoCo's flex cloth on the CPU.

Variants: ``elastic`` a St. Venant-Kirchhoff membrane with bending, integrator "discrete" and CG; ``edge`` edges as
equality constraints (its model/flex/flag.xml); ``ipc`` elastic with incremental potential contact; ``passive`` elastic
with frictionless passive contact (its model/flex/drape.xml).
"""

from __future__ import annotations

from typing import Any

import common
import numpy as np
from workload import FRICTION, SPHERE_CENTER, SPHERE_RADIUS, Scene

MODEL = """
<mujoco>
  <compiler autolimits="true" angle="degree"/>
  <option timestep="{dt}" solver="CG" tolerance="{tolerance}" iterations="{iterations}" integrator="{integrator}"
          gravity="0 0 -9.81">{ipc}</option>
  <size memory="2G"/>
  <worldbody>
    {ground}{sphere}
    <flexcomp type="grid" count="{n} {n} 1" spacing="{spacing} {spacing} {spacing}" pos="{center}" {tilt}
              radius="{radius}" mass="{mass}" name="cloth" dim="2">
      {contact}{material}{pins}
    </flexcomp>
  </worldbody>
</mujoco>
"""


class Engine:
    """E t = 2000 N/m."""

    name = "mujoco"
    variants = ("elastic", "edge", "passive", "ipc")

    @staticmethod
    def collides_with_itself(variant: str) -> bool:
        """It does."""
        return True

    @staticmethod
    def settings(n: int, scenario: str, variant: str) -> dict[str, Any]:
        """Edges need more substeps on a finer grid."""
        substeps = {"elastic": 1, "edge": max(5, round(0.35 * n)), "passive": 2, "ipc": 2}[variant]
        return dict(substeps=substeps, iters=20 if variant == "edge" else 100, young=2e6, thick=1e-3, tol=1e-6)

    @staticmethod
    def load() -> None:
        """Import the engine."""
        global mujoco
        import mujoco

    @staticmethod
    def version() -> str:
        """Of the engine."""
        return mujoco.__version__

    def __init__(self, scene: Scene, settings: dict[str, Any], variant: str) -> None:
        self.scene, self.substeps = scene, settings["substeps"]
        xml = model_xml(scene, settings, variant)
        self.model = self._with_driven_vertex(xml) if scene.name == "drag" else mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        if scene.spin:
            hinge = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, "spin")
            self.data.qvel[self.model.jnt_dofadr[hinge]] = scene.spin
        mujoco.mj_forward(self.model, self.data)

    def _with_driven_vertex(self, xml: str) -> Any:
        # Flexes with elasticity refuse to be attached to mocap bodies, and a connect equality is too soft for one
        # vertex of 8e-5 kg: the held vertex is made heavy, weightless, and is driven by its velocity.
        spec = mujoco.MjSpec.from_string(xml)
        body = spec.body(next(iter(spec.flexes[0].vertbody)))
        body.mass, body.gravcomp = 100.0, 1.0
        model = spec.compile()
        first = model.body_dofadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body.name)]
        self.driven = slice(first, first + 3)
        return model

    def step(self, targets: np.ndarray | None) -> None:
        """Drive the held vertex, advance, note the engine's warnings."""
        if self.scene.name == "drag":
            self.data.qvel[self.driven] = (targets[0] - self.data.flexvert_xpos[0]) / self.scene.frame_dt
        mujoco.mj_step(self.model, self.data, nstep=self.substeps)
        warnings = self.data.warning
        self.note = {mujoco.mjtWarning(i).name: int(w.number) for i, w in enumerate(warnings) if w.number}

    def positions(self) -> np.ndarray:
        """Brought up to date as a user must: mj_step leaves them at the start of its last step."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_flex(self.model, self.data)
        return self.data.flexvert_xpos


def model_xml(scene: Scene, settings: dict[str, Any], variant: str) -> str:
    """The scene in MuJoCo's modelling language."""
    dt = scene.frame_dt / settings["substeps"]
    pinned = " ".join(map(str, scene.held)) if scene.name == "hang" else ""
    return MODEL.format(
        dt=dt,
        tolerance=settings["tol"],
        iterations=settings["iters"],
        integrator="Euler" if variant == "edge" else "discrete",
        ipc='<flag ipc="enable"/>' if variant == "ipc" else "",
        ground=f'<geom type="plane" size="5 5 0.1" friction="{FRICTION}"/>' if scene.ground else "",
        sphere=_sphere(scene) if scene.sphere else "",
        n=scene.n,
        spacing=scene.spacing,
        center="{} {} {}".format(*scene.start.mean(axis=0)),
        tilt='euler="87 0 0"' if scene.name == "crumple" else "",
        radius=min(0.004, 0.4 * scene.spacing),
        mass=scene.mass,
        contact=_contact(scene, variant, dt),
        material=_material(settings, variant, dt),
        pins=f'<pin id="{pinned}"/>' if pinned else "",
    )


def _sphere(scene: Scene) -> str:
    hinge = '<joint name="spin" type="hinge" axis="0 0 1" damping="0"/>' if scene.spin else ""
    geometry = f'<geom type="sphere" size="{SPHERE_RADIUS}" mass="50" friction="{FRICTION}"/>'
    return '<body pos="{} {} {}">'.format(*SPHERE_CENTER) + f"{hinge}{geometry}</body>"


def _contact(scene: Scene, variant: str, dt: float) -> str:
    if not (scene.ground or scene.self_collision):
        return '<contact selfcollide="none" contype="0" conaffinity="0"/>'
    itself = "auto" if scene.self_collision else "none"
    passive = 'passive="true"' if variant == "passive" else ""
    solver = f'solref="{max(0.01, 2 * dt)} 1" solimp=".95 .99 .0001"'
    return f'<contact selfcollide="{itself}" friction="{FRICTION}" {passive} {solver}/>'


def _material(settings: dict[str, Any], variant: str, dt: float) -> str:
    if variant == "edge":
        return f'<edge equality="true" damping="0.0001" solref="{2 * dt} 1"/>'
    young = settings["young"] * settings["stiffness"]
    sheet = f'young="{young}" poisson="0.2" thickness="{settings["thick"]}"'
    return f'<elasticity {sheet} elastic2d="both" damping="1e-3"/>'


if __name__ == "__main__":
    common.run(Engine)
