"""Laws of physics that the solver is held to, shared by the tests and by ``cloth_validate``."""

from cloth_core.validation import equilibrium, friction, geometry, medium, motion
from cloth_core.validation.law import INTEGRATORS, Check, Law, Measurement

LAWS: tuple[Law, ...] = (*motion.LAWS, *equilibrium.LAWS, *friction.LAWS, *medium.LAWS, *geometry.LAWS)

__all__ = ["INTEGRATORS", "LAWS", "Check", "Law", "Measurement"]
