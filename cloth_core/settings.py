"""One truth per setting: default, bound, unit and sentence live in the field that holds the value.

Constructors, scene files, ROS parameters, error messages and documentation all read the same
:class:`Setting`, so they cannot disagree.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from cloth_core.errors import SettingError, shown

_Section = TypeVar("_Section", bound="Settings")
NEAR = 0.75
"""Likeness from which one name is taken for another misspelt."""


@dataclass(frozen=True)
class Setting:
    """What is known of one setting beside its value.

    ``kind`` is ``float``, ``int``, ``bool``, ``str`` or ``vector`` (a tuple of ``size`` floats);
    the bounds hold for each component.
    """

    kind: str
    help: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    choices: tuple[str, ...] = ()
    size: int = 0
    optional: bool = False

    @property
    def allowed(self) -> str:
        """The allowed values in words, unit included."""
        if self.choices:
            return "one of " + ", ".join(self.choices)
        if self.kind in ("bool", "str"):
            return {"bool": "true or false", "str": "a text"}[self.kind]
        low = "" if math.isinf(self.low) else f"{self.low:g}"
        high = "" if math.isinf(self.high) else f"{self.high:g}"
        span = f"{low} .. {high}" if low and high else f"at least {low}" if low else f"at most {high}" if high else ""
        noun = {"float": "a number", "int": "a whole number", "vector": f"{self.size} numbers"}[self.kind]
        return " ".join(part for part in (noun, span, self.unit) if part)

    def check(self, key: str, value: Any) -> Any:
        """``value`` in its own type, or a :class:`SettingError` that says what would be allowed."""
        if value is None and self.optional:
            return None
        try:
            checked = _CONVERT[self.kind](value)
        except (TypeError, ValueError, OverflowError):
            raise SettingError(key, f"{value!r} is not {self.allowed} ({self.help})") from None
        if self.choices and checked not in self.choices:
            raise SettingError(key, f"{value!r} is not {self.allowed} ({self.help})")
        if self.kind == "vector" and len(checked) != self.size:
            raise SettingError(key, f"{value!r} has {len(checked)} components, not {self.allowed} ({self.help})")
        numbers = checked if self.kind == "vector" else (checked,) if self.kind in ("float", "int") else ()
        if not all(self.low <= n <= self.high and abs(n) < math.inf for n in numbers):
            raise SettingError(key, f"{value!r} is out of range: {self.allowed} ({self.help})")
        return checked


def _number(value: Any) -> float:
    if isinstance(value, (bool, str)):
        raise TypeError
    return float(value)


def _whole(value: Any) -> int:
    if isinstance(value, (bool, str)) or value != int(value):
        raise TypeError
    return int(value)


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise TypeError
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError
    return value


def _vector(value: Any) -> tuple[float, ...]:
    if isinstance(value, str):
        raise TypeError
    return tuple(_number(component) for component in value)


_CONVERT = {"float": _number, "int": _whole, "bool": _flag, "str": _text, "vector": _vector}


def setting(kind: str, default: Any = dataclasses.MISSING, *, help: str, **bounds: Any) -> Any:
    """A dataclass field that carries its :class:`Setting`; keywords are those of :class:`Setting`."""
    metadata = {"setting": Setting(kind=kind, help=help, optional=default is None, **bounds)}
    return dataclasses.field(default=default, metadata=metadata)


class Settings:
    """Base of the frozen, keyword-only dataclasses whose fields come from :func:`setting`."""

    __slots__ = ()

    def __new__(cls, *unnamed: Any, **values: Any) -> Settings:
        """Refuse what has no name, or one that there is not, in the words of all settings."""
        known, call = [field.name for field in dataclasses.fields(cls)], f"{cls.__name__}()"  # type: ignore[arg-type]
        if unnamed:
            raise SettingError("", f"{shown(unnamed[0])} has no name; known keys: {', '.join(known)}", call)
        try:
            check_keys(values, known)
        except SettingError as error:
            raise error.read_from(call) from None
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for name, known in self.settings():
            object.__setattr__(self, name, known.check(name, getattr(self, name)))

    @classmethod
    def settings(cls) -> Iterator[tuple[str, Setting]]:
        """Name and :class:`Setting` of every field, in the order of declaration."""
        for field in dataclasses.fields(cls):  # type: ignore[arg-type]
            if "setting" in field.metadata:
                yield field.name, field.metadata["setting"]

    @classmethod
    def from_mapping(cls: type[_Section], values: Mapping[str, Any]) -> _Section:
        """Build from a mapping, for example a section of a YAML file.

        Raises:
            SettingError: a key is unknown, missing, or has a wrong type or range.
        """
        known = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
        check_keys(values, known)
        for name, field in known.items():
            if (
                field.default is dataclasses.MISSING
                and field.default_factory is dataclasses.MISSING
                and name not in values
            ):
                raise SettingError(name, f"is missing: {field.metadata['setting'].allowed}")
        return cls(**values)

    def as_mapping(self) -> dict[str, Any]:
        """Plain numbers, texts and lists that :meth:`from_mapping` reads back."""
        mapping = {name: getattr(self, name) for name, _ in self.settings()}
        return {name: list(v) if isinstance(v, tuple) else v for name, v in mapping.items() if v is not None}


def check_keys(values: Any, known: Any) -> None:
    """Refuse anything but a mapping whose keys are all in ``known``; suggests the nearest name."""
    import difflib

    if not isinstance(values, Mapping):
        raise SettingError("", f"{values!r} is not a section with the keys {', '.join(known)}")
    for key in values:
        if key not in known:
            near = difflib.get_close_matches(str(key), list(known), n=1, cutoff=NEAR)
            hint = f"did you mean {near[0]}?" if near else f"known keys: {', '.join(known)}"
            raise SettingError(str(key), f"no such key; {hint}")


def check_kind(key: str, value: Any, kind: type, instead: str) -> None:
    """Refuse a ``value`` of another type; ``instead`` says what would be of that ``kind``."""
    if not isinstance(value, kind):
        raise SettingError(key, f"{shown(value)} is not of the type {kind.__name__}; write {instead}")


def check_named(key: str, values: Any, kind: type, instead: str) -> None:
    """Refuse anything but a mapping from names to values of that ``kind``."""
    if not isinstance(values, Mapping):
        raise SettingError(key, f"{shown(values)} does not map names to values; write {{'name': {instead}}}")
    for name, value in values.items():
        if not isinstance(name, str) or not name:
            raise SettingError(key, f"{shown(name)} is no name; allowed are texts that are not empty")
        check_kind(f"{key}.{name}", value, kind, instead)
