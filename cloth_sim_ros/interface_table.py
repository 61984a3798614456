"""The node's topics, services and parameters as a page for people.

``python -m cloth_sim_ros.interface_table > docs/interfaces.md`` writes it; a test tells when it is out of date.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

from cloth_core.settings import Setting
from cloth_sim_ros import interfaces
from cloth_sim_ros.interfaces import Interface
from cloth_sim_ros.parameters import FIXED, GROUPS, full_name
from cloth_sim_ros.session import Qos

_INTRODUCTION = """\
# Topics, services and parameters of the node

Generated from what the node itself is built from: `python -m cloth_sim_ros.interface_table > docs/interfaces.md`.

Names are relative to the node, `/cloth_sim` unless it is told otherwise. `<name>` is a name that the scene declares.
SI units; angles in rad; quaternions x, y, z, w. Every topic can be remapped, and its quality of service overruled by
parameters on its full, remapped name: `-p qos_overrides./cloth_sim/cloth/points.publisher.reliability:=best_effort`
(`history`, `depth`, `reliability`, `durability`; `subscription` for inputs).
"""
_PARAMETERS = """\
Those marked fixed are read once, when the node is configured. All others may be changed while it runs
(`ros2 param set /cloth_sim material.friction 0.6`): a wrong value is refused with the reason, and a good one is in
force from one step to the next, as soon as what it asks for has been computed beside the steps. What was changed,
and at which step, stands in the session. `config/cloth.yaml` is a parameter file with all of them.
"""


def as_page() -> str:
    """The page, in Markdown."""
    parts = [
        _INTRODUCTION,
        "## Inputs\n",
        _table(("topic", "type", "QoS", "meaning"), _topics(interfaces.INPUTS)),
        "\n## Outputs\n",
        _table(("topic", "type", "QoS", "meaning"), _topics(interfaces.OUTPUTS)),
        "\n## Services\n",
        _table(("service", "type", "meaning"), ((_name(i), _type(i), i.meaning) for i in interfaces.SERVICES)),
        "\n## Parameters\n",
        _PARAMETERS,
        _table(("parameter", "default", "allowed", "meaning"), _parameters()),
    ]
    return "\n".join(parts) + "\n"


def _topics(those: Sequence[Interface]) -> Iterable[tuple[str, ...]]:
    return ((_name(i), _type(i), _quality(i.qos), i.meaning) for i in those)


def _name(interface: Interface) -> str:
    return f"`{interface.name.replace('{name}', '<name>')}`"


def _type(interface: Interface) -> str:
    return f"`{interface.type_name.replace('/msg/', '/').replace('/srv/', '/')}`"


def _quality(qos: Qos | None) -> str:
    assert qos is not None
    latched = ", latched" if qos.durability == "transient_local" else ""
    return f"{qos.reliability.replace('_', ' ')}, depth {qos.depth}{latched}"


def _parameters() -> Iterable[tuple[str, ...]]:
    for prefix, kind in GROUPS.items():
        defaults = {field.name: field.default for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
        for name, known in kind.settings():
            full = full_name(prefix, name)
            yield f"`{full}`", _default(prefix, defaults[name]), _allowed(full, known), known.help


def _default(prefix: str, value: object) -> str:
    shown = "" if value in ("", ()) else f"`{str(value).lower() if isinstance(value, bool) else value}`"
    return f"{shown} or the scene's" if prefix else shown


def _allowed(full: str, known: Setting) -> str:
    return known.allowed + ("; fixed" if full in FIXED else "")


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


if __name__ == "__main__":
    print(as_page(), end="")
