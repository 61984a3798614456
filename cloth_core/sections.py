"""The sections of a scene file, and how each is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from cloth_core.config import SolverConfig
from cloth_core.errors import InputError, MeshError, SettingError
from cloth_core.fluids import Fluid
from cloth_core.gripper import Gripper
from cloth_core.inputs import Grasp, Inputs, Wind
from cloth_core.material import Material
from cloth_core.mesh import ClothMesh
from cloth_core.obstacles import Obstacle, read_shape
from cloth_core.pose import Pose
from cloth_core.script import Script
from cloth_core.settings import Settings, check_keys, setting
from cloth_core.shapes import SHAPES

_Part = TypeVar("_Part")
PIECE = ("grid", "mesh", "position", "orientation")
"""What may be said of a cloth."""
NAME_RULE = "a name of letters, digits and underscores that begins with a letter"


@dataclass(frozen=True, slots=True, kw_only=True)
class GridSpec(Settings):
    """A rectangle of cloth."""

    width: float = setting("float", unit="m", low=1e-3, high=1e3, help="extent along x")
    height: float = setting("float", unit="m", low=1e-3, high=1e3, help="extent along y")
    columns: int = setting("int", low=2, high=1000, help="vertices along x")
    rows: int = setting("int", low=2, high=1000, help="vertices along y")


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshFileSpec(Settings):
    """A sheet of cloth from a mesh file."""

    file: str = setting("str", help="path, relative to the scene file")
    scale: float = setting("float", 1.0, unit="m per file unit", low=1e-6, high=1e6, help="size of the file's unit")


@dataclass(frozen=True, slots=True, kw_only=True)
class View(Settings):
    """Where pictures of the scene are taken from."""

    eye: tuple[float, float, float] = setting(
        "vector", (1.6, -2.2, 1.2), size=3, unit="m", help="position of the camera"
    )
    target: tuple[float, float, float] = setting(
        "vector", (0.0, 0.0, 0.5), size=3, unit="m", help="point that it looks at"
    )


def read_sections(values: Any, folder: Path) -> dict[str, Any]:
    """What each section says, by its name.

    Args:
        values: the sections.
        folder: where mesh files are looked up.

    Raises:
        SettingError: a section is unknown, there is no cloth, or a value is wrong; the message names the key path.
    """
    check_keys(values, READERS)
    if "cloth" not in values:
        raise SettingError("cloth", "is missing: a section with grid or mesh, or of several such with names")
    return {key: _read(key, READERS[key], values[key], folder) for key in values}


def _read(key: str, reader: Callable[[Any, Path], _Part], values: Any, folder: Path) -> _Part:
    try:
        return reader(values, folder)
    except SettingError as error:
        raise error.under(key) from None
    except (InputError, MeshError) as error:
        raise SettingError(key, str(error)) from None


def _cloth(values: Any, folder: Path) -> tuple[ClothMesh, Pose]:
    """One cloth and where it stands; of several, by name, the mesh of all, in which they stand where they shall."""
    if not _is_several(values):
        return _piece(values, folder)
    read = _named(values, lambda given: _piece_of_several(given, folder))
    meshes, poses = ({name: part[which] for name, part in read.items()} for which in (0, 1))
    return ClothMesh.joined(meshes, poses), Pose()


def _piece_of_several(values: Any, folder: Path) -> tuple[ClothMesh, Pose]:
    try:
        return _piece(values, folder)
    except (InputError, MeshError) as error:
        raise SettingError("", str(error)) from None


def _is_several(values: Any) -> bool:
    named = isinstance(values, Mapping) and not any(key in PIECE for key in values)
    return named and any(isinstance(part, Mapping) and ("grid" in part or "mesh" in part) for part in values.values())


def _piece(values: Any, folder: Path) -> tuple[ClothMesh, Pose]:
    check_keys(values, PIECE)
    if ("grid" in values) == ("mesh" in values):
        raise SettingError("", "needs either grid or mesh")
    if "grid" in values:
        grid = _read("grid", lambda v, _: GridSpec.from_mapping(v), values["grid"], folder)
        mesh = ClothMesh.grid(width=grid.width, height=grid.height, columns=grid.columns, rows=grid.rows)
    else:
        file = _read("mesh", lambda v, _: MeshFileSpec.from_mapping(v), values["mesh"], folder)
        mesh = ClothMesh.load(folder / file.file, scale=file.scale)
    at = _numbers("position", values.get("position", (0, 0, 0)), 3, "m")
    turned = _numbers("orientation", values.get("orientation", (0, 0, 0, 1)), 4, "(quaternion x, y, z, w)")
    return mesh, Pose(at, turned)  # type: ignore[arg-type]


def _numbers(key: str, given: Any, size: int, unit: str) -> tuple[float, ...]:
    good = isinstance(given, (list, tuple)) and len(given) == size
    if not good or not all(type(n) in (int, float) and abs(n) <= 1e300 for n in given):
        raise SettingError(key, f"{given!r} is not {size} finite numbers {unit}")
    return tuple(float(n) for n in given)


def _gravity(values: Any, folder: Path) -> tuple[float, float, float]:
    return Inputs(gravity=_numbers("", values, 3, "m/s^2")).gravity  # type: ignore[arg-type]


def _material(values: Any, folder: Path) -> Material:
    if isinstance(values, Mapping) and "preset" in values:
        changes = {key: value for key, value in values.items() if key != "preset"}
        check_keys(changes, [name for name, _ in Material.settings()])
        return Material.preset(values["preset"], **changes)
    return Material.from_mapping(values)


def _named(values: Any, read: Callable[[Any], _Part]) -> dict[str, _Part]:
    if not isinstance(values, Mapping):
        raise SettingError("", f"{values!r} is not a section of names")
    parts = {}
    for name, given in values.items():
        if not isinstance(name, str) or not (name.isascii() and name.replace("_", "a").isalnum() and name[0].isalpha()):
            raise SettingError("", f"{name!r} is not {NAME_RULE}")
        try:
            parts[name] = read(given)
        except SettingError as error:
            raise error.under(name) from None
    return parts


def _obstacle(values: Any, folder: Path) -> Obstacle:
    shape, obstacle = read_shape(values, SHAPES)
    obstacle = obstacle.within(folder)
    try:
        obstacle.check()
    except SettingError as error:
        raise error.under(shape) from None
    return obstacle


def _grasp(values: Any) -> Grasp:
    check_keys(values or {}, ("radius", "close_at", "open_at", "slip_distance", "position"))
    at = _numbers("position", (values or {}).get("position", (0, 0, 0)), 3, "m")
    settings = {key: value for key, value in (values or {}).items() if key != "position"}
    return Grasp(pose=Pose(at), **settings)  # type: ignore[arg-type]


def _pins(values: Any, folder: Path) -> tuple[str, ...]:
    if not isinstance(values, list) or not all(isinstance(name, str) for name in values):
        raise SettingError("", f"{values!r} is not a list of vertex groups")
    return tuple(values)


def _group(values: Any) -> list[int]:
    if not isinstance(values, list) or not all(
        isinstance(n, int) and not isinstance(n, bool) and n >= 0 for n in values
    ):
        raise SettingError("", f"{values!r} is not a list of vertex numbers")
    return values


READERS: dict[str, Callable[[Any, Path], Any]] = {
    "cloth": _cloth,
    "material": _material,
    "solver": lambda values, _: SolverConfig.from_mapping(values),
    "obstacles": lambda values, folder: _named(values, lambda given: _obstacle(given, folder)),
    "grippers": lambda values, _: _named(values, Gripper.from_mapping),
    "grasps": lambda values, _: _named(values, _grasp),
    "wind": lambda values, _: Wind.from_mapping(values),
    "fluids": lambda values, _: _named(values, Fluid.from_mapping),
    "gravity": _gravity,
    "groups": lambda values, _: _named(values, _group),
    "pins": _pins,
    "script": lambda values, _: Script.from_mapping(values),
    "view": lambda values, _: View.from_mapping(values),
}
"""The sections of a scene file and what reads each."""
