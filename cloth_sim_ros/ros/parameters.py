"""Declares the fields of settings dataclasses as ROS parameters and reads them back, checked."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from cloth_core import SettingError
from cloth_core.settings import Setting, Settings
from cloth_sim_ros.parameters import FIXED, full_name, grouped

_Section = TypeVar("_Section", bound=Settings)
_LARGEST_INT = 2**63 - 1


def declare(node: Node, defaults: _Section, prefix: str = "") -> _Section:
    """Declare every field of ``defaults`` as a parameter; returns the values in force.

    Raises:
        SettingError: an override is wrong; the message names parameter, value, range and unit.
    """
    values = {}
    for name, known in defaults.settings():
        values[name] = _declare_one(node, full_name(prefix, name), known, getattr(defaults, name))
    return type(defaults)(**values)


def warn_of_unknown(node: Node, known: Iterable[str]) -> None:
    """Say which parameters were given to the node that it does not have: most likely misspelt."""
    known = list(known)
    # rclpy keeps what was given but not declared to itself.
    for name in getattr(node, "_parameter_overrides", {}):
        if name not in known and not node.has_parameter(name) and not name.startswith("qos_overrides."):
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            node.get_logger().warning(f"parameter {name}: there is no such parameter, it is ignored{hint}")


Groups = dict[str, dict[str, Any]]


def on_change(node: Node, check: Callable[[Groups], None], apply: Callable[[Groups], None]) -> Callable[[], None]:
    """From now on, have changes judged by ``check`` and then carried out by ``apply``; returns what ends that.

    Both get values by group and name. What ``check`` raises as a SettingError is the reason that is given.
    """

    def judge(given: list[Parameter]) -> SetParametersResult:
        try:
            check(grouped({parameter.name: parameter.value for parameter in given}))
        except SettingError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def carry_out(given: list[Parameter]) -> None:
        apply(grouped({parameter.name: parameter.value for parameter in given}))

    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(carry_out)

    def end() -> None:
        node.remove_on_set_parameters_callback(judge)
        node.remove_post_set_parameters_callback(carry_out)

    return end


def set_silently(node: Node, values: Mapping[str, Any]) -> None:
    """Have parameters show these values."""
    node.set_parameters([Parameter(name, value=_to_ros(value)) for name, value in values.items()])


def _declare_one(node: Node, name: str, known: Setting, default: Any) -> Any:
    if not node.has_parameter(name):
        # First without type and range: rclpy's own refusal would not name the unit and what is meant.
        node.declare_parameter(name, _to_ros(default), ParameterDescriptor(dynamic_typing=True))
    given = node.get_parameter(name).value
    value = known.check(name, given)
    if node.describe_parameter(name).dynamic_typing:
        parameter = Parameter(name, value=_to_ros(value))
        node.set_parameters([parameter])
        node.set_descriptor(name, _descriptor(parameter, known))
    return value


def _to_ros(value: Any) -> Any:
    # rclpy cannot tell the type of an empty list.
    return (list(value) or [""]) if isinstance(value, tuple) else value


def _descriptor(parameter: Parameter, known: Setting) -> ParameterDescriptor:
    unit = f", {known.unit}" if known.unit else ""
    descriptor = ParameterDescriptor(name=parameter.name, description=f"{known.help}{unit}")
    descriptor.read_only = parameter.name in FIXED
    descriptor.type = parameter.type_.value
    descriptor.additional_constraints = known.allowed
    bounds = (max(known.low, -sys.float_info.max), min(known.high, sys.float_info.max))
    if known.kind == "float":
        descriptor.floating_point_range = [FloatingPointRange(from_value=float(bounds[0]), to_value=float(bounds[1]))]
    elif known.kind == "int":
        low, high = (int(max(-_LARGEST_INT, min(_LARGEST_INT, bound))) for bound in bounds)
        descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
    return descriptor
