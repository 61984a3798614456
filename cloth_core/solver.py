"""ClothSolver: one step is one page of the paper."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cloth_core.arguments import check_arguments, check_parts, check_state, with_plain_arrays
from cloth_core.config import SolverConfig
from cloth_core.errors import MeshError
from cloth_core.gripper import Gripper, check_grippers
from cloth_core.inputs import Inputs
from cloth_core.integrators import BY_NAME, Model
from cloth_core.kernels import springs
from cloth_core.linear import Assembly, Plans
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.drag import flow_at
from cloth_core.physics.following import follow
from cloth_core.physics.grasping import update_grips
from cloth_core.physics.hands import Hands
from cloth_core.physics.immersion import regions_of
from cloth_core.physics.pinching import Fingers, Pinch
from cloth_core.physics.reach import Reach
from cloth_core.physics.restraint import Restraint
from cloth_core.physics.stiffness import check_stiffness
from cloth_core.physics.ways import Ways
from cloth_core.pose import Pose
from cloth_core.rehearsal import kinds, rehearse
from cloth_core.report import StepReport, Wrench
from cloth_core.settings import check_kind
from cloth_core.state import Grip, State, entry
from cloth_core.substeps import Passes, Substeps


class ClothSolver:
    """Advances a cloth by fixed steps of ``config.dt``.

    The solver owns what is precomputed (W above all) and work arrays. What moves is in the
    :class:`State`: the same state and inputs give the same next state, bit for bit.

    Args:
        mesh: the cloth.
        material: what it is made of.
        config: how it is computed.
        obstacles: what it collides with, by name.
        grippers: pairs of obstacles that are fingers, by name.

    Raises:
        SettingError: one of them has a wrong type, or a gripper a finger that there is not.
        MeshError: a vertex has no mass.
    """

    def __init__(
        self,
        mesh: ClothMesh,
        material: Material | None = None,
        config: SolverConfig | None = None,
        *,
        obstacles: Mapping[str, Obstacle] | None = None,
        grippers: Mapping[str, Gripper] | None = None,
    ) -> None:
        material = Material() if material is None else material
        config = SolverConfig() if config is None else config
        check_parts(mesh, material, config, {} if obstacles is None else obstacles)
        self.mesh = mesh
        self.obstacles = dict(obstacles or {})
        check_grippers({} if grippers is None else grippers, self.obstacles)
        self.grippers = dict(grippers or {})
        self._pinned = np.zeros(0, dtype=np.int32)
        self._ways, self._assembly, self._plans = Ways(mesh), Assembly(mesh), Plans()
        self._equip(material, config)

    def _equip(self, material: Material, config: SolverConfig) -> None:
        """Take up what is not shared with solvers of other materials and configurations."""
        self.material, self.config = material, config
        self.report = StepReport()
        massless = np.flatnonzero(~(self.mesh.vertex_mass(material) > 0))
        if len(massless):
            raise MeshError(f"vertices {massless[:8].tolist()} have no mass: they belong to no triangle")
        kind = BY_NAME[config.integrator]
        self.substeps = config.substeps or kind.substeps(config)
        self.sweeps = config.stretch_sweeps or kind.stretch_sweeps
        self._model: Model | None = None
        self._flow = np.zeros((self.mesh.vertex_count, 3))
        self._reach = Reach(self.mesh, material.stretch_limit, self._ways)
        self._fingers = {
            name: Fingers(gripper, self.obstacles, material.friction, config) for name, gripper in self.grippers.items()
        }
        self._restraint = Restraint(self.mesh, material, config.max_grasp_force)

    def changed(self, *, material: Material | None = None, config: SolverConfig | None = None) -> ClothSolver:
        """A solver of another material or configuration for the same cloth, obstacles and pins, ready to step.

        It takes up any state that this one leaves: positions, velocities, grips and the tension of taut threads go
        on; the velocity of an accelerated cloth is the same whatever the substep. Everything is precomputed before
        it returns (a quarter of a second for 10,000 vertices), in kernels that release the interpreter. So another
        thread can make it while this solver steps, undisturbed, and whoever steps takes the new one when it is there::

            with ThreadPoolExecutor() as worker:
                coming = worker.submit(solver.changed, material=Material.preset("denim"))
                while running():
                    if coming is not None and coming.done():
                        solver, coming = coming.result(), None
                    state = solver.step(state, inputs())

        Vertices that are pinned or unpinned on this solver later are not on that one.

        Args:
            material: what it is made of from now on; the same by default.
            config: how it is computed from now on; the same by default.

        Raises:
            SettingError: one of them has a wrong type.
            MeshError: the mesh, this material and this substep cannot be computed together.
        """
        material = self.material if material is None else material
        config = self.config if config is None else config
        check_parts(self.mesh, material, config, self.obstacles)
        other = copy.copy(self)
        other._equip(material, config)
        other.prepare()
        return other

    @property
    def pinned(self) -> np.ndarray:
        """Sorted vertices that stay where they are."""
        return self._pinned

    @property
    def representation(self) -> str:
        """How W is stored: dense or sparse."""
        return self._prepared().representation

    def pin(self, vertices: Sequence[int] | np.ndarray) -> None:
        """Pin further vertices where the state has them. W is computed anew at the next step.

        Raises:
            MeshError: a vertex does not exist, or these are no vertex numbers.
        """
        self._pin_exactly(np.union1d(self._pinned, self._existing(vertices, "pin")))

    def unpin(self, vertices: Sequence[int] | np.ndarray | None = None) -> None:
        """Let pinned vertices go, all of them by default.

        Raises:
            MeshError: a vertex does not exist, or these are no vertex numbers.
        """
        gone = self._pinned if vertices is None else self._existing(vertices, "unpin")
        self._pin_exactly(np.setdiff1d(self._pinned, gone))

    def initial_state(self, pose: Pose | None = None) -> State:
        """The cloth at rest in its rest shape, placed by ``pose``.

        Raises:
            SettingError: that is no pose.
        """
        pose = Pose() if pose is None else pose
        check_kind("pose", pose, Pose, "Pose((x, y, z)) (m)")
        position = np.ascontiguousarray(pose.apply(self.mesh.rest_position))
        return State(position, np.zeros_like(position), obstacles={n: o.pose for n, o in self.obstacles.items()})

    def prepare(self, state: State | None = None) -> None:
        """Do now what would else be done when it happens for the first time, so that no step is slower than others.

        W is computed, and kernels are compiled, or loaded if they are cached on disk: by a step of this cloth, whose
        result is thrown away, and by a rehearsal of all that a small one of its kind can meet with. That is done once
        in a process: in less than a second, but in half a minute where nothing has been compiled yet.

        Args:
            state: to try the step from; :meth:`initial_state` by default.

        Raises:
            MeshError: the mesh, the material and the substep cannot be computed together.
        """
        before, model = self.report, self._prepared()
        fields = len(model.contacts.fields) > 0
        for kind in kinds(self.mesh, self.material, self.config, model.precisions, fields):
            rehearse(kind, ClothSolver)
        self.step(state or self.initial_state(), Inputs())
        self.report = before

    def step(
        self,
        state: State,
        inputs: Inputs,
        out_of_time: Callable[[], bool] | None = None,
        sweeps: Sequence[int] | None = None,
    ) -> State:
        """Advance by one step of ``config.dt``; ``state`` is left untouched.

        Args:
            state: where the cloth is.
            inputs: what acts on it; obstacle poses and grasps are those at the end of the step.
            out_of_time: the caller's clock, asked between substeps; once true, the rest get one pass each.
            sweeps: passes per substep of an earlier run, to repeat it whatever the clock said then.

        Raises:
            InputError: an obstacle that this solver does not have, ``sweeps`` of another length, or a state that
                is not finite, beyond ``FARTHEST`` or ``FASTEST`` of :mod:`cloth_core.state`, or not of this cloth
                and its obstacles.
        """
        check_arguments(state, inputs, sweeps, self.mesh, self.obstacles, self.substeps, self.grippers)
        state, model = with_plain_arrays(state), self._prepared()
        after = {**state.obstacles, **inputs.obstacles}
        grips, pinches = self._pinched(state, after)
        grasps = {**inputs.grasps, **{name: pinch.grasp for name, pinch in pinches.items()}}
        between = {name: pinch.between for name, pinch in pinches.items()}
        grips = update_grips(grips, grasps, state.position, self._pinned, between)
        empty = tuple(name for name, grip in grips.items() if _closed_on_nothing(state.grips.get(name), grip))
        followed = follow(grips, grasps, self.config, self._reach, state.position, self._pinned)
        hands = Hands(followed, grasps, self.config, self.substeps, pinches)
        held = self._hold(model, followed.grips)
        model.contacts.give(
            {finger: pinch.gap for name, pinch in pinches.items() for finger in self._fingers[name].names}
        )
        teleported = model.contacts.begin_step(state.obstacles, after)
        capped = flow_at(state.position, inputs.wind, state.time, self.config.max_wind_speed, self._flow)
        model.wakes.shelter(state.position, inputs.wind, self._flow)

        passes = Passes(self.sweeps, sweeps, out_of_time)
        fluids = regions_of(inputs.fluids, self.material)
        motion = self._substeps.play(state, hands, held, self._flow, inputs.gravity, passes, fluids)
        layers, recovered = model.self_contacts, not motion.is_sound
        if recovered:
            motion = motion.undone(state)
        reaction = motion.reaction
        wrenches = hands.wrenches(motion.position, held, reaction)
        if BY_NAME[self.config.integrator].restrained:
            hands.bear(wrenches)
        grips_after, slips = hands.end()
        pins = np.searchsorted(held, self._pinned)
        self.report = StepReport(
            sweeps=motion.sweeps,
            residual=motion.excess,
            max_stretch=self._largest_stretch(motion.position),
            contacts=model.contacts.touching,
            self_contacts=0 if layers is None else layers.touching,
            crossings=0 if layers is None else layers.crossings,
            held=len(held),
            out_of_time=passes.out_of_time,
            wind_capped=capped,
            teleported=tuple(teleported),
            slowed=followed.slowed,
            taut=followed.taut,
            slips=slips,
            empty=empty,
            grasp_wrenches=wrenches,
            pin_wrench=Wrench.of(reaction[pins], motion.position[self._pinned]),
            obstacle_wrenches={
                name: Wrench(tuple(row[:3]), tuple(row[3:]))
                for name, row in zip(model.contacts.names, motion.pressure.tolist(), strict=True)
            },
            restrained=motion.restrained,
            recovered=recovered,
        )
        return State(
            position=motion.position,
            velocity=motion.velocity,
            step_index=state.step_index + 1,
            time=state.time + self.config.dt,
            grips=grips_after,
            obstacles=after,
            history=motion.history,
        )

    def snapshot(self, state: State) -> dict[str, np.ndarray]:
        """All that it takes to go on bit-equal from here, as named arrays."""
        return {**state.as_arrays(), "pinned": self._pinned}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> State:
        """Back to a :meth:`snapshot` of a solver of the same mesh, material and config.

        Raises:
            MeshError: the snapshot is of another mesh.
            InputError: it is damaged: an array is missing, has another shape, or holds what no state may hold. The
                solver is as it was then.
        """
        state = State.from_arrays(arrays)
        if state.position.ndim == 2 and len(state.position) != self.mesh.vertex_count:
            raise MeshError(f"the snapshot has {len(state.position)} vertices, this cloth {self.mesh.vertex_count}")
        check_state(state, self.mesh, self.obstacles)
        pinned = self._existing(entry(arrays, "pinned"), "restore pins at")
        if not np.array_equal(pinned, self._pinned):
            self._pin_exactly(pinned)
        return state

    def _existing(self, vertices: Sequence[int] | np.ndarray, purpose: str) -> np.ndarray:
        """Numbers of vertices, as int64."""
        given, last = np.asarray(vertices).ravel(), self.mesh.vertex_count - 1
        whole = given.dtype.kind in "iu" or len(given) == 0
        if not whole or ((given < 0) | (given > last)).any():
            hint = "; mesh.group(name) gives those of a group" if given.dtype.kind == "U" else ""
            raise MeshError(f"cannot {purpose} {given.tolist()[:8]}: vertices are whole numbers from 0 to {last}{hint}")
        return given.astype(np.int64)

    def _pin_exactly(self, vertices: np.ndarray) -> None:
        self._pinned = vertices.astype(np.int32)
        self._model, self._plans = None, Plans()

    def _prepared(self) -> Model:
        if self._model is None:
            h = self.config.dt / self.substeps
            check_stiffness(self.mesh, self.material, h)
            self._model = Model(
                self.mesh, self.material, self.config, self.obstacles,
                h=h, pinned=self._pinned, assembly=self._assembly, plans=self._plans,
            )  # fmt: skip
            integrator = BY_NAME[self.config.integrator](self._model, self.substeps)
            self._substeps = Substeps(self._model, integrator, self._restraint, self.substeps)
            self._model.hold(np.zeros(0, np.int32), self._pinned)
        return self._model

    def _pinched(self, state: State, poses: Mapping[str, Pose]) -> tuple[dict[str, Grip], dict[str, Pinch]]:
        """The grips that there are, and what grippers do whose fingers stand at ``poses``."""
        grips, pinches = dict(state.grips), {}
        for name, fingers in self._fingers.items():
            grip, pinches[name] = fingers.pinch(grips.get(name), state.position, poses)
            if grip is not None:
                grips[name] = grip
        return grips, pinches

    def _hold(self, model: Model, grips: Mapping[str, Grip]) -> np.ndarray:
        """Tell the model which vertices are held; returns them, pinned and grasped, sorted."""
        parts = [grip.vertex for grip in grips.values() if len(grip.vertex)]
        grasped = np.sort(np.concatenate(parts)).astype(np.int64) if parts else np.zeros(0, np.int64)
        held = np.union1d(self._pinned, grasped)
        if not np.array_equal(grasped, model.grasped):
            model.hold(grasped, held)
        self._restraint.hold((grip.vertex for grip in grips.values()), self._pinned)
        return held

    def _largest_stretch(self, position: np.ndarray) -> float:
        mesh = self.mesh
        return springs.largest_stretch(position, mesh.spring_vertex, mesh.limit_rest, mesh.spring_limited)


def _closed_on_nothing(before: Grip | None, now: Grip) -> bool:
    return now.closed and len(now.vertex) == 0 and not (before is not None and before.closed)
