"""Contacts with obstacles that stand or move: who touches, push-out, friction, impact (paper, 4.2)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.kernels import approach, impulses
from cloth_core.kernels import contact as kernels
from cloth_core.kernels.bodies import Bodies
from cloth_core.kernels.contact import Points
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import FIELD, Obstacle
from cloth_core.physics.field_contacts import FieldContacts
from cloth_core.physics.stretch_limit import HeldMasses
from cloth_core.pose import Pose

ROUND = 0.5
"""Of the shell: where obstacles stick out less between two vertices which touch them, no look at what is between."""

SWIFT = 0.5
"""Of the radius inside an obstacle: what moves less in a substep ends on the side that it came from."""

BETWEEN = 0.1
"""Of the shell, by which fingers that squeeze may come nearer than half their gap: a point of an edge that is held at
one end would fling the other about."""


class Contacts(HeldMasses):
    """The obstacles of a scene as arrays, and the points of the cloth that touch them in the substep at hand.

    Args:
        obstacles: by name.
        mesh: the cloth.
        material: of its friction, restitution and stretch limit.
        mass: (V,) kg.
        config: shell and speeds.
    """

    def __init__(
        self,
        obstacles: Mapping[str, Obstacle],
        mesh: ClothMesh,
        material: Material,
        mass: np.ndarray,
        config: SolverConfig,
    ) -> None:
        super().__init__(mass)
        # Fields come last: their points are looked for after those of all others.
        obstacles = dict(sorted(obstacles.items(), key=lambda named: named[1].kind == FIELD))
        self.names, self._config = list(obstacles), config
        count = len(self.names)
        solid = list(obstacles.values())
        reach = np.array([min(shape.reach, 1e9) for shape in solid], dtype=float)
        self._restitution = material.restitution
        self._bodies = Bodies(
            kind=np.array([shape.kind for shape in solid], dtype=np.int64),
            size=np.array([shape.size for shape in solid], dtype=float).reshape(count, 3),
            reach=reach,
            friction=np.array([material.friction if s.friction is None else s.friction for s in solid], dtype=float),
            rotation_before=np.tile(np.eye(3), (count, 1, 1)),
            origin_before=np.zeros((count, 3)),
            rotation=np.tile(np.eye(3), (count, 1, 1)),
            origin=np.zeros((count, 3)),
            turn=np.zeros((count, 3)),
            travel=np.zeros(count),
        )
        self._lever = np.where(reach < 1e9, reach, 1.0)
        edges = _edges(mesh)
        lengths = np.linalg.norm(np.diff(mesh.rest_position[edges], axis=1)[:, 0], axis=1)
        self._longest_edge = float(lengths.max(initial=0.0)) * material.stretch_limit
        self._edge, self._triangle = edges.astype(np.uint32), mesh.triangles.astype(np.uint32)
        length = self._longest_edge
        # The paper's masses are points (4.2.3), and in its long steps what is between them would only tear the cloth.
        between = config.integrator != "meyer2000"
        self.fields = FieldContacts(obstacles, config.contact_shell, mesh.vertex_count, len(edges), between)
        self._analytic = Bodies(*(array[: self.fields.first] for array in self._bodies))
        self._sharp = np.array(
            [between and length**2 > 8.0 * shape.roundness * ROUND * config.contact_shell for shape in solid], np.bool_
        )
        # An arc of this angle rises above its chord by angle * length / 8; above the middles of the three chords of a
        # spherical triangle, by a third of that.
        angle = 8.0 * ROUND * config.contact_shell / length if length > 0.0 else 0.0
        self._flat = np.cos(np.minimum([angle, 3.0 * angle], np.pi))
        self._thin = np.array([0.0 < shape.roundness < config.contact_shell for shape in solid], np.bool_)
        self._swift = np.array([max(SWIFT * shape.inradius, config.contact_shell) for shape in solid], dtype=float)
        vertices = mesh.vertex_count
        self._way, self._distance, self._surface = np.zeros(vertices), np.zeros(vertices), np.zeros((vertices, 3))
        self._points, self._count, self._of_shapes = _room(2 * vertices if count else 0), 0, 0
        self._component, self._give = mesh.component, np.zeros(count)
        self.pressed = np.zeros((vertices, 3))
        """N s, what obstacles did to each vertex since :meth:`begin_step`."""
        self.press = np.zeros((count, mesh.component.max() + 1, 19))
        """What the cloth did to the obstacles since then, see :func:`~cloth_core.kernels.impulses.add_impulses`."""

    def hold(self, held: np.ndarray) -> None:
        """From now on these vertices go where they are taken, whatever is there."""
        super().hold(held)
        self._free = self._inverse_mass > 0.0

    def give(self, gaps: Mapping[str, float]) -> None:
        """Let the cloth come as close to these obstacles in this step as half a gap (m) allows, by name.

        What two of them squeeze cannot keep the whole shell from both.
        """
        self._give[:] = 0.0
        for name, gap in gaps.items():
            squeezed = self._config.contact_shell - 0.5 * gap
            self._give[self.names.index(name)] = (
                squeezed + BETWEEN * self._config.contact_shell if squeezed > 0 else 0.0
            )

    def begin_step(self, before: Mapping[str, Pose], after: Mapping[str, Pose]) -> list[str]:
        """Set the way of every obstacle for the coming step; returns the names of those too fast to follow.

        An obstacle faster than ``max_obstacle_speed`` (at its farthest point) is teleported: it stands at
        its new place from the start, and its surface drags nothing along.
        """
        self._way_of_bodies: list[tuple[Pose, Pose]] = []
        teleported = []
        for number, name in enumerate(self.names):
            start, end = before[name], after[name]
            way = float(np.linalg.norm(np.subtract(end.position, start.position)))
            lever = self._lever[number]
            turn = float(np.linalg.norm(start.rotation_vector_to(end)))
            if (
                way > self._config.max_obstacle_speed * self._config.dt
                or turn * lever > self._config.max_obstacle_speed * self._config.dt
            ):
                teleported.append(name)
                start = end
            self._way_of_bodies.append((start, end))
            self._place(number, start)
        self._bodies.travel[:] = 0.0
        self.fields.begin_step()
        self._count = 0
        self.pressed[:] = self.press[:] = 0.0
        return teleported

    def _place(self, number: int, pose: Pose) -> None:
        self._bodies.rotation[number] = pose.rotation
        self._bodies.origin[number] = pose.position

    @property
    def bodies(self) -> Bodies:
        """Where they are; to be read."""
        return self._bodies

    @property
    def way(self) -> np.ndarray:
        """(O, 3) m that each obstacle goes in this step; teleports are none."""
        ways = [np.subtract(end.position, start.position) for start, end in self._way_of_bodies]
        return np.array(ways, dtype=float).reshape(len(ways), 3)

    @property
    def still(self) -> bool:
        """Whether no obstacle moves in this step."""
        return all(start == end for start, end in self._way_of_bodies)

    def begin_substep(self, share: float) -> None:
        """Move the obstacles to ``share`` (0..1] of their way through the step."""
        bodies = self._bodies
        self.fields.begin_substep(bodies.travel)
        bodies.rotation_before[:] = bodies.rotation
        bodies.origin_before[:] = bodies.origin
        bodies.turn[:] = 0.0
        bodies.travel[:] = 0.0
        for number, (start, end) in enumerate(self._way_of_bodies):
            if start is end or start == end:
                continue
            self._place(number, start.toward(end, share))
            turn = bodies.rotation[number] @ bodies.rotation_before[number].T
            # The vector of a small rotation, read off its skew part.
            bodies.turn[number] = 0.5 * np.array(
                [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
            )
            moved = np.linalg.norm(bodies.origin[number] - bodies.origin_before[number])
            bodies.travel[number] = moved + self._lever[number] * np.linalg.norm(bodies.turn[number])

    def find(self, start: np.ndarray, predicted: np.ndarray, h: float) -> None:
        """List what may touch while the vertices go from ``start`` to about ``predicted`` (V, 3) m in ``h`` s."""
        if not self.names:
            return
        sheet = self._edge, self._triangle, self._longest_edge, self._free, self._inverse_mass
        room, recover = (self._way, self._distance, self._surface), self._config.max_push_speed * h
        while True:
            self._of_shapes = approach.find_points(
                start, predicted, *sheet, self._analytic, self._sharp, self._thin, self._swift, self._flat,
                self._config.contact_shell, recover, self._points, *room,
            )  # fmt: skip
            self._count = self.fields.find(
                start, predicted, sheet, self._bodies, recover, self._points, self._of_shapes, room
            )
            if self._count <= len(self._points.body):
                self._points.shift[: self._count] = 0.0
                if self._give.any():
                    depth, body = self._points.depth[: self._count], self._points.body[: self._count]
                    np.maximum(depth, self._give[body], out=depth)
                return
            self._points = _room(2 * self._count)

    def find_again(self, start: np.ndarray, predicted: np.ndarray, h: float) -> None:
        """As :meth:`find`, for vertices that turned out to go elsewhere; what was done so far is added up."""
        if self._count:
            impulses.add_impulses(
                predicted, h, self._bodies, self._points, self._count, self._inverse_mass, self._component,
                self.pressed, self.press,
            )  # fmt: skip
        self.find(start, predicted, h)

    @property
    def points(self) -> Points:
        """What may touch in this substep; the first :attr:`count` do."""
        return self._points

    @property
    def count(self) -> int:
        """How many points may touch."""
        return self._count

    @property
    def shell(self) -> float:
        """m from obstacles that points keep."""
        return self._config.contact_shell

    @property
    def origins(self) -> np.ndarray:
        """(O, 3) m, where the frames of the obstacles stand."""
        return self._bodies.origin

    @property
    def touching(self) -> int:
        """Points that were pushed in this substep."""
        return int(np.count_nonzero(self._points.pushed[: self._count]))

    def touched(self) -> np.ndarray:
        """Vertices that were pushed in this substep."""
        pushed = np.flatnonzero(self._points.pushed[: self._count])
        counts = np.arange(3) < self._points.corners[pushed][:, None]
        return self._points.corner[pushed][counts]

    def push_out(self, position: np.ndarray) -> float:
        """Bring what is too deep back to the shell, in place; returns the farthest push in m."""
        if self._count == 0:
            return 0.0
        farthest = self.fields.push_out(position, self._bodies, self._points, self._count, self._inverse_mass)
        if self._of_shapes == 0:
            return farthest
        shell = self._config.contact_shell
        return max(
            farthest,
            kernels.push_out(position, self._analytic, self._points, self._of_shapes, self._inverse_mass, shell),
        )

    def apply_friction(self, start: np.ndarray, position: np.ndarray) -> None:
        """Coulomb friction against the surfaces, which may move, on the displacement from ``start``; in place.

        To be called after every push: the friction of a substep is bounded by all of its pushes together. What the
        next sweep does not move is left alone by the next push: friction takes it off the surface in second order
        only, and the next substep sees it again.
        """
        if self._count:
            kernels.apply_friction(start, position, self._bodies, self._points, self._count, self._inverse_mass)

    def settle_velocity(
        self, velocity: np.ndarray, before: np.ndarray, position: np.ndarray, h: float, rest_speed: float
    ) -> None:
        """Give touched points the surface's normal velocity, or bounce them; ``velocity`` (V, 3) in place.

        With that the substep has done to them all it does, and their impulses are added up.
        """
        if self._count:
            impulses.settle(
                velocity, before, position, h, self._bodies, self._points, self._count, self._inverse_mass,
                self._restitution, rest_speed, self._component, self.pressed, self.press,
            )  # fmt: skip


def _edges(mesh: ClothMesh) -> np.ndarray:
    """(E, 2) the edges of the triangles; of bare springs, those."""
    if len(mesh.triangles) == 0:
        return mesh.spring_vertex.copy()
    corners = mesh.triangles
    sides = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]), axis=1)
    return np.unique(sides, axis=0)


def _room(count: int) -> Points:
    return Points(
        corners=np.ones(count, np.int8),
        corner=np.zeros((count, 3), np.uint32),
        weight=np.zeros((count, 3)),
        yields=np.zeros(count),
        body=np.zeros(count, np.int32),
        depth=np.zeros(count),
        plane=np.zeros((count, 4)),
        left=np.zeros((count, 3)),
        pushed=np.zeros(count),
        spent=np.zeros(count),
        normal=np.zeros((count, 3)),
        gap=np.zeros(count),
        shift=np.zeros((count, 3)),
    )
