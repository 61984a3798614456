"""Opens the session of a run, or says why there is none."""

from __future__ import annotations

import time
from pathlib import Path

from cloth_core import ClothSolver
from cloth_core.scene import Scene
from cloth_sim_ros.parameters import NodeSettings
from cloth_sim_ros.recording.recorder import Recorder
from cloth_sim_ros.session import SessionError


def open_session(settings: NodeSettings, scene: Scene, solver: ClothSolver, namespace: str) -> Recorder | None:
    """A recorder into a new folder of ``settings.sessions``; None if nothing shall be recorded.

    Args:
        settings: the node's; they are kept in the session.
        scene: what is simulated.
        solver: what simulates it.
        namespace: full name of the node.

    Raises:
        SessionError: the folder cannot be made or written; the message names path and reason.
    """
    if settings.record == "none":
        return None
    folder = new_folder(settings.sessions, scene.name)
    return Recorder.open(folder, scene, settings.as_mapping(), solver, namespace, record=settings.record)


def new_folder(parent: Path, name: str) -> Path:
    """Make a folder of its own for a run, named by the local time and ``name``.

    Raises:
        SessionError: it cannot be made.
    """
    stem = f"{time.strftime('%Y-%m-%d_%H-%M-%S')}_{name}"
    number = 1
    while True:
        folder = parent / (stem if number == 1 else f"{stem}_{number}")
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            if not parent.is_dir():
                raise SessionError(f"{parent}: sessions cannot be recorded there: not a folder") from None
            number += 1
        except OSError as error:
            raise SessionError(f"{folder}: the session cannot be recorded: {error.strerror or error}") from None
