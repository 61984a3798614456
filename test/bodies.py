"""Closed surfaces with known distances, and a slow twin for all others."""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from cloth_core import Pose
from cloth_core.fields import Closed, closed


def box(*half: float) -> Closed:
    mesh = trimesh.creation.box(extents=2.0 * np.array(half))
    return closed(mesh.vertices, mesh.faces)


def ball(radius: float, finer: int = 3) -> Closed:
    mesh = trimesh.creation.icosphere(subdivisions=finer, radius=radius)
    return closed(mesh.vertices, mesh.faces)


def torus(major: float, minor: float, sections: int = 96) -> Closed:
    mesh = trimesh.creation.torus(major, minor, major_sections=sections, minor_sections=sections // 2)
    return closed(mesh.vertices, mesh.faces)


def cone(radius: float, height: float, angle: np.ndarray | None = None) -> Closed:
    """On the z = 0 plane, tip up; the corners of its rim at ``angle``, its side first among the triangles."""
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False) if angle is None else angle
    sections = len(angle)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(sections)], axis=1)
    here, after = np.arange(sections), np.roll(np.arange(sections), -1)
    side = np.stack([here, after, np.full(sections, sections)], axis=1)
    base = np.stack([after, here, np.full(sections, sections + 1)], axis=1)
    return closed(np.vstack([rim, [0, 0, height], [0, 0, 0]]), np.concatenate([side, base]))


def knobbly(random: np.random.Generator) -> Closed:
    """A ball with lumps and hollows of any size."""
    mesh = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
    wave = random.normal(0.0, 2.0, (4, 3))
    swell = 1.0 + 0.15 * np.sin(mesh.vertices @ wave.T).sum(axis=1)
    return closed(random.uniform(0.1, 0.6) * swell[:, None] * mesh.vertices, mesh.faces)


def any_pose(random: np.random.Generator) -> Pose:
    return Pose(tuple(random.uniform(-0.5, 0.5, 3)), tuple(Rotation.random(rng=random).as_quat()))


def moved(surface: Closed, pose: Pose) -> Closed:
    return Closed(pose.apply(surface.position), surface.triangles)


def joined(*surfaces: Closed) -> Closed:
    """All as one mesh, overlapping or not."""
    counts = np.cumsum([0, *(len(s.position) for s in surfaces)])
    triangles = [s.triangles + at for s, at in zip(surfaces, counts, strict=False)]
    return Closed(np.concatenate([s.position for s in surfaces]), np.concatenate(triangles))


def box_distance(points: np.ndarray, half: np.ndarray) -> np.ndarray:
    beyond = np.abs(points) - half
    return np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0)


def torus_distance(points: np.ndarray, major: float, minor: float) -> np.ndarray:
    return np.hypot(np.hypot(points[:, 0], points[:, 1]) - major, points[:, 2]) - minor


def slow_distance(surface: Closed, point: np.ndarray) -> float:
    """Unsigned: the plane of each triangle where the foot is within it, its sides elsewhere."""
    least = np.inf
    for a, b, c in surface.position[surface.triangles]:
        normal = np.cross(b - a, c - a)
        weights = np.linalg.solve(np.stack([b - a, c - a, normal], axis=1), point - a)
        if weights[0] >= 0.0 and weights[1] >= 0.0 and weights[0] + weights[1] <= 1.0:
            least = min(least, abs(weights[2]) * np.linalg.norm(normal))
        for p, q in ((a, b), (b, c), (c, a)):
            t = np.clip((point - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0)
            least = min(least, float(np.linalg.norm(point - p - t * (q - p))))
    return least


def slow_inside(surface: Closed, point: np.ndarray, direction: np.ndarray) -> bool:
    """Whether a ray leaves more triangles than it enters."""
    a, b, c = surface.position[surface.triangles].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    flux = normal @ direction
    with np.errstate(divide="ignore", invalid="ignore"):
        way = np.einsum("tk,tk->t", normal, a - point) / flux
        foot = point + way[:, None] * direction
        within = np.all(
            [np.einsum("tk,tk->t", np.cross(q - p, foot - p), normal) > 0.0 for p, q in ((a, b), (b, c), (c, a))],
            axis=0,
        )
    return float(np.sign(flux[within & (way > 0.0)]).sum()) > 0.5


def around(random: np.random.Generator, surface: Closed, count: int, spread: float) -> np.ndarray:
    """Points of the surface moved by ``spread`` m or so."""
    corner = surface.position[surface.triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    chosen = random.choice(len(corner), count, p=area / area.sum())
    foot = np.einsum("pn,pnk->pk", random.dirichlet(np.ones(3), count), corner[chosen])
    return foot + random.normal(0.0, spread, (count, 3))


def as_trimesh(surface: Closed) -> trimesh.Trimesh:
    return trimesh.Trimesh(surface.position, surface.triangles, process=False)
