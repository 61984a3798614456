"""Pictures and animations as files."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import imageio.v2 as imageio
import numpy as np
from PIL import Image

from cloth_sim_ros.rendering.offscreen import RenderError

GIF_COLOURS = 224
PALETTE_FRAMES = 12


def write_png(path: Path, picture: np.ndarray) -> None:
    """Write one picture, (height, width, 3) uint8."""
    Image.fromarray(picture).save(path, format="PNG", optimize=True)


def write_gif(path: Path, pictures: Iterable[np.ndarray], fps: float) -> None:
    """Write an endless loop with one palette for all frames; what does not change costs nothing.

    GIF counts time in hundredths of a second: ``fps`` of 20, 25 and 50 are exact.
    """
    frames = list(pictures)
    samples = frames[:: max(1, len(frames) // PALETTE_FRAMES)]
    strip = Image.fromarray(np.concatenate(samples, axis=0))
    palette = strip.quantize(GIF_COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
    indexed = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    indexed[0].save(
        path,
        format="GIF",
        save_all=True,
        append_images=indexed[1:],
        duration=round(100.0 / fps) * 10,
        loop=0,
        disposal=1,
        optimize=True,
    )


def write_mp4(path: Path, pictures: Iterable[np.ndarray], fps: float) -> None:
    """Write an H.264 video.

    Raises:
        RenderError: the encoder is missing.
    """
    try:
        writer = imageio.get_writer(path, format="FFMPEG", fps=fps, codec="libx264", quality=8, macro_block_size=2)
    except (ImportError, RuntimeError, ValueError) as error:
        raise RenderError(f"has no MP4 encoder ({error}); try: python3 -m pip install imageio-ffmpeg") from error
    with writer:
        for picture in pictures:
            writer.append_data(picture)


WRITERS: dict[str, Callable[[Path, Iterable[np.ndarray], float], None]] = {".gif": write_gif, ".mp4": write_mp4}
"""What writes an animation, by the file's ending."""
