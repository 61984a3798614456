"""What a step may be given: refused where it makes no sense, and brought into the one form that kernels know."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from cloth_core.config import SolverConfig
from cloth_core.errors import InputError, MeshError, shown
from cloth_core.inputs import REST_SCALE, Inputs
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.anchoring import PREFIX
from cloth_core.settings import check_kind, check_named
from cloth_core.state import FARTHEST, FASTEST, Grip, State

TIGHTEST = 1e12
"""N, or J of a triangle: more than any material and mesh gives its threads."""


def check_parts(mesh: object, material: object, config: object, obstacles: object) -> None:
    """Refuse what no solver can be made of.

    Raises:
        SettingError: naming the argument, what it is, and what to write instead.
    """
    check_kind("mesh", mesh, ClothMesh, "ClothMesh.grid(...), ClothMesh.load(path) or ClothMesh.from_trimesh(...)")
    named = f"Material.preset({material!r})" if isinstance(material, str) else "Material(areal_density=0.2)"
    check_kind("material", material, Material, named)
    check_kind("config", config, SolverConfig, "SolverConfig(dt=0.02)")
    check_named("obstacles", obstacles, Obstacle, "Sphere(radius=0.1)")


def check_arguments(
    state: State,
    inputs: Inputs,
    sweeps: Sequence[int] | None,
    mesh: ClothMesh,
    obstacles: Collection[str],
    substeps: int,
    grippers: Collection[str] = (),
) -> None:
    """Refuse what :meth:`ClothSolver.step` cannot use.

    Args:
        state: of the cloth.
        inputs: of the step.
        sweeps: passes to repeat, one number for every substep, or None.
        mesh: the cloth.
        obstacles: the names that there are.
        substeps: in a step.
        grippers: names that no grasp may have.

    Raises:
        InputError: naming the vertices, the obstacles, the grasps, the groups or the numbers.
    """
    check_state(state, mesh, obstacles)
    if not isinstance(inputs, Inputs):
        raise InputError(f"inputs: {shown(inputs)} is not of the type Inputs; write Inputs(wind=..., grasps=...)")
    unknown = inputs.obstacles.keys() - set(obstacles)
    if unknown:
        known = ", ".join(obstacles) or "none"
        raise InputError(f"no obstacle {', '.join(sorted(unknown))}; this scene has {known}")
    _check_groups("groups", inputs.groups, mesh)
    _check_groups("rest_scale", inputs.rest_scale, mesh)
    reserved = [name for name in inputs.grasps if name.startswith(PREFIX)]
    if reserved:
        raise InputError(f"grasps: {reserved[0]!r} begins with {PREFIX!r}, as the names of moved groups do")
    double = inputs.grasps.keys() & set(grippers)
    if double:
        raise InputError(f"grasps: {', '.join(sorted(double))} is a gripper of two obstacles; move those")
    if sweeps is not None and len(sweeps) != substeps:
        raise InputError(f"{len(sweeps)} sweep counts for {substeps} substeps")
    if sweeps is not None and not all(isinstance(count, (int, np.integer)) and count >= 1 for count in sweeps):
        raise InputError(f"sweep counts {list(sweeps)[:8]} must be whole numbers of at least 1")


def _check_groups(what: str, names: Collection[str], mesh: ClothMesh) -> None:
    unknown = set(names) - mesh.groups.keys()
    if unknown:
        known = ", ".join(sorted(mesh.groups)) or "none"
        raise InputError(f"{what}: no vertex group {', '.join(sorted(unknown))}; this cloth has {known}")


def check_vertices(vertices: Sequence[int] | np.ndarray, count: int, purpose: str) -> np.ndarray:
    """Numbers of vertices of a cloth that has ``count`` of them, as int64.

    Raises:
        MeshError: some do not exist, or these are no vertex numbers; it says for what ``purpose``.
    """
    given, last = np.asarray(vertices).ravel(), count - 1
    whole = given.dtype.kind in "iu" or len(given) == 0
    if not whole or ((given < 0) | (given > last)).any():
        hint = "; mesh.group(name) gives those of a group" if given.dtype.kind == "U" else ""
        raise MeshError(f"cannot {purpose} {given.tolist()[:8]}: vertices are whole numbers from 0 to {last}{hint}")
    return given.astype(np.int64)


def check_state(state: State, mesh: ClothMesh, obstacles: Collection[str]) -> None:
    """Refuse a state that is none of this cloth among these ``obstacles``, or beyond all bounds.

    Raises:
        InputError: naming what of the state, and the vertices.
    """
    if not isinstance(state, State):
        raise InputError(f"state: {shown(state)} is not of the type State; begin with initial_state()")
    vertices = (mesh.vertex_count, 3)
    _check_numbers("position", state.position, [vertices], FARTHEST, "m")
    _check_numbers("velocity", state.velocity, [vertices], FASTEST, "m/s")
    of_threads = [mesh.spring_rest.shape, (len(mesh.triangles), 2)]
    remembered = {"lag": ([vertices], FASTEST, "m/s"), "tension": (of_threads, TIGHTEST, "N")}
    for name, values in state.history.items():
        if name not in remembered:
            raise InputError(f"state.history: {name!r} is unknown; allowed are {', '.join(remembered)}")
        _check_numbers(f"history/{name}", values, *remembered[name])
    _check_groups("state.rest_scale", state.rest_scale, mesh)
    for name, scale in state.rest_scale.items():
        if not REST_SCALE.low <= scale <= REST_SCALE.high:
            raise InputError(f"state.rest_scale.{name}: {scale} is not {REST_SCALE.allowed}")
    _check_groups("state.grips", [n[len(PREFIX) :] for n in state.grips if n.startswith(PREFIX)], mesh)
    for name, grip in state.grips.items():
        _check_grip(name, grip, mesh.vertex_count)
    if not 0.0 <= state.time < math.inf or state.step_index < 0:
        raise InputError(f"state: step {state.step_index} at {state.time} s; allowed are finite numbers of at least 0")
    lost = set(obstacles) - state.obstacles.keys()
    if lost:
        names = ", ".join(sorted(lost))
        raise InputError(f"the state does not say where {names} stands: begin with initial_state()")


def _check_numbers(name: str, values: object, shapes: Sequence[tuple[int, ...]], most: float, unit: str) -> None:
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiu":
        raise InputError(f"state.{name}: {shown(values)} is not an array of numbers ({unit})")
    if values.shape not in shapes:
        allowed = " or ".join(map(str, shapes))
        raise InputError(f"state.{name}: the shape {values.shape} is not that of this cloth, {allowed} ({unit})")
    good = np.abs(values) <= most
    if not good.all():
        wrong = np.flatnonzero(~good.reshape(len(good), -1).all(axis=1))
        raise InputError(f"state.{name}: not finite or beyond +-{most:g} {unit} in the rows {wrong[:8].tolist()}")


def _check_grip(name: str, grip: Grip, vertex_count: int) -> None:
    """A grip holds vertices of the cloth, each once, in order, at finite places within its frame."""
    vertex, offset = np.asarray(grip.vertex), np.asarray(grip.offset)
    whole = vertex.ndim == 1 and vertex.dtype.kind in "iu"
    if not whole or (np.diff(vertex, prepend=-1) <= 0).any() or (vertex >= vertex_count).any():
        allowed = f"vertices in rising order, whole numbers from 0 to {vertex_count - 1}"
        raise InputError(f"state.grips.{name}: holds {shown(vertex.tolist())}; allowed are {allowed}")
    if offset.shape != (len(vertex), 3) or not (np.abs(offset) <= FARTHEST).all():
        allowed = f"rows of 3 numbers within +-{FARTHEST:g} m for its {len(vertex)} vertices"
        raise InputError(f"state.grips.{name}: its offsets, of the shape {offset.shape}, are not {allowed}")


def with_plain_arrays(state: State) -> State:
    """The same state; positions and velocities that are not float64, row by row and writable are copied.

    Read-only arrays are another type to numba: a step from them would compile every kernel anew.
    """
    position, velocity = (np.require(array, np.float64, "CAW") for array in (state.position, state.velocity))
    if position is state.position and velocity is state.velocity:
        return state
    return replace(state, position=position, velocity=velocity)
