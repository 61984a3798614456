"""The beginning of a session: the scene exactly as it was simulated, and what it was simulated with.

The attachments are enough to build the same solver again without the scene file, mesh files or
parameters of the machine it ran on: ``scene.yaml`` is the scene as it was written, for people;
``parameters.json`` holds the values that were in force, overrides included; ``mesh.npz`` the mesh, ``obstacles.npz``
those of obstacles.
"""

from __future__ import annotations

import dataclasses
import json
import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from cloth_core import ClothError, ClothMesh, ClothSolver, Inputs, Material, SolverConfig
from cloth_core.fields import Closed
from cloth_core.fields.obstacle import FieldObstacle
from cloth_core.gripper import Gripper
from cloth_core.inputs import pose_as_list, pose_from_list
from cloth_core.obstacles import Obstacle
from cloth_core.scene import Scene
from cloth_core.sections import View
from cloth_core.shapes import SHAPES
from cloth_sim_ros.recording.content import pack, unpack
from cloth_sim_ros.session.errors import SessionError

FORMAT = "1"
METADATA = "cloth_sim"
_GROUP, _PIECE = "group/", "piece/"
_SHAPE_NAMES = {shape: name for name, shape in SHAPES.items()}


def attachments_of(scene: Scene, solver: ClothSolver, parameters: Mapping[str, Any]) -> dict[str, bytes]:
    """What a session carries so that ``scene_from`` gives the scene back; ``parameters`` are the node's, as JSON."""
    in_force = {
        "name": scene.name,
        "material": solver.material.as_mapping(),
        "solver": solver.config.as_mapping(),
        "obstacles": {name: _obstacle_mapping(shape) for name, shape in solver.obstacles.items()},
        "grippers": {name: gripper.as_mapping() for name, gripper in solver.grippers.items()},
        "inputs": scene.inputs.as_mapping(),
        "placement": pose_as_list(scene.placement),
        "pins": list(scene.pins),
        "view": scene.view.as_mapping(),
    }
    document = {"scene": in_force, "parameters": dict(parameters)}
    return {
        "scene.yaml": scene.text.encode(),
        "parameters.json": json.dumps(document, indent=1, default=str).encode(),
        "mesh.npz": pack(_mesh_arrays(solver.mesh)),
        "obstacles.npz": pack(_obstacle_meshes(solver.obstacles)),
    }


def metadata_of(scene: Scene, solver: ClothSolver, namespace: str, record: str) -> dict[str, dict[str, str]]:
    """The session's metadata: versions, platform, and what tells one simulation from another at a glance."""
    about = {
        "format": FORMAT,
        "namespace": namespace,
        "record": record,
        "scene": scene.name,
        "dt": repr(solver.config.dt),
        "integrator": solver.config.integrator,
        "substeps": str(solver.substeps),
        "representation": solver.representation,
        "vertices": str(solver.mesh.vertex_count),
        "mesh_digest": solver.mesh.digest,
    }
    return {METADATA: {**about, **versions()}}


def versions() -> dict[str, str]:
    """What bit-equality depends on beside the inputs: the machine, and the versions of what computes."""
    machine = f"{platform.system()} {platform.machine()}, {_processor()}"
    found = {"machine": machine, "python": platform.python_version()}
    for package in ("cloth_sim_ros", "numpy", "scipy", "numba"):
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "none"
    return found


def _processor() -> str:
    """The processor's model; libraries choose their code by it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or "unknown processor"


def scene_from(attachments: Mapping[str, bytes], about: Mapping[str, str]) -> Scene:
    """The scene as it was simulated; its script is not in the session, what came of it is.

    Raises:
        SessionError: an attachment is missing or damaged, or comes from another version of the format.
    """
    if about.get("format") != FORMAT:
        raise SessionError(f"sessions of format {about.get('format')} are not read here, only format {FORMAT}")
    try:
        mesh = _mesh_from(unpack(attachments["mesh.npz"]))
        values = json.loads(attachments["parameters.json"])["scene"]
        solid = unpack(attachments["obstacles.npz"]) if "obstacles.npz" in attachments else {}
        scene = Scene(
            mesh=mesh,
            material=Material.from_mapping(values["material"]),
            solver=SolverConfig.from_mapping(values["solver"]),
            obstacles={name: _obstacle_from(name, shape, solid) for name, shape in values["obstacles"].items()},
            # Sessions of before carry none: what grippers held in them cannot be computed again.
            grippers={name: Gripper.from_mapping(one) for name, one in values.get("grippers", {}).items()},
            inputs=Inputs.from_mapping(values["inputs"]),
            placement=pose_from_list(values["placement"]),
            pins=tuple(values["pins"]),
            view=View.from_mapping(values["view"]),
            name=values["name"],
            text=attachments["scene.yaml"].decode(),
        )
    except KeyError as error:
        raise SessionError(f"the session carries no {error}") from error
    except (ClothError, ValueError, TypeError) as error:
        raise SessionError(f"what the session says of its scene cannot be used: {error}") from error
    if mesh.digest != about.get("mesh_digest"):
        raise SessionError("the mesh in the session is not the one that was simulated: its digest differs")
    return scene


def _obstacle_mapping(obstacle: Obstacle) -> dict[str, Any]:
    return {_SHAPE_NAMES[type(obstacle)]: obstacle.as_mapping()}


def _obstacle_from(name: str, values: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Obstacle:
    ((shape, settings),) = values.items()
    obstacle = SHAPES[shape].from_mapping(settings)
    if not isinstance(obstacle, FieldObstacle):
        return obstacle
    meshes: dict[str, dict[str, np.ndarray]] = {}
    for key, array in arrays.items():
        owner, part, what = key.split("/")
        if owner == name:
            meshes.setdefault(part, {})[what] = array
    return obstacle.with_meshes({part: Closed(**mesh) for part, mesh in meshes.items()})


def _obstacle_meshes(obstacles: Mapping[str, Obstacle]) -> dict[str, np.ndarray]:
    """Arrays of all meshes of all obstacles, as ``obstacle/part/array``."""
    return {
        f"{name}/{part}/{what}": array
        for name, obstacle in obstacles.items()
        if isinstance(obstacle, FieldObstacle)
        for part, mesh in obstacle.meshes.items()
        for what, array in mesh._asdict().items()
    }


def _mesh_arrays(mesh: ClothMesh) -> dict[str, np.ndarray]:
    found = {known.name: getattr(mesh, known.name) for known in dataclasses.fields(mesh)}
    arrays = {name: value for name, value in found.items() if isinstance(value, np.ndarray)}
    named = {_GROUP + name: members for name, members in mesh.groups.items()}
    return {**arrays, **named, **{_PIECE + name: members for name, members in mesh.pieces.items()}}


def _mesh_from(arrays: Mapping[str, np.ndarray]) -> ClothMesh:
    named: dict[str, dict[str, np.ndarray]] = {_GROUP: {}, _PIECE: {}}
    own = {}
    for name, array in arrays.items():
        kind = next((kind for kind in named if name.startswith(kind)), "")
        (named[kind] if kind else own)[name[len(kind) :]] = array
    return ClothMesh(**own, groups=named[_GROUP], pieces=named[_PIECE])
