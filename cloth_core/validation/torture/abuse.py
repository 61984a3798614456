"""Ways to mistreat a cloth, one endless generator of :class:`Inputs` each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from cloth_core.inputs import Grasp, Inputs, Wind
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle, Plane
from cloth_core.pose import Pose
from cloth_core.validation.scenes import GRAVITY

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
SPIN = 20.0  # rad/s


@dataclass
class Victim:
    """What an abuser knows of the cloth; ``position`` (V, 3) m is kept up to date while the abuse goes on."""

    mesh: ClothMesh
    pinned: np.ndarray
    obstacles: Mapping[str, Obstacle]
    dt: float
    position: np.ndarray

    def free_vertex(self, random: np.random.Generator) -> int:
        """Any vertex that is not pinned."""
        return int(random.choice(np.setdiff1d(np.arange(self.mesh.vertex_count), self.pinned)))

    def far_ends(self, random: np.random.Generator) -> tuple[int, int]:
        """Two vertices about as far apart as the cloth reaches."""
        first = self.farthest_from(self.mesh.rest_position[self.free_vertex(random)])
        return first, self.farthest_from(self.mesh.rest_position[first])

    def farthest_from(self, place: np.ndarray) -> int:
        """The vertex farthest from a ``place`` (3,) m of the rest shape."""
        return int(np.argmax(np.linalg.norm(self.mesh.rest_position - place, axis=1)))


Abuse = Callable[[Victim, np.random.Generator], Iterator[Inputs]]


def teleport(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """A hand grasps a patch and jumps every few steps by up to 10 m, turning as it likes."""
    while True:
        radius = random.uniform(0.01, 0.15)
        home = victim.position[victim.free_vertex(random)].copy()
        yield _hands(radius, teleport=(home, UPRIGHT))
        for _ in range(random.integers(1, 10)):
            place = home + random.uniform(0.0, 5.0) * _direction(random)  # any two of them are 10 m apart at most
            turn = _turn(_direction(random) * random.uniform(0.0, math.pi))
            for _ in range(random.integers(1, 15)):
                yield _hands(radius, teleport=(place, turn))
        yield Inputs()


def tear(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Two hands grasp far ends and go 2 to 10 m apart, at once or within a second."""
    while True:
        radius, ends = random.uniform(0.005, 0.1), victim.far_ends(random)
        start = victim.position[list(ends)].copy()
        half = random.uniform(1.0, 5.0) * _direction(random)
        goal = start.mean(axis=0) + np.stack([half, -half])
        way = max(1, round(random.choice([0.0, random.uniform(0.0, 1.0)]) / victim.dt))
        for n in range(way + 20):
            a, b = start + min(1.0, n / way) * (goal - start)
            yield _hands(radius, tear_a=(a, UPRIGHT), tear_b=(b, UPRIGHT))
        yield Inputs()


def chatter(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Three hands tremble over one spot of the cloth and open or close in every step, the first one in turn."""
    vertex, radius = victim.free_vertex(random), random.uniform(0.02, 0.2)
    for n in itertools.count():
        near = victim.position[vertex] + random.normal(scale=0.3 * radius, size=(3, 3))
        closures = [n % 2, *random.integers(2, size=2)]
        yield Inputs(
            grasps={
                f"chatter_{number}": Grasp(pose=Pose(tuple(place)), closure=float(closure), radius=radius)
                for number, (place, closure) in enumerate(zip(near, closures, strict=True))
            }
        )


def far_corner(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """A hand at the corner farthest from what is pinned, pulled away up to 10 m and back again."""
    anchored = victim.pinned if len(victim.pinned) else np.array([victim.free_vertex(random)])
    corner = victim.farthest_from(victim.mesh.rest_position[anchored].mean(axis=0))
    while True:
        start, radius = victim.position[corner].copy(), random.uniform(0.005, 0.1)
        away = start - victim.position[anchored].mean(axis=0)
        away = random.uniform(0.1, 10.0) * away / max(float(np.linalg.norm(away)), 1e-6)
        period = max(4, round(random.uniform(0.1, 2.0) / victim.dt))
        for n in range(2 * period):
            yield _hands(radius, far_corner=(start + math.sin(math.pi * n / period) ** 2 * away, UPRIGHT))
        yield Inputs()


def cross(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Two hands grasp far ends, go through each other to the other's place and back, and twist."""
    while True:
        radius, ends = random.uniform(0.005, 0.1), victim.far_ends(random)
        a, b = victim.position[list(ends)].copy()
        middle, half, axis = 0.5 * (a + b), 0.5 * (a - b), _direction(random)
        period = max(4, round(random.uniform(0.1, 2.0) / victim.dt))
        for n in range(3 * period):
            angle = 2.0 * math.pi * n / period
            way = math.cos(angle) * half
            yield _hands(radius, cross_a=(middle + way, _turn(angle * axis)), cross_b=(middle - way, UPRIGHT))
        yield Inputs()


def storm(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Wind of up to 1e6 m/s that turns about every few steps, with gusts."""
    while True:
        gusts = dict(gust_intensity=random.uniform(0.0, 1.0), gust_seed=int(random.integers(1000)))
        velocity = 10.0 ** random.uniform(0.0, 6.0) * _direction(random)
        for _ in range(random.integers(1, 10)):
            yield Inputs(wind=Wind(velocity=tuple(velocity), **gusts))
            velocity = -velocity


def jump(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Obstacles jump by up to 3 m every few steps; the floor up and down only."""
    while True:
        steps = {name: random.uniform(0.0, 1.5) * _direction(random) for name in victim.obstacles}
        places = {
            name: Pose(tuple(np.add(shape.pose.position, steps[name] * _mobility(shape))), shape.pose.orientation)
            for name, shape in victim.obstacles.items()
        }
        for _ in range(random.integers(1, 15)):
            yield Inputs(obstacles=places)


def spin(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Obstacles spin on the spot at 20 rad/s; the floor about its normal."""
    axis = {
        name: np.array([0.0, 0.0, 1.0]) if isinstance(shape, Plane) else _direction(random)
        for name, shape in victim.obstacles.items()
    }
    for n in itertools.count():
        yield Inputs(
            obstacles={
                name: Pose(shape.pose.position, shape.pose.turned(SPIN * n * victim.dt * axis[name]))
                for name, shape in victim.obstacles.items()
            }
        )


def gravity(victim: Victim, random: np.random.Generator) -> Iterator[Inputs]:
    """Gravity points elsewhere every few steps."""
    while True:
        pull = tuple(GRAVITY * _direction(random))
        for _ in range(random.integers(1, 20)):
            yield Inputs(gravity=pull)


ABUSES: dict[str, Abuse] = {
    abuse.__name__.replace("_", "-"): abuse
    for abuse in (teleport, tear, chatter, far_corner, cross, storm, jump, spin, gravity)
}


def together(parts: Iterable[Inputs]) -> Inputs:
    """What several abusers do in the same step; where two want the same thing, the first one has it."""
    calm = Inputs()
    grasps: dict[str, Grasp] = {}
    obstacles: dict[str, Pose] = {}
    wind, pull = calm.wind, calm.gravity
    for part in parts:
        grasps = {**part.grasps, **grasps}
        obstacles = {**part.obstacles, **obstacles}
        wind = part.wind if wind == calm.wind else wind
        pull = part.gravity if pull == calm.gravity else pull
    return Inputs(grasps=grasps, obstacles=obstacles, wind=wind, gravity=pull)


def _hands(radius: float, **places: tuple[np.ndarray, tuple[float, float, float, float]]) -> Inputs:
    """Closed hands by name, each at a place (3,) m with an orientation."""
    return Inputs(
        grasps={
            name: Grasp(pose=Pose(tuple(place), turn), closure=1.0, radius=radius)
            for name, (place, turn) in places.items()
        }
    )


def _direction(random: np.random.Generator) -> np.ndarray:
    """A unit vector (3,), any as likely as any other."""
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def _turn(rotation_vector: np.ndarray) -> tuple[float, float, float, float]:
    """The quaternion of a rotation vector, rad."""
    return Pose().turned(rotation_vector)


def _mobility(shape: Obstacle) -> np.ndarray:
    """Where an obstacle may jump to, axis by axis: it would make no difference to a plane to move along itself."""
    return np.array([0.0, 0.0, 1.0]) if isinstance(shape, Plane) else np.ones(3)
