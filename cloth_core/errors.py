"""Errors that say where the bad value stands, what it is and what would be allowed."""

from __future__ import annotations

from typing import Any


def shown(value: Any, most: int = 60) -> str:
    """``value`` for a message: on one line, and cut where it is long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= most else text[: most - 3] + "..."


class ClothError(ValueError):
    """Base of every error that this package raises on purpose."""


class SettingError(ClothError):
    """A setting has a wrong name, type, unit or range.

    Args:
        key: dotted path of the setting, for example ``material.areal_density``.
        problem: what is wrong and what would be right, value, range and unit included.
        source: file, topic or call that the setting came from; may be empty.
    """

    def __init__(self, key: str, problem: str, source: str = "") -> None:
        self.key = key
        self.problem = problem
        self.source = source
        super().__init__(": ".join(part for part in (source, key, problem) if part))

    def under(self, prefix: str) -> SettingError:
        """The same error, seen from the section ``prefix`` that holds the setting."""
        return SettingError(f"{prefix}.{self.key}" if self.key else prefix, self.problem, self.source)

    def read_from(self, source: str) -> SettingError:
        """The same error, naming the file or topic that the setting was read from."""
        return SettingError(self.key, self.problem, source)


class MeshError(ClothError):
    """A mesh makes no physical sense; the message names the elements."""


class InputError(ClothError):
    """A value given to one step (a pose, a wind, a closure) cannot be used."""


class MeshWarning(UserWarning):
    """A mesh file had faults that could be mended; the message names the file, the elements and what was done."""
