"""A scene file: the cloth, its material, how it is computed, and the world around it, validated as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from cloth_core.config import SolverConfig
from cloth_core.errors import SettingError
from cloth_core.gripper import Gripper, check_grippers
from cloth_core.inputs import Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle
from cloth_core.physics.stiffness import check_stiffness
from cloth_core.pose import Pose
from cloth_core.script import Script
from cloth_core.sections import View, read_sections
from cloth_core.solver import ClothSolver
from cloth_core.state import State


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a simulation starts from. :meth:`load` reads it from YAML."""

    mesh: ClothMesh
    placement: Pose = Pose()
    material: Material = Material()
    solver: SolverConfig = SolverConfig()
    obstacles: Mapping[str, Obstacle] = field(default_factory=dict)
    grippers: Mapping[str, Gripper] = field(default_factory=dict)
    """Pairs of obstacles that hold by friction."""
    inputs: Inputs = Inputs()
    """What acts before anyone says otherwise; its grasps are the declared grippers, open."""
    pins: tuple[str, ...] = ()
    """Vertex groups that stay where they are."""
    script: Script = Script()
    view: View = View()
    name: str = "scene"
    text: str = ""
    """The YAML it was read from, for the session."""

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """Read a scene file.

        Raises:
            SettingError: the file cannot be read, or a value in it is wrong; the message names the file,
                the key path, the value, the bound and the unit.
        """
        path = Path(path)
        try:
            text = path.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise SettingError(str(path), f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
        return cls.parse(text, source=str(path), folder=path.parent, name=path.stem)

    @classmethod
    def parse(cls, text: str, *, source: str = "scene", folder: str | Path = ".", name: str = "scene") -> Scene:
        """Read a scene from YAML text; mesh files are looked up from ``folder``."""
        try:
            values = YAML(typ="safe", pure=True).load(text)
        except YAMLError as error:
            raise SettingError(source, f"is not valid YAML: {_yaml_problem(error)}") from None
        try:
            return cls._from_mapping(values, Path(folder), name, text)
        except SettingError as error:
            raise error.read_from(source) from None

    @classmethod
    def _from_mapping(cls, values: Any, folder: Path, name: str, text: str) -> Scene:
        read = read_sections(values, folder)
        mesh, placement = read.pop("cloth")
        named = read.pop("groups", {})
        for group, members in named.items():
            if max(members, default=0) >= mesh.vertex_count:
                raise SettingError(f"groups.{group}", f"vertex {max(members)} is not 0 .. {mesh.vertex_count - 1}")
            mesh.groups[group] = np.array(members, np.int32)  # type: ignore[index]
        for group in read.get("pins", ()):
            if group not in mesh.groups:
                raise SettingError(
                    "pins", f"no vertex group {group!r}; this cloth has {', '.join(sorted(mesh.groups)) or 'none'}"
                )
        script: Script = read.get("script", Script())
        for part, declared in (("obstacles", read.get("obstacles", {})), ("grasps", read.get("grasps", {}))):
            for unknown in getattr(script, part).keys() - declared.keys():
                raise SettingError(f"script.{part}.{unknown}", f"the scene declares no such name under {part}")
        check_grippers(read.get("grippers", {}), read.get("obstacles", {}))
        for double in read.get("grippers", {}).keys() & read.get("grasps", {}).keys():
            raise SettingError(f"grippers.{double}", "there is a grasp of that name already")
        inputs = Inputs(
            grasps=read.pop("grasps", {}),
            wind=read.pop("wind", Wind()),
            fluids=read.pop("fluids", {}),
            gravity=read.pop("gravity", Inputs().gravity),
        )
        return cls(mesh=mesh, placement=placement, inputs=inputs, name=name, text=text, **read)

    def build(self) -> tuple[ClothSolver, State]:
        """A solver with the scene's pins, and the state that it starts from.

        Raises:
            MeshError: mesh, material and step, each in its range, cannot be computed together.
        """
        solver = ClothSolver(self.mesh, self.material, self.solver, obstacles=self.obstacles, grippers=self.grippers)
        check_stiffness(self.mesh, self.material, self.solver.dt / solver.substeps)
        for group in self.pins:
            solver.pin(self.mesh.group(group))
        return solver, solver.initial_state(self.placement)


def _yaml_problem(error: YAMLError) -> str:
    """What is wrong and on which line, without the library's advice to programmers."""
    mark = getattr(error, "problem_mark", None)
    problem = getattr(error, "problem", None) or str(error).splitlines()[0]
    return f"{problem} (line {mark.line + 1})" if mark else str(problem)
