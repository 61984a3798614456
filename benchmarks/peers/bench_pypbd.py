"""PositionBasedDynamics (Bender et al.; C++ and OpenMP) through its Python bindings.

Variants: ``xpbd`` distance XPBD; ``fem`` triangle PBD, the default of its examples; ``pbd`` distance PBD.
"""

from __future__ import annotations

import math
import tempfile
from importlib import metadata
from typing import Any

import common
import numpy as np
from workload import FRICTION, SPHERE_CENTER, SPHERE_RADIUS, Scene

CLOTH_METHOD = {"fem": 2, "pbd": 1, "xpbd": 4}
ISOMETRIC, XPBD_ISOMETRIC = 2, 3  # its bending methods
CONTACT_TOLERANCE = 0.005  # m
STILL = 0.0  # mass of what does not move
GROUND = [10.0, 1.0, 10.0]  # m


class Engine:
    """Its y axis points up: the bindings offer gravity along -y alone."""

    name = "pypbd"
    variants = ("xpbd", "fem", "pbd")

    @staticmethod
    def collides_with_itself(variant: str) -> bool:
        """It does not."""
        return False

    @staticmethod
    def settings(n: int, scenario: str, variant: str) -> dict[str, Any]:
        """Four steps of 5 ms (its default) a frame, collision detection once a step."""
        return dict(substeps=int(np.ceil(0.9 * n / 4)), iters=1, steps=4)

    @staticmethod
    def load() -> None:
        """Import the bindings."""
        global pbd
        import pypbd as pbd

    @staticmethod
    def version() -> str:
        """Of the package."""
        return metadata.version("pypbd")

    def __init__(self, scene: Scene, settings: dict[str, Any], variant: str) -> None:
        self.scene, self.steps = scene, settings.get("steps", 1)
        simulation = pbd.Simulation.getCurrent()
        simulation.initDefault()
        self.model = simulation.getModel()
        self.stepper = simulation.getTimeStep()
        self._add_cloth(settings, variant)
        detection = self.stepper.getCollisionDetection()
        if scene.sphere:
            self._add_sphere(detection)
        if scene.ground:
            self._add_ground(detection)
        if scene.sphere or scene.ground:
            detection.setTolerance(CONTACT_TOLERANCE)
        self.stepper.setValueUInt(pbd.TimeStepController.NUM_SUB_STEPS, settings["substeps"])
        self.stepper.setValueUInt(pbd.TimeStepController.MAX_ITERATIONS, settings["iters"])
        pbd.TimeManager.getCurrent().setTimeStepSize(scene.frame_dt / self.steps)

    def _add_cloth(self, settings: dict[str, Any], variant: str) -> None:
        scene, model = self.scene, self.model
        faces = scene.triangles.astype(np.uint32).reshape(-1)
        cloth = model.addTriangleModel(y_up(scene.start), faces, testMesh=scene.sphere or scene.ground)
        self.particles, self.first = model.getParticles(), cloth.getIndexOffset()
        for vertex in range(scene.n**2):
            self.particles.setMass(self.first + vertex, scene.mass / scene.n**2)
        for vertex in scene.held:
            self.particles.setMass(self.first + vertex, STILL)
        k = {"fem": 1.0, "pbd": 1.0, "xpbd": 5000.0 * (scene.n - 1) / 50.0}[variant] * settings["stiffness"]
        model.addClothConstraints(cloth, CLOTH_METHOD[variant], k, k, k, k, 0.3, 0.3, False, False)
        if variant == "xpbd":
            model.addBendingConstraints(cloth, XPBD_ISOMETRIC, 1e-4)
        else:
            model.addBendingConstraints(cloth, ISOMETRIC, 0.01)
        cloth.setFrictionCoeff(FRICTION)

    def _add_body(self, geometry: tuple[Any, Any], center: list[float], scale: list[float]) -> tuple[Any, ...]:
        """A body that stands still; returns it and what its collision object is made from."""
        body = self.model.addRigidBody(
            1.0, *geometry, center, np.identity(3), scale, testMesh=False, generateCollisionObject=False
        )
        body.setMass(STILL)
        body.setFrictionCoeff(FRICTION)
        vertices = body.getGeometry().getVertexData()
        kind = pbd.CollisionObject.RigidBodyCollisionObjectType
        return body, (len(self.model.getRigidBodies()) - 1, kind, vertices, 0, vertices.size())

    def _add_sphere(self, detection: Any) -> None:
        body, collider = self._add_body(as_mesh(*sphere(32)), y_up(SPHERE_CENTER).tolist(), [SPHERE_RADIUS] * 3)
        detection.addCollisionSphere(*collider, SPHERE_RADIUS, True, False)
        if self.scene.spin:
            body.setAngularVelocity([0, self.scene.spin, 0])

    def _add_ground(self, detection: Any) -> None:
        _, collider = self._add_body(as_mesh(*cube()), [0.0, -0.5 * GROUND[1], 0.0], GROUND)
        detection.addCollisionBox(*collider, GROUND, True, False)

    def step(self, targets: np.ndarray | None) -> None:
        """Place the held particles, then advance."""
        if targets is not None:
            for vertex, target in zip(self.scene.held, targets, strict=True):
                self.particles.setPosition(self.first + vertex, y_up(target))
        for _ in range(self.steps):
            self.stepper.step(self.model)

    def positions(self) -> np.ndarray:
        """In the order of the scene."""
        x, y, z = np.asarray(self.particles.getVertices()).reshape(-1, 3)[self.first : self.first + self.scene.n**2].T
        return np.stack([x, -z, y], axis=1)


def y_up(point: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the scene, whose z points up, in the engine's frame."""
    return np.stack([point[..., 0], point[..., 2], -point[..., 1]], axis=-1)


def sphere(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a unit sphere along meridians."""
    around = 2 * rings
    polar, azimuth = np.meshgrid(math.pi * np.arange(rings + 1) / rings, math.pi * np.arange(around) / rings)
    shell = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1)
    triangles = []
    for ring in range(rings):
        for segment in range(around):
            a, b = ring * around + segment, ring * around + (segment + 1) % around
            triangles += [[a, a + around, b], [b, a + around, b + around]]
    return shell.transpose(1, 0, 2).reshape(-1, 3), np.array(triangles)


def cube() -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a unit cube."""
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))])


def as_mesh(vertices: np.ndarray, triangles: np.ndarray) -> tuple[Any, Any]:
    """The engine's own mesh, by way of an OBJ file: its bindings document no other loader."""
    with tempfile.NamedTemporaryFile("w", suffix=".obj") as file:
        file.writelines("v {:g} {:g} {:g}\n".format(*vertex) for vertex in vertices)
        file.writelines("f {} {} {}\n".format(*triangle) for triangle in triangles + 1)
        file.flush()
        return pbd.OBJLoader.loadObjToMesh(file.name, [1, 1, 1])


if __name__ == "__main__":
    common.run(Engine)
