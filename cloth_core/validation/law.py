"""What a law of physics is to this package: a scene, a closed form, and how far the two may differ."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

INTEGRATORS = ("implicit_midpoint", "meyer2000")
# For what does not depend on the integrator: areas, masses, energies.
GEOMETRY = ("-",)


@dataclass(frozen=True)
class Check:
    """One number that was expected and measured.

    Args:
        law: name of the law.
        integrator: who moved the cloth, ``-`` for pure geometry.
        expected: from the closed form.
        measured: from the simulation.
        bound: largest ``error`` that passes.
        unit: of ``expected`` and ``measured``.
        exempt: why the law cannot hold here; empty where it must.
    """

    law: str
    integrator: str
    expected: float
    measured: float
    bound: float
    unit: str = ""
    exempt: str = ""

    @property
    def error(self) -> float:
        """Relative to ``expected``; absolute where zero is expected."""
        gap = abs(self.measured - self.expected)
        return gap / abs(self.expected) if self.expected else gap

    @property
    def passed(self) -> bool:
        """Whether the error is a number within the bound, or the law is exempt."""
        return bool(self.exempt) or self.error <= self.bound

    def as_mapping(self) -> dict[str, object]:
        """Plain values for JSON; None where the law is exempt or a number is not finite."""
        numbers = {name: getattr(self, name) for name in ("expected", "measured", "error", "bound")}
        return {
            "law": self.law,
            "integrator": self.integrator,
            **{name: None if self.exempt or not math.isfinite(value) else value for name, value in numbers.items()},
            "unit": self.unit,
            "passed": self.passed,
            "exempt": self.exempt,
        }


@dataclass(frozen=True)
class Measurement:
    """What a law's scene gives: see :class:`Check` for the fields."""

    expected: float
    measured: float
    bound: float
    unit: str = ""


@dataclass(frozen=True)
class Law:
    """A law with the scene that tries it.

    Args:
        name: short, for the table and for ``--only``.
        measure: plays the scene with an integrator.
        integrators: those it concerns.
        exempt: integrators that cannot obey it, with the reason.
    """

    name: str
    measure: Callable[[str], Measurement]
    integrators: tuple[str, ...] = INTEGRATORS
    exempt: Mapping[str, str] = field(default_factory=dict)

    @property
    def formula(self) -> str:
        """First line of the docstring of ``measure``: the law in a sentence."""
        return (self.measure.__doc__ or "").strip().splitlines()[0]

    def check(self, integrator: str) -> Check:
        """Play the scene, unless ``integrator`` is exempt."""
        if integrator in self.exempt:
            return Check(self.name, integrator, 0.0, 0.0, 0.0, exempt=self.exempt[integrator])
        found = self.measure(integrator)
        return Check(self.name, integrator, float(found.expected), float(found.measured), found.bound, found.unit)
