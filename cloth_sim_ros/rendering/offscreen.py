"""Whether pictures can be drawn here, asked before VTK is touched: it crashes where no OpenGL library is."""

from __future__ import annotations

import ctypes
import importlib.util
import os

NEEDED = ("pyvista", "imageio", "PIL")
GL_WINDOWS = {
    "libEGL.so.1": "vtkEGLRenderWindow",
    "libOSMesa.so.8": "vtkOSOpenGLRenderWindow",
    "libOSMesa.so.6": "vtkOSOpenGLRenderWindow",
}
"""Libraries that draw without a display, and VTK's name of the window that uses each."""


class RenderError(RuntimeError):
    """Pictures cannot be drawn here, and what to install."""


def require_renderer() -> None:
    """Return if pictures can be drawn here.

    Raises:
        RenderError: a Python package or an OpenGL library is missing; the message names what to install.
    """
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        raise RenderError(
            f"needs {', '.join(missing)}, which this Python does not have; "
            "try: python3 -m pip install pyvista imageio imageio-ffmpeg (the extra [render])"
        )
    if os.environ.get("DISPLAY") and _loads("libGL.so.1"):
        return
    found = next((library for library in GL_WINDOWS if _loads(library)), None)
    if found is None:
        raise RenderError(
            "finds no OpenGL library to draw with; "
            "try: sudo apt install libegl1 libgl1-mesa-dri (or sudo apt install libosmesa6)"
        )
    # Else VTK tries X first and complains.
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", GL_WINDOWS[found])


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
