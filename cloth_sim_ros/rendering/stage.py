"""A scene as a picture: cloth, obstacles, grippers, wind, ground, light and camera."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from cloth_core import Inputs, State
from cloth_core.kernels import surface
from cloth_core.obstacles import Plane
from cloth_core.scene import Scene
from cloth_sim_ros.rendering import shapes
from cloth_sim_ros.rendering.fabric import FABRICS, Fabric, printed
from cloth_sim_ros.rendering.ground import Ground, surface_points
from cloth_sim_ros.rendering.smooth import loop_subdivision

BACKGROUND = ("#e3e6ea", "#f7f8f9")  # below, above
OBSTACLE_COLOURS = ("#8fa3ad", "#b9a78f", "#9aab95", "#a79aab", "#b3938b")
GRIPPER_COLOUR, ARROW_COLOUR = "#4d5660", "#8fb0c9"
CALM = 0.3  # m/s below which no arrow is drawn
KEY_LIGHT = (0.55, 0.47, -0.69)
OVERSAMPLING = 2


class Stage:
    """Draws states of one scene; every picture is (height, width, 3) uint8.

    Args:
        scene: what is drawn.
        size: width and height in pixels.
        fabric: the cloth's colours.
    """

    def __init__(self, scene: Scene, size: tuple[int, int] = (960, 720), fabric: Fabric = FABRICS["silk"]) -> None:
        self._scene = scene
        self._plotter = pv.Plotter(off_screen=True, window_size=[OVERSAMPLING * n for n in size], lighting="none")
        # Drawn larger and averaged down: cheaper in software than multisampling, and it smooths textures too.
        self._plotter.render_window.SetMultiSamples(0)
        self._plotter.set_background(BACKGROUND[0], top=BACKGROUND[1])
        self._distance = max(float(np.linalg.norm(np.subtract(scene.view.eye, scene.view.target))), 1e-3)
        self._set_camera()
        self._set_lights()
        self._finer, self._triangles = loop_subdivision(scene.mesh.triangles, scene.mesh.vertex_count)
        self._cloth = self._add_cloth(fabric)
        self._obstacles, self._solid = {}, {}
        self._add_obstacles()
        self._grounds = self._add_grounds()

    def picture(self, state: State, inputs: Inputs) -> np.ndarray:
        """The scene at one instant: ``state``, with the grippers and the wind of ``inputs``."""
        self._place_cloth(state)
        for name, actor in self._obstacles.items():
            actor.user_matrix = shapes.matrix(state.obstacles[name])
        self._draw_grippers(inputs)
        self._draw_wind(inputs)
        points = self._shadow_casters(state)
        for ground in self._grounds:
            ground.cast_shadow(points)
        self._plotter.render()
        return _averaged(self._plotter.screenshot(None, return_img=True))

    def close(self) -> None:
        """Release the window; no picture can be drawn afterwards."""
        self._plotter.close()

    def __enter__(self) -> Stage:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _set_camera(self) -> None:
        view = self._scene.view
        self._plotter.camera_position = [view.eye, view.target, (0.0, 0.0, 1.0)]
        self._plotter.camera.view_angle = 30.0

    def _set_lights(self) -> None:
        """A key light over the camera's left shoulder, a fill from the right, a faint one from the camera."""
        target = np.array(self._scene.view.target)
        fill = np.array([-0.85, 0.1, -0.35])
        for direction, intensity, colour in ((KEY_LIGHT, 0.88, "#fff6ea"), (fill, 0.32, "#e6eeff")):
            source = target - 5.0 * np.array(direction)
            self._plotter.add_light(pv.Light(position=source, focal_point=target, color=colour, intensity=intensity))
        self._plotter.add_light(pv.Light(light_type="headlight", intensity=0.22))

    def _add_cloth(self, fabric: Fabric) -> pv.PolyData:
        mesh = self._scene.mesh
        start = self._finer @ self._scene.placement.apply(mesh.rest_position)
        cloth = pv.PolyData.from_regular_faces(start, self._triangles)
        cloth.point_data.active_normals = np.zeros(start.shape, np.float32)
        image = printed(fabric, mesh)
        texture = None
        if image is not None:
            texture = pv.Texture(image)
            texture.interpolate = texture.mipmap = True
            cloth.active_texture_coordinates = (self._finer @ mesh.uv).astype(np.float32)
        colour = fabric.ground if texture is None else "white"
        shine = dict(ambient=0.26, diffuse=0.85, specular=fabric.gloss, specular_power=18.0)
        actor = self._plotter.add_mesh(cloth, color=colour, texture=texture, **shine)
        actor.prop.interpolation = "Phong"
        back = np.array(fabric.back) * pv.Color(colour).float_rgb
        actor.backface_prop = pv.Property(color=back, interpolation="Phong", **shine)
        return cloth

    def _place_cloth(self, state: State) -> None:
        position = self._finer @ state.position
        area, normal = np.empty_like(position), np.empty_like(position)
        surface.area_vectors(position, self._triangles, area)
        surface.normals(area, normal)
        self._cloth.points[:] = position
        self._cloth.point_data["Normals"][:] = normal
        self._cloth.Modified()

    def _add_obstacles(self) -> None:
        look = dict(smooth_shading=True, split_sharp_edges=True, ambient=0.2, specular=0.1)
        for number, (name, obstacle) in enumerate(self._scene.obstacles.items()):
            shape = shapes.surface(obstacle)
            if shape is not None:
                colour = OBSTACLE_COLOURS[number % len(OBSTACLE_COLOURS)]
                self._obstacles[name] = self._plotter.add_mesh(shape, color=colour, **look)
                self._solid[name] = surface_points(np.array(shape.points), shape.triangulate().regular_faces)

    def _add_grounds(self) -> list[Ground]:
        grounds, target = [], np.array([self._scene.view.target])
        for obstacle in self._scene.obstacles.values():
            if isinstance(obstacle, Plane):
                center = obstacle.pose.inverse_apply(target)[0, :2]
                grounds.append(Ground(self._plotter, obstacle.pose, center, 1.6 * self._distance, KEY_LIGHT))
        return grounds

    def _shadow_casters(self, state: State) -> np.ndarray:
        solid = [state.obstacles[name].apply(points) for name, points in self._solid.items()]
        return np.concatenate([surface_points(state.position, self._scene.mesh.triangles), *solid])

    def _draw_grippers(self, inputs: Inputs) -> None:
        look = dict(color=GRIPPER_COLOUR, smooth_shading=True, specular=0.3, reset_camera=False)
        for name, grasp in inputs.grasps.items():
            hand = shapes.gripper(grasp).transform(shapes.matrix(grasp.pose), inplace=False)
            self._plotter.add_mesh(hand, name=f"gripper {name}", **look)

    def _draw_wind(self, inputs: Inputs) -> None:
        velocity = np.array(inputs.wind.velocity)
        if np.linalg.norm(velocity) < CALM:
            self._plotter.remove_actor("wind", render=False)
            return
        scale = 0.02 * self._distance
        arrow = shapes.wind_arrow(velocity, self._upper_left(), length_per_speed=scale)
        self._plotter.add_mesh(arrow, color=ARROW_COLOUR, ambient=0.4, name="wind", reset_camera=False)

    def _upper_left(self) -> np.ndarray:
        """A corner of the picture, as far away as what the camera looks at."""
        view = self._scene.view
        ahead = np.subtract(view.target, view.eye) / self._distance
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= max(float(np.linalg.norm(right)), 1e-9)
        up = np.cross(right, ahead)
        return np.array(view.target) + self._distance * (0.19 * up - 0.26 * right)


def _averaged(image: np.ndarray) -> np.ndarray:
    height, width = (n // OVERSAMPLING for n in image.shape[:2])
    blocks = image.reshape(height, OVERSAMPLING, width, OVERSAMPLING, 3)
    return blocks.mean(axis=(1, 3)).round().astype(np.uint8)
