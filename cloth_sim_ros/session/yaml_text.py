"""Plain data to YAML text and back."""

from __future__ import annotations

import io
from typing import Any

from ruamel.yaml import YAML


def dump(data: Any) -> str:
    """YAML of ``data`` (mappings, lists, text, numbers), keys in their order, without a single anchor."""
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    yaml.width = 4096  # one value, one line: some tools read these files line by line
    yaml.sort_base_mapping_type_on_output = False
    yaml.representer.ignore_aliases = lambda _data: True
    stream = io.StringIO()
    yaml.dump(data, stream)
    return stream.getvalue()


def load(text: str) -> Any:
    """The data in YAML ``text``. Raises ``ruamel.yaml.error.YAMLError`` when it is none."""
    return YAML(typ="safe", pure=True).load(text)
