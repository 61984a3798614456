"""The node's parameters: its own settings here, ``material.*`` and ``solver.*`` from the core's dataclasses.

``python -m cloth_sim_ros.parameters > config/cloth.yaml`` writes the commented parameter file.
"""

from __future__ import annotations

import dataclasses
import json
import os
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from cloth_core import Material, SettingError, SolverConfig
from cloth_core.settings import Setting, Settings, setting
from cloth_sim_ros.recording.recorder import RECORD
from cloth_sim_ros.simulation.closures import FORM

_Group = TypeVar("_Group", bound=Settings)


@dataclass(frozen=True)
class TextList(Setting):
    """A setting that is a list of texts."""

    @property
    def allowed(self) -> str:
        """The allowed values in words."""
        return "a list of texts"

    def check(self, key: str, value: Any) -> tuple[str, ...]:
        """``value`` as a tuple without empty texts."""
        if (
            isinstance(value, str)
            or not isinstance(value, Iterable)
            or not all(isinstance(text, str) for text in value)
        ):
            raise SettingError(key, f"{value!r} is not {self.allowed} ({self.help})")
        return tuple(text for text in value if text)


def _texts(help: str) -> Any:
    return dataclasses.field(default=(), metadata={"setting": TextList(kind="str", help=help)})


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeSettings(Settings):
    """How the node runs, as opposed to what it simulates."""

    scene: str = setting("str", "scarf", help="path of a scene file, or the name of one that comes with the package")
    frame_id: str = setting("str", "world", help="frame that the cloth is simulated and published in")
    static_transforms: tuple[str, ...] = _texts(
        "frames that messages may come in, each as 'parent child x y z qx qy qz qw' (m, quaternion); "
        "where tf2_ros is installed tf is asked first"
    )
    autostart: bool = setting(
        "bool",
        True,
        help="configure and activate without being told; false leaves that to a lifecycle manager",
    )
    grasp_timeout: float = setting(
        "float",
        0.1,
        unit="s",
        low=0.01,
        high=10.0,
        help="without a pose for so long, a grasp is held in place and reported stale",
    )
    grasp_cutoff: float = setting(
        "float",
        3.0,
        unit="Hz",
        low=0.0,
        high=100.0,
        help="up to here a hand that holds still is followed, so that the jitter of its tracking is not; it rises with "
        "the hand's speed, and the hand is never more than 2 mm and 0.02 rad ahead. 0, and with use_sim_time: poses "
        "are taken as they come",
    )
    closures: tuple[str, ...] = _texts(
        f"closures that come as an axis or button of sensor_msgs/Joy or as a joint of sensor_msgs/JointState, each as "
        f"{FORM}: 'hand ~/joy axis 5 1 -1', 'hand /gripper/joint_states joint finger 0.04 0'"
    )
    rumble_force: float = setting(
        "float",
        5.0,
        unit="N",
        low=0.01,
        high=10000.0,
        help="a change of the force on a hand that makes ~/grasp/<name>/rumble 1",
    )
    wind_pointer_speed: float = setting(
        "float", 4.0, unit="m/s", low=0.0, high=200.0, help="speed of the wind that ~/wind/pose directs"
    )
    mesh_rate: float = setting(
        "float",
        10.0,
        unit="Hz",
        low=0.1,
        high=1000.0,
        help="rate of ~/cloth/mesh above 2500 vertices; below, every step",
    )
    visible_rate: float = setting(
        "float", 10.0, unit="Hz", low=0.1, high=1000.0, help="rate of ~/cloth/visible_points, at most that of the steps"
    )
    time_budget: float = setting(
        "float",
        0.8,
        low=0.1,
        high=1.0,
        help="share of a step's time after which its remaining substeps get one pass each",
    )
    record: str = setting(
        "str",
        "outputs",
        choices=RECORD,
        help="what the session holds. none: there is no session; inputs: all that it takes to compute the run "
        "again bit for bit; outputs: also what was published, bar the marker (4 MB/s for 2500 vertices); "
        "all: the marker as well",
    )
    session_folder: str = setting(
        "str",
        "",
        help="folder in which every run makes a session of its own; empty: $CLOTH_SESSIONS, or ~/.ros/cloth_sessions",
    )

    @property
    def sessions(self) -> Path:
        """The folder that sessions go to, absolute."""
        chosen = self.session_folder or os.environ.get("CLOTH_SESSIONS") or "~/.ros/cloth_sessions"
        return Path(chosen).expanduser().absolute()


GROUPS: dict[str, type[Settings]] = {"": NodeSettings, "material": Material, "solver": SolverConfig}
"""Parameters by prefix; those of the scene are declared with the scene's own values as defaults."""


FIXED = ("scene", "frame_id", "static_transforms", "autostart", "closures", "record", "session_folder", "solver.dt")
"""Parameters that are read once, when the node is configured; all others may be changed while it runs."""


def full_name(prefix: str, name: str) -> str:
    """Name of the parameter ``name`` of a group."""
    return f"{prefix}.{name}" if prefix else name


def grouped(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Values by group and name, from values by full name; names that are in no group are left out."""
    found: dict[str, dict[str, Any]] = {prefix: {} for prefix in GROUPS}
    for full, value in values.items():
        prefix, _, name = full.rpartition(".")
        if full in parameter_names():
            found[prefix][name] = value
    return found


def changed(settings: _Group, prefix: str, values: Mapping[str, Any]) -> _Group:
    """``settings`` with other values.

    Raises:
        SettingError: a value is wrong; the message names the parameter in full, and says what would be allowed.
    """
    known = dict(settings.settings())
    checked = {name: known[name].check(full_name(prefix, name), value) for name, value in values.items()}
    return dataclasses.replace(settings, **checked)


def parameter_names() -> list[str]:
    """Full names of all parameters."""
    return [full_name(prefix, name) for prefix, kind in GROUPS.items() for name, _ in kind.settings()]


def as_parameter_file() -> str:
    """The commented parameter file that documents every parameter with its default."""
    lines = [
        "# Parameters of cloth_node; generated by: python -m cloth_sim_ros.parameters > config/cloth.yaml",
        "#   ros2 run cloth_sim_ros cloth_node --ros-args --params-file cloth.yaml",
        "# Those marked 'fixed' are read once, when the node is configured; the others can be changed while it runs:",
        "#   ros2 param set /cloth_sim material.friction 0.6",
        "/**:",
        "  ros__parameters:",
    ]
    for name, known, value in _defaults(NodeSettings):
        lines += [*_comment(known, name, "    "), f"    {name}: {value}", ""]
    for prefix, kind in GROUPS.items():
        if prefix:
            lines += [
                f"    # What overrules the scene's {prefix}: remove the first # of a line, and of '{prefix}:'.",
                "    # The values here are the defaults where the scene says nothing.",
                f"    # {prefix}:",
            ]
            for name, known, value in _defaults(kind):
                lines += [*_comment(known, f"{prefix}.{name}", "    #   "), f"    #   {name}: {value}"]
            lines += [""]
    return "\n".join(lines).rstrip() + "\n"


def _defaults(kind: type[Settings]) -> Iterable[tuple[str, Setting, str]]:
    """Name, setting and default, as YAML, of every field."""
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for name, known in kind.settings():
        value = fields[name].default
        # An empty list has no type in a parameter file; an empty text in one is ignored.
        text = json.dumps([*value] or [""] if isinstance(value, tuple) else value)
        # Without a point, some YAML readers take 5e-05 for a text.
        yield name, known, text.replace("e-", ".0e-") if known.kind == "float" and "." not in text else text


def _comment(known: Setting, full: str, indent: str) -> list[str]:
    fixed = "; fixed" if full in FIXED else ""
    return textwrap.wrap(
        f"{known.help} ({known.allowed}{fixed})", 100, initial_indent=f"{indent}# ", subsequent_indent=f"{indent}# "
    )


if __name__ == "__main__":
    print(as_parameter_file(), end="")
