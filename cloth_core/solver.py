"""ClothSolver: one step is one page of the paper."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cloth_core.arguments import check_arguments, check_parts, check_state, check_vertices, with_plain_arrays
from cloth_core.config import SolverConfig
from cloth_core.errors import MeshError
from cloth_core.gripper import Gripper, check_grippers
from cloth_core.holding import Holding
from cloth_core.inputs import Inputs
from cloth_core.integrators import BY_NAME, Model
from cloth_core.kernels import springs
from cloth_core.linear import Assembly, Plans
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.drag import flow_at
from cloth_core.physics.immersion import regions_of
from cloth_core.physics.rest_scale import RestScale, RestShape
from cloth_core.physics.stiffness import check_stiffness
from cloth_core.physics.ways import Ways
from cloth_core.pose import Pose
from cloth_core.rehearsal import kinds, rehearse
from cloth_core.report import StepReport, Wrench
from cloth_core.settings import check_kind
from cloth_core.state import State, entry
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
        self._holding = Holding(self.mesh, material, config, self.obstacles, self.grippers, self._ways)

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

    @property
    def rest(self) -> RestShape:
        """The rest lengths that the last step ended with; those of the mesh before the first one."""
        return self._rest_scale.rest if self._model is not None else RestShape.of(self.mesh)

    def check_rest_scale(self, groups: Sequence[str]) -> None:
        """Refuse groups whose rest lengths cannot be scaled, before a step does.

        Raises:
            MeshError: there is no such group.
            InputError: no spring, or no triangle where these carry the stretching, lies within one.
        """
        RestScale(self.mesh, self.material).check(groups)

    def pin(self, vertices: Sequence[int] | np.ndarray) -> None:
        """Pin further vertices where the state has them. W is computed anew at the next step.

        Raises:
            MeshError: a vertex does not exist, or these are no vertex numbers.
        """
        self._pin_exactly(np.union1d(self._pinned, check_vertices(vertices, self.mesh.vertex_count, "pin")))

    def unpin(self, vertices: Sequence[int] | np.ndarray | None = None) -> None:
        """Let pinned vertices go, all of them by default.

        Raises:
            MeshError: a vertex does not exist, or these are no vertex numbers.
        """
        gone = self._pinned if vertices is None else check_vertices(vertices, self.mesh.vertex_count, "unpin")
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
            InputError: an obstacle or a group that this solver does not have, ``sweeps`` of another length, or a state
                that is not finite, beyond ``FARTHEST`` or ``FASTEST`` of :mod:`cloth_core.state`, or not of this cloth
                and its obstacles.
        """
        check_arguments(state, inputs, sweeps, self.mesh, self.obstacles, self.substeps, self.grippers)
        state, model = with_plain_arrays(state), self._prepared()
        after = {**state.obstacles, **inputs.obstacles}
        hold = self._holding.begin_step(state, inputs, after, self._pinned, self.substeps)
        if not np.array_equal(hold.grasped, model.grasped):
            model.hold(hold.grasped, hold.held)
        model.contacts.give(hold.gaps)
        teleported = model.contacts.begin_step(state.obstacles, after)
        capped = flow_at(state.position, inputs.wind, state.time, self.config.max_wind_speed, self._flow)
        model.wakes.shelter(state.position, inputs.wind, self._flow)

        passes = Passes(self.sweeps, sweeps, out_of_time)
        fluids = regions_of(inputs.fluids, self.material)
        scale = self._rest_scale.begin_step(state.rest_scale, inputs.rest_scale, self.config.dt)
        motion = self._substeps.play(state, hold.hands, hold.held, self._flow, inputs.gravity, passes, fluids)
        layers, recovered = model.self_contacts, not motion.is_sound
        if recovered:
            motion = motion.undone(state)
        wrenches = hold.hands.wrenches(motion.position, hold.held, motion.reaction)
        if BY_NAME[self.config.integrator].restrained:
            hold.hands.bear(wrenches)
        grips, slips = hold.hands.end()
        pins = np.searchsorted(hold.held, self._pinned)
        self.report = StepReport(
            sweeps=motion.sweeps,
            residual=motion.excess,
            max_stretch=self._largest_stretch(motion.position),
            contacts=model.contacts.touching,
            self_contacts=0 if layers is None else layers.touching,
            crossings=0 if layers is None else layers.crossings,
            held=len(hold.held),
            out_of_time=passes.out_of_time,
            wind_capped=capped,
            teleported=tuple(teleported),
            slowed=hold.followed.slowed,
            taut=hold.followed.taut,
            slips=slips,
            empty=hold.empty,
            grasp_wrenches=wrenches,
            pin_wrench=Wrench.of(motion.reaction[pins], motion.position[self._pinned]),
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
            grips=grips,
            obstacles=after,
            rest_scale=scale,
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
        pinned = check_vertices(entry(arrays, "pinned"), self.mesh.vertex_count, "restore pins at")
        if not np.array_equal(pinned, self._pinned):
            self._pin_exactly(pinned)
        return state

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
            told = (self._model.sheet, self._model.limit, self._holding.restraint)
            self._rest_scale = RestScale(self.mesh, self.material, told)
            self._holding.restraint.resize(self._rest_scale.rest)
            self._substeps = Substeps(self._model, integrator, self._holding.restraint, self._rest_scale, self.substeps)
            self._model.hold(np.zeros(0, np.int32), self._pinned)
        return self._model

    def _largest_stretch(self, position: np.ndarray) -> float:
        mesh = self.mesh
        return springs.largest_stretch(position, mesh.spring_vertex, self.rest.limit_rest, mesh.spring_limited)
