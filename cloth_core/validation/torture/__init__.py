"""The adversarial contract: whatever a user does, the cloth stays finite, whole, and comes to rest again."""

from cloth_core.validation.torture.abuse import ABUSES
from cloth_core.validation.torture.contract import REST_SPEED, STRETCH_MARGIN, Breach
from cloth_core.validation.torture.episode import LARGEST, Episode, draw
from cloth_core.validation.torture.play import Outcome, play
from cloth_core.validation.torture.series import Series, as_mapping, table

__all__ = [
    "ABUSES",
    "LARGEST",
    "REST_SPEED",
    "STRETCH_MARGIN",
    "Breach",
    "Episode",
    "Outcome",
    "Series",
    "as_mapping",
    "draw",
    "play",
    "table",
]
