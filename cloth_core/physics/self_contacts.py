"""The cloth against itself, and against other cloths, which are pieces of one mesh."""

from __future__ import annotations

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.kernels import hierarchy, impacts, narrow, parting, response, untangle
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.meshing.patches import patches
from cloth_core.physics.features import Features
from cloth_core.physics.stretch_limit import HeldMasses

LEAST_THICKNESS = 0.05
"""Least thickness that is computed with, as a share of the mean edge: what is thinner, gravity presses through in one
substep, and the wrinkles of a cell are higher."""
SKIN = 0.15
"""By how much vertices may stray from where they were going before pairs are sought anew, as a share of a short edge:
what was smooth is so still."""
ROUNDS = 4
"""Of pushing back what would pass through."""
WAY_OUT = 0.1
"""Most that vertices go in a step where the cloth crosses itself, as a share of a short edge: more would tear it."""
SWEEPS = 4
"""Over contacts in each of these rounds."""
LASTING = 2
"""Substeps that a list of contacts does for."""


class SelfContacts(HeldMasses):
    """The pairs of vertex and triangle, and of edges, that touch in the substep at hand.

    A step begins with :meth:`begin_step`; each substep goes through :meth:`find`, some :meth:`sweep`,
    :meth:`keep_apart` and :meth:`settle_velocity`. Unless all :attr:`are_apart` at once, some may have to move as one.

    ``touching`` pairs, at most, were pushed apart in one of the substeps of the step; ``crossings`` it began with.

    Args:
        mesh: the cloth; without triangles it never touches itself.
        material: its thickness and friction are those of the contacts.
        config: ``max_push_speed`` holds here as well.
        mass: (V,) kg.
    """

    def __init__(self, mesh: ClothMesh, material: Material, config: SolverConfig, mass: np.ndarray) -> None:
        super().__init__(mass)
        self._mass, self._config, self._friction = mass, config, material.friction
        self._patches = patches(mesh.rest_position, mesh.triangles, mesh.component)
        features = Features.of(mesh, self._patches)
        self._sheet, self._area = features.sheet, mesh.triangle_area[self._patches.order]
        self._short, self._skin = features.short_edge, SKIN * features.short_edge
        self.thickness = max(material.thickness, LEAST_THICKNESS * features.mean_edge)
        self._far = 2.0 * (self.thickness + features.longest_edge)
        triangles, nodes = len(mesh.triangles), len(self._patches.compact)
        self._low, self._high = np.empty((triangles, 9)), np.empty((triangles, 9))
        self._patch_low, self._patch_high = np.empty((nodes, 9)), np.empty((nodes, 9))
        self._pair, self._leaf_normal = np.empty((0, 2), np.int32), np.empty((0, 3))
        self._gap, self._apart = np.empty(0), np.empty(0)
        leaves = len(self._patches.leaf_start) - 1
        self._fit = np.empty((triangles, 3)), np.empty((triangles, 6)), *(np.empty((leaves, 3)) for _ in range(3))
        self._wanted = np.zeros(leaves, np.bool_)
        self._moved, self._off = np.empty(leaves), np.zeros(leaves)
        self._first = self._ahead = self._found = 0
        self._pairs = self._count = 0
        self._make_room(2 * mesh.vertex_count)
        self._tangled = np.zeros(mesh.vertex_count, np.bool_)
        self._crossing, self.crossings = np.empty((0, 6), np.uint32), 0
        self._ways = np.zeros((mesh.vertex_count, 3)), np.zeros(mesh.vertex_count)
        self._place = np.zeros((mesh.vertex_count, 3))
        self._searches = self._passed = self._welded = 0
        self.are_apart = True

    def _make_room(self, contacts: int) -> None:
        """For so many contacts."""
        self._contact = (
            np.zeros((contacts, 4), np.uint32), np.zeros((contacts, 4)), np.zeros((contacts, 3)),
            np.zeros(contacts), np.zeros(contacts),
        )  # fmt: skip
        self._mobility, self._pushed, self._spent = np.zeros(contacts), np.zeros(contacts), np.zeros(contacts)

    def begin_step(self, position: np.ndarray, velocity: np.ndarray, time: float) -> np.ndarray:
        """Look ahead ``time`` s from (V, 3) ``position`` m at ``velocity`` m/s: which leaves may meet.

        Returns:
            The position to begin with: where the cloth crosses itself, a little on its way out.
        """
        self._until, self._now, self._ahead = time, 0.0, 0
        self._searches = self._passed = self._welded = self.touching = 0
        self.are_apart = True
        self._search(position, velocity)
        self.crossings = self._find_crossings(position)
        self._tangled[:] = False
        if self.crossings:
            position = position.copy()
            untangle.way_out(
                position, self._crossing[: self.crossings], self._inverse_mass,
                min(self._config.max_push_speed * time, WAY_OUT * self._short), self._tangled, *self._ways,
            )  # fmt: skip
            self._search(position, velocity)
        return position

    def _find_crossings(self, position: np.ndarray) -> int:
        n = self._pairs
        while True:
            count = untangle.find_crossings(
                position, self._sheet[2], self._patches.leaf_start, self._fit[0],
                self._pair[:n], self._gap[:n], self._crossing,
            )  # fmt: skip
            if count <= len(self._crossing):
                return count
            self._crossing = np.empty((2 * count, 6), np.uint32)

    def _search(self, position: np.ndarray, velocity: np.ndarray) -> None:
        """List the leaves that may meet in the rest of the step."""
        self._origin, self._velocity, self._since = position.copy(), velocity.copy(), self._now
        after = position + (self._until - self._now) * velocity
        self._strayed = 0.0
        self._searches += 1
        margin, tree = self.thickness + 2.0 * self._skin, self._patches
        hierarchy.fit_triangles(position, after, self._sheet[2], self._area, self._low, self._high)
        hierarchy.fit_patches(self._low, self._high, tree.leaf_start, self._patch_low, self._patch_high)
        while True:
            count = hierarchy.meeting_leaves(
                len(tree.leaf_start) - 1, tree.compact, tree.beside_start, tree.beside,
                self._patch_low, self._patch_high, margin, self._pair,
            )  # fmt: skip
            if count <= len(self._pair):
                break
            room = 3 * count // 2
            self._pair, self._leaf_normal = np.empty((room, 2), np.int32), np.empty((room, 3))
            self._gap, self._apart = np.empty(room), np.empty(room)
        listed = (self._pair[:count], self._leaf_normal[:count], self._gap[:count])
        parting.mark_leaves(listed[0], self._wanted)
        self._fit_leaves(position, after)
        parting.part_leaves(position, after, tree.corner_start, tree.corner, *self._fit[2:], margin, *listed)
        self._pairs = parting.keep_close(margin, *listed)

    def _fit_leaves(self, before: np.ndarray, after: np.ndarray) -> None:
        parting.fit_leaves(before, after, self._sheet[2], self._patches.leaf_start, self._wanted, *self._fit)

    def _follow(self, position: np.ndarray, time: float) -> bool:
        """Note how far vertices strayed by ``time`` s in the step; returns whether all pairs are still known."""
        self._strayed = max(self._strayed, parting.stray(position, self._origin, self._velocity, time - self._since))
        return self._strayed <= self._skin

    def find(self, start: np.ndarray, predicted: np.ndarray, h: float, number: int) -> None:
        """List what may touch from ``start`` to about ``predicted`` (V, 3) m, in substep ``number`` of ``h`` s.

        A list does for ``LASTING`` substeps, unless what may meet had to be sought anew meanwhile.
        """
        self._h, self._now = h, number * h
        # What is only predicted may lie anywhere: where it takes the cloth, the way after the loop will tell.
        if not self._follow(start, self._now):
            self._search(start, (predicted - start) / h)
        if self._first < number < self._first + self._ahead:
            self._renew(start, number - self._first)
            return
        self._first, self._ahead = number, min(LASTING, round(self._until / h) - number)
        self._base, self._way = start, predicted - start
        n, tree, end = self._pairs, self._patches, start + self._ahead * self._way
        self._predicted = predicted.copy()
        self._off[:] = 0.0
        if n:
            self._fit_leaves(start, end)
        while True:
            self._count = narrow.find_contacts(
                start, end, self._sheet, self._fit, tree.corner_start, tree.corner,
                self._pair[:n], self._leaf_normal[:n], self._gap[:n], self._apart[:n], self._strayed,
                self.thickness, self._far, self._config.max_push_speed * h, self._tangled, self._contact, self._ahead,
            )  # fmt: skip
            if self._count <= len(self._mobility):
                break
            self._make_room(3 * self._count // 2)
        self._found = self._count
        self._open(0)

    def _renew(self, start: np.ndarray, share: int) -> None:
        """Go on with the contacts that were found so many substeps ago."""
        vertex, weight, normal, target, keep = self._contact
        self._count, tree = self._found, self._patches
        response.renew(
            start, vertex, weight, normal, target, keep, self._config.max_push_speed * self._h, self._count,
            self._pushed, self._spent,
        )  # fmt: skip
        parting.farthest(start, self._base + share * self._way, tree.corner_start, tree.corner, self._off)
        self._predicted = self._base + (share + 1) * self._way

    def _open(self, first: int) -> None:
        """Contacts from number ``first`` on are new."""
        n = self._count
        vertex, weight = self._contact[0], self._contact[1]
        self._pushed[first:n] = 0.0
        self._spent[first:n] = 0.0
        response.ease(vertex[first:n], weight[first:n], self._inverse_mass, n - first, self._mobility[first:n])

    def sweep(self, start: np.ndarray, position: np.ndarray, number: int) -> float:
        """Push apart what is too close in ``position`` (V, 3) m, with friction.

        Returns:
            The farthest push in m; 0 for one that would not be seen.
        """
        farthest = self._push(start, position, 0, back=number % 2 == 1) if self._count else 0.0
        return farthest if farthest > response.IDLE * self.thickness else 0.0

    def _push(self, start: np.ndarray, position: np.ndarray, first: int, *, back: bool) -> float:
        vertex, weight, normal, target, _ = self._contact
        return response.push_apart(
            start, position, vertex, weight, normal, target, self._inverse_mass, self._mobility, self._friction,
            self._pushed, self._spent, first, self._count, back,
        )  # fmt: skip

    def keep_apart(self, start: np.ndarray, end: np.ndarray) -> None:
        """Push back what would pass through on the way from ``start`` to ``end`` (V, 3) m, in place, a few times."""
        for number in range(ROUNDS):
            before = self._count
            if self._add_impacts(start, end) == 0:
                self.are_apart = number == 0
                return
            self._passed += self._count - before
            for sweep in range(SWEEPS):
                self._push(start, end, 0 if sweep % 2 else before, back=sweep % 2 == 1)
        self.are_apart = False

    def passing(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """(N, 4) vertices of the pairs that still pass through on the way from ``start`` to ``end`` (V, 3) m."""
        before = self._count
        self._welded += self._add_impacts(start, end)
        return self._contact[0][before : self._count]

    def _add_impacts(self, start: np.ndarray, end: np.ndarray) -> int:
        """Add what would pass through to the contacts; returns how many they were."""
        if not self._follow(end, self._now + self._h):
            self._search(start, (end - start) / self._h)
            self._predicted, self._ahead = end.copy(), 0
            self._apart[: self._pairs] = self._gap[: self._pairs]
            self._off[:] = 0.0
        before, n, tree = self._count, self._pairs, self._patches
        if n == 0:
            return 0
        parting.farthest(end, self._predicted, tree.corner_start, tree.corner, self._moved)
        np.maximum(self._moved, self._off, out=self._moved)
        while True:
            self._count = impacts.find_impacts(
                start, end, self._place, self._sheet, tree.corner_start, tree.corner,
                self._pair[:n], self._leaf_normal[:n], self._apart[:n], self._moved,
                self._tangled, narrow.EDGES * self.thickness, self._contact, before,
            )  # fmt: skip
            if self._count <= len(self._mobility):
                self._open(before)
                return self._count - before
            kept = [array[:before].copy() for array in (*self._contact, self._mobility, self._pushed, self._spent)]
            self._make_room(2 * self._count)
            for array, old in zip((*self._contact, self._mobility, self._pushed, self._spent), kept, strict=True):
                array[:before] = old

    def settle_velocity(self, velocity: np.ndarray, start: np.ndarray) -> None:
        """End impacts in ``velocity`` (V, 3) m/s in place, after a substep from ``start`` (V, 3) m."""
        if self._count:
            self.touching = max(self.touching, int(np.count_nonzero(self._pushed[: self._count])))
            vertex, weight, normal, target, _ = self._contact
            response.end_impacts(
                velocity, start, vertex, weight, normal, target,
                self._inverse_mass, self._mobility, self._pushed, self._count, self._h,
            )  # fmt: skip
