"""The simulation as the node drives it: newest inputs in, one frame per tick out. No ROS, no clock."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cloth_core import ClothSolver, Grasp, InputError, Inputs, Pose, SettingError, StepReport
from cloth_core.scene import Scene
from cloth_sim_ros.recording.follow import pin_exactly
from cloth_sim_ros.simulation.frame import Frame
from cloth_sim_ros.simulation.world import Hand, Kept, World


class Simulation:
    """Holds a scene's solver and state, and turns the newest inputs into one step per tick.

    The setters may be called from any thread; ``tick`` and ``reset`` from one thread at a time.

    Args:
        scene: what is simulated.
        grasp_timeout: s without a pose after which a grasp counts as stale.
        grasp_cutoff: Hz up to which a hand that holds still is followed; 0: poses are taken as they come.
    """

    def __init__(self, scene: Scene, *, grasp_timeout: float = 0.1, grasp_cutoff: float = 0.0) -> None:
        self.scene = scene
        self.solver, self.state = scene.build()
        self.paused = False
        self.stale: tuple[str, ...] = ()
        self.kept: Kept | None = None
        """What :meth:`keep` gave when somebody asked for it."""
        self._start, self._start_pins = self.state, self.solver.pinned
        self.grasp_timeout, self.grasp_cutoff = grasp_timeout, grasp_cutoff
        self._lock = threading.Lock()  # guards the inputs below
        self._pin_wishes: dict[str, bool] = {}
        self._world = self._first_world({name: Hand() for name in scene.inputs.grasps})

    def prepare(self) -> None:
        """Compile the kernels and factorise, so that no tick is slower than the others."""
        self.solver.prepare(self.state)
        self.present()

    def set_grasp_pose(self, name: str, pose: Pose, now: float) -> None:
        """Pose of a gripper in the cloth's frame; ``now`` is the receipt in monotonic s."""
        with self._lock:
            self._world.hands[name] = self._hand(name).seen(pose, now, self.grasp_cutoff)

    def set_closure(self, name: str, closure: float) -> None:
        """How far a gripper is closed, 0 .. 1; it waits for the gripper's first pose."""
        with self._lock:
            hand = self._hand(name)
            must_open = hand.must_open and closure >= self.scene.inputs.grasps[name].open_at
            self._world.hands[name] = replace(hand, closure=closure, must_open=must_open)

    def set_wind(self, velocity: tuple[float, float, float]) -> None:
        """Mean wind in the cloth's frame, m/s; the scene's gusts stay."""
        with self._lock:
            self._world = replace(self._world, wind=replace(self._world.wind, velocity=velocity))

    def set_fluid(self, name: str, velocity: tuple[float, float, float]) -> None:
        """Velocity of a region of fluid in the cloth's frame, m/s."""
        if name not in self._world.fluids:
            raise InputError(f"no fluid {name}; this scene has {', '.join(self._world.fluids) or 'none'}")
        with self._lock:
            try:
                self._world.fluids[name] = replace(self._world.fluids[name], velocity=velocity)
            except SettingError as error:
                raise InputError(str(error)) from None

    def pin(self, group: str, pinned: bool) -> None:
        """Pin a group of vertices where they are when the next step begins, or let them go."""
        self._members(group)
        with self._lock:
            self._pin_wishes[group] = pinned
            if not pinned:
                self._world.groups.pop(group, None)

    def set_group_pose(self, group: str, pose: Pose) -> None:
        """Where the frame of a pinned group shall be, in the cloth's frame; see :class:`~cloth_core.Inputs`."""
        members = self._members(group)
        with self._lock:
            if not self._pin_wishes.get(group, bool(np.isin(members, self.solver.pinned).any())):
                raise InputError(f"nothing of the group {group} is pinned: send true to ~/group/{group}/pin before")
            self._world.groups[group] = pose

    def set_rest_scale(self, group: str, scale: float) -> None:
        """Rest lengths within a group, as multiples of those of the mesh; see :class:`~cloth_core.Inputs`."""
        self._members(group)
        self.solver.check_rest_scale([group])
        with self._lock:
            self._world.rest_scale[group] = scale

    def set_obstacle(self, name: str, pose: Pose) -> None:
        """Where an obstacle shall be at the end of the next step."""
        if name not in self.solver.obstacles:
            raise InputError(f"no obstacle {name}; this scene has {', '.join(self.solver.obstacles) or 'none'}")
        with self._lock:
            self._world.obstacles[name] = pose

    def tick(self, now: float, out_of_time: Callable[[], bool] | None = None) -> Frame:
        """Advance by one step with the newest inputs.

        Args:
            now: monotonic s, to tell which grasps are stale.
            out_of_time: the caller's clock; see :meth:`ClothSolver.step`.

        Raises:
            Exception: whatever the step raises; the state is then the one before.
        """
        inputs, self.stale = self._resolve(now)
        pins = self._change_pins()
        begin = time.perf_counter()
        self.state = self.solver.step(self.state, inputs, out_of_time)
        seconds, mesh, report = time.perf_counter() - begin, self.solver.mesh, self.solver.report
        rest = self.solver.rest
        return Frame.of(mesh, self.state, report, inputs, seconds, rest, stale=self.stale, pins=pins)

    def reset(self) -> None:
        """Back to the start of a new episode: the scene's state and inputs.

        Nothing stays held, and a hand that is closed now has to open before it grasps again.
        """
        with self._lock:
            pin_exactly(self.solver, self._start_pins)
            self._pin_wishes.clear()
            self.state, self.stale = self._start, ()
            grasps = self.scene.inputs.grasps.items()
            hands = {n: Hand(must_open=self._world.hands[n].closure >= grasp.open_at) for n, grasp in grasps}
            self._world = self._first_world(hands)

    def adopt(self, solver: ClothSolver) -> None:
        """Go on with another solver of the same cloth and obstacles; what is pinned stays so."""
        pin_exactly(solver, self.solver.pinned)
        self.solver = solver
        with self._lock:
            scaled = self._world.rest_scale
            for group in [*scaled]:
                try:
                    solver.check_rest_scale([group])
                except InputError:  # triangles carry the other material, and none lies within this group
                    del scaled[group]

    def keep(self) -> Kept:
        """All that it takes to go on from here as if nothing had happened since."""
        with self._lock:
            arrays = {name: array.copy() for name, array in self.solver.snapshot(self.state).items()}
            return Kept(arrays, self.state.step_index, self.solver, self._world.copy())

    def restore(self, kept: Kept) -> None:
        """Back to what :meth:`keep` gave: the same inputs from there on give the same cloth, bit for bit.

        What acted on the cloth then does so again until something newer comes.
        """
        with self._lock:
            self.state, self.stale = self.solver.restore(kept.arrays), ()
            self._world = kept.world.copy()

    def present(self) -> Frame:
        """The cloth as it is, without a step."""
        return Frame.of(self.solver.mesh, self.state, StepReport(), Inputs(), 0.0, self.solver.rest)

    def _first_world(self, hands: dict[str, Hand]) -> World:
        """What the scene itself does to the cloth."""
        inputs = self.scene.inputs
        return World(hands, inputs.wind, dict(inputs.obstacles), dict(inputs.fluids))

    def _members(self, group: str) -> np.ndarray:
        groups = self.solver.mesh.groups
        if group not in groups:
            raise InputError(f"no group {group}; this cloth has {', '.join(groups) or 'none'}")
        return groups[group]

    def _hand(self, name: str) -> Hand:
        if name not in self._world.hands:
            raise InputError(f"no grasp {name}; this scene has {', '.join(self._world.hands) or 'none'}")
        return self._world.hands[name]

    def _change_pins(self) -> np.ndarray | None:
        """Do what was wished for; the pinned vertices if they are others now."""
        with self._lock:
            wishes, self._pin_wishes = self._pin_wishes, {}
        before = self.solver.pinned
        for group, pinned in wishes.items():
            members = self.solver.mesh.group(group)
            # What is pinned already keeps its W.
            if pinned and not np.isin(members, self.solver.pinned).all():
                self.solver.pin(members)
            elif not pinned and np.isin(members, self.solver.pinned).any():
                self.solver.unpin(np.intersect1d(members, self.solver.pinned))
        return None if np.array_equal(before, self.solver.pinned) else self.solver.pinned

    def _resolve(self, now: float) -> tuple[Inputs, tuple[str, ...]]:
        with self._lock:
            grasps: dict[str, Grasp] = {}
            stale = []
            for name, hand in self._world.hands.items():
                if hand.tracked is None:
                    continue
                closure = 0.0 if hand.must_open else hand.closure
                grasps[name] = replace(self.scene.inputs.grasps[name], pose=hand.tracked.pose, closure=closure)
                if now - hand.tracked.at > self.grasp_timeout:
                    stale.append(name)
            world = self._world.copy()
        inputs = replace(
            self.scene.inputs,
            grasps=grasps,
            wind=world.wind,
            obstacles=world.obstacles,
            fluids=world.fluids,
            groups=world.groups,
            rest_scale=world.rest_scale,
        )
        return inputs, tuple(stale)
