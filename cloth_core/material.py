"""What the cloth is made of."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from cloth_core.errors import SettingError
from cloth_core.settings import Settings, setting


@dataclass(frozen=True, slots=True, kw_only=True)
class Material(Settings):
    """Measured properties of a fabric; stiffnesses are those of the sheet, not of a spring.

    A strip of the cloth of width w pulled with the force F along the warp, free to narrow, lengthens by
    F / (w * stretch_warp) of its length; sheared by the angle g, warp against weft at constant lengths, the cloth
    resists with the force shear * g per width: however it is meshed.
    """

    areal_density: float = setting("float", 0.2, unit="kg/m^2", low=1e-3, high=20.0, help="mass per area")
    stretch_warp: float = setting(
        "float",
        2000.0,
        unit="N/m",
        low=0.1,
        high=1e7,
        help="tension per width and strain of a strip along the warp (grid columns)",
    )
    stretch_weft: float = setting(
        "float",
        2000.0,
        unit="N/m",
        low=0.1,
        high=1e7,
        help="tension per width and strain of a strip along the weft (grid rows)",
    )
    shear: float = setting(
        "float", 400.0, unit="N/m", low=0.0, high=1e7, help="resistance to shearing warp against weft"
    )
    bend: float = setting("float", 5e-5, unit="N m", low=0.0, high=1e3, help="bending stiffness")
    bend_damping: float = setting(
        "float",
        0.03,
        unit="s",
        low=0.0,
        high=10.0,
        help="time in which bending dies away: its viscosity over its stiffness",
    )
    stretch_damping: float = setting(
        "float",
        5e-4,
        unit="s",
        low=0.0,
        high=1.0,
        help="time in which stretching dies away: viscosity of the threads over their stiffness",
    )
    damping: float = setting("float", 0.0, unit="1/s", low=0.0, high=100.0, help="rate at which motion dies away")
    stretch_limit: float = setting(
        "float", 1.03, unit="m/m", low=1.001, high=10.0, help="longest a thread gets, as a multiple of its rest length"
    )
    thickness: float = setting("float", 5e-4, unit="m", low=1e-5, high=0.05, help="thickness of the cloth")
    friction: float = setting("float", 0.3, unit="", low=0.0, high=10.0, help="Coulomb friction coefficient")
    restitution: float = setting("float", 0.0, unit="", low=0.0, high=1.0, help="normal speed kept by an impact")
    drag: float = setting("float", 1.2, unit="", low=0.0, high=10.0, help="drag coefficient of a patch held face-on")

    def sheet_stiffness(self) -> tuple[float, float, float]:
        """Stiffnesses C_warp, C_weft, shear in N/m of the orthotropic sheet whose strips are as stiff as measured.

        Tensions are C_warp e_warp + C_cross e_weft along the warp, C_cross e_warp + C_weft e_weft along the weft.
        Threads that pull along themselves alone have C_cross = shear (Cauchy's relation), and a strip that may
        narrow is less stiff by C_cross^2 / C of the other: C_warp = t stretch_warp and C_weft = t stretch_weft
        with t^2 - t = shear^2 / (stretch_warp stretch_weft) make up for it.
        """
        ratio = self.shear * self.shear / (self.stretch_warp * self.stretch_weft)
        more = 0.5 + math.sqrt(0.25 + ratio)
        return more * self.stretch_warp, more * self.stretch_weft, self.shear

    @classmethod
    def preset(cls, name: str, **changes: Any) -> Material:
        """A measured fabric by name; keywords change single values.

        Densities, stretching and bending stiffnesses follow Wang, Ramamoorthi and O'Brien 2011,
        strain limits the values used for cotton, polyester and wool in C-IPC (Li et al. 2021).

        Raises:
            SettingError: no such preset, or a changed value out of range.
        """
        if not isinstance(name, str) or name not in PRESETS:
            raise SettingError("preset", f"{name!r} is not one of {', '.join(PRESETS)}")
        return cls.from_mapping({**PRESETS[name], **changes})


# Stiffnesses of the stretchy knits are the slopes of the measured curves at small strain.
PRESETS: dict[str, dict[str, float]] = {
    "denim": dict(
        areal_density=0.324, stretch_warp=1014.0, stretch_weft=205.0, shear=100.0, bend=7e-5, stretch_limit=1.06
    ),
    "dots": dict(
        areal_density=0.128, stretch_warp=2000.0, stretch_weft=2000.0, shear=100.0, bend=2e-5, stretch_limit=1.06
    ),
    "interlock": dict(
        areal_density=0.187, stretch_warp=34.0, stretch_weft=17.0, shear=10.0, bend=2e-5, stretch_limit=1.13
    ),
    "ponte": dict(areal_density=0.284, stretch_warp=60.0, stretch_weft=40.0, shear=20.0, bend=4e-5, stretch_limit=1.13),
    "rib": dict(areal_density=0.276, stretch_warp=40.0, stretch_weft=15.0, shear=10.0, bend=3e-5, stretch_limit=1.13),
    "swim": dict(areal_density=0.204, stretch_warp=60.0, stretch_weft=60.0, shear=25.0, bend=2e-5, stretch_limit=1.13),
    "tango": dict(
        areal_density=0.113, stretch_warp=500.0, stretch_weft=500.0, shear=60.0, bend=1e-5, stretch_limit=1.06
    ),
}
