"""Where the files that come with the package are: scenes, configuration."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cloth_core import MeshWarning, SettingError
from cloth_core.scene import Scene

PACKAGE = "cloth_sim_ros"


def share_folder() -> Path:
    """The folder that holds ``config/scenes``: of the installation, or the checkout itself."""
    return next((folder for folder in _candidates() if (folder / "config" / "scenes").is_dir()), _candidates()[-1])


def scene_names() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(path.stem for path in (share_folder() / "config" / "scenes").glob("*.yaml"))


def find_scene(scene: str) -> Path:
    """The file of a scene given by path, or by the bare name of one that comes with the package.

    Raises:
        SettingError: there is no such file; the message names the scenes that there are.
    """
    path = Path(scene).expanduser()
    if path.is_file():
        return path
    shipped = share_folder() / "config" / "scenes" / f"{scene}.yaml"
    if scene and "/" not in scene and shipped.is_file():
        return shipped
    raise SettingError("scene", f"'{scene}' is neither a file nor one of {', '.join(scene_names())}")


def load_scene(scene: str, warn: Callable[[str], None]) -> Scene:
    """The scene of that path or bare name; ``warn`` gets a line for every fault of its mesh file that was mended.

    Raises:
        SettingError: there is no such file, or it cannot be used.
    """

    def show(message: Warning | str, category: type[Warning], *where: Any) -> None:
        if issubclass(category, MeshWarning):
            warn(str(message))
        else:
            show_other(message, category, *where)

    with warnings.catch_warnings():
        warnings.simplefilter("always", MeshWarning)
        show_other, warnings.showwarning = warnings.showwarning, show
        return Scene.load(find_scene(scene))


def _candidates() -> list[Path]:
    here = Path(__file__).resolve()
    ament = [Path(prefix) for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    # <prefix>/lib/pythonX.Y/site-packages/cloth_sim_ros/share.py
    prefixes = [*ament, Path(sys.prefix), *here.parents[4:5]]
    return [*(prefix / "share" / PACKAGE for prefix in prefixes), here.parents[1]]
