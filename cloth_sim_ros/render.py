"""``cloth_render``: draw scenes as pictures and animations, without a display and without ROS."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cloth_core import ClothError
from cloth_sim_ros.command_line import complain
from cloth_sim_ros.rendering.fabric import FABRICS
from cloth_sim_ros.rendering.gallery import README_CLIP, SHOTS, Shot
from cloth_sim_ros.rendering.offscreen import RenderError, require_renderer
from cloth_sim_ros.rendering.playback import frame_times, play
from cloth_sim_ros.share import load_scene, scene_names

COMMAND = "cloth_render"
DESCRIPTION = """\
Simulate a scene from its start, driven by its own script, and draw it: one instant as a PNG, or a
stretch of time as a GIF or MP4. Needs neither ROS nor a display; needs the extra [render] (pyvista,
imageio) and an OpenGL library (apt: libegl1 libgl1-mesa-dri, or libosmesa6)."""
EXAMPLES = """\
examples:
  cloth_render scarf --time 5.1                                  writes scarf.png
  cloth_render my_scene.yaml --time 2 --png first.png --size 1920x1080
  cloth_render flag --animation flag.mp4 --from 2 --to 12 --fps 25
  cloth_render --all --output docs/images                        the gallery, and the README's animation"""
STILL_SIZE, ANIMATION_SIZE = (960, 720), (480, 360)


@dataclass(frozen=True)
class _Job:
    """One file to write: a still if there is one time and no ``fps``, an animation otherwise."""

    scene: str
    path: Path
    times: tuple[float, ...]
    size: tuple[int, int]
    fabric: str
    fps: float | None = None


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status: 0 written, 1 cannot draw here or wrong scene, 2 wrong call."""
    options = _parse(arguments)
    try:
        require_renderer()
        for job in _jobs(options):
            _draw(job)
    except (RenderError, ClothError, OSError) as error:
        complain(COMMAND, error)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0


def _draw(job: _Job) -> None:
    # Not earlier: importing VTK takes a second, and fails where the extra is not installed.
    from cloth_sim_ros.rendering import files
    from cloth_sim_ros.rendering.stage import Stage

    scene = load_scene(job.scene, lambda mended: complain(COMMAND, f"warning: {mended}"))
    job.path.parent.mkdir(parents=True, exist_ok=True)
    with Stage(scene, job.size, FABRICS[job.fabric]) as stage:

        def pictures() -> Iterator[np.ndarray]:
            for number, (state, inputs) in enumerate(play(scene, job.times), 1):
                yield stage.picture(state, inputs)
                _progress(f"{job.path}: picture {number} of {len(job.times)}")

        if job.fps is None:
            files.write_png(job.path, next(pictures()))
        else:
            files.WRITERS[job.path.suffix](job.path, pictures(), job.fps)
    _progress("")
    print(f"{job.path}  {job.size[0]}x{job.size[1]}  {job.path.stat().st_size / 1024:,.0f} KiB")


def _jobs(options: argparse.Namespace) -> Iterator[_Job]:
    if options.all:
        for name in scene_names():
            shot = SHOTS.get(name, Shot())
            yield _Job(name, options.output / f"{name}.png", (shot.time,), options.size or STILL_SIZE, shot.fabric)
        clip = README_CLIP
        times = tuple(frame_times(clip.start, clip.end, clip.fps))
        fabric = SHOTS[clip.scene].fabric
        yield _Job(clip.scene, options.output / f"{clip.scene}.gif", times, clip.size, fabric, clip.fps)
        return
    name = Path(options.scene).stem
    shot = SHOTS.get(name, Shot())
    fabric = options.fabric or shot.fabric
    if options.animation:
        times = tuple(frame_times(options.start, options.end, options.fps))
        yield _Job(options.scene, options.animation, times, options.size or ANIMATION_SIZE, fabric, options.fps)
    if options.png or not options.animation:
        time = shot.time if options.time is None else options.time
        yield _Job(options.scene, options.png or Path(f"{name}.png"), (time,), options.size or STILL_SIZE, fabric)


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=COMMAND, description=DESCRIPTION, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    seconds, rate = _number(0.0, 3600.0, "s"), _number(1.0, 50.0, "1/s")
    add = parser.add_argument
    add("scene", nargs="?", help=f"scene file, or one of {', '.join(scene_names())}")
    add("--time", type=seconds, metavar="S", help="instant of the still, s of simulated time")
    add("--png", type=Path, metavar="FILE", help="where the still goes; <scene>.png by default")
    add("--animation", type=_animation, metavar="FILE", help="draw an animation instead: a .gif or .mp4")
    add("--from", dest="start", type=seconds, default=0.0, metavar="S", help="start of the animation (0)")
    add("--to", dest="end", type=seconds, default=10.0, metavar="S", help="end of the animation (10)")
    add("--fps", type=rate, default=20.0, metavar="N", help="frames per second; a GIF knows 20, 25 and 50 exactly (20)")
    add("--size", type=_size, metavar="WxH", help="pixels; 960x720 for a still, 480x360 for an animation")
    add("--fabric", choices=list(FABRICS), help="what the cloth is printed with")
    add("--all", action="store_true", help="draw every scene's still and the README's animation")
    add("--output", type=Path, default=Path("docs/images"), metavar="DIR", help="folder for --all (docs/images)")
    options = parser.parse_args(arguments)
    if options.all == (options.scene is not None):
        parser.error("name one scene, or say --all")
    if options.animation and options.end <= options.start:
        parser.error(f"--to {options.end:g} s is not after --from {options.start:g} s")
    return options


def _number(low: float, high: float, unit: str) -> Callable[[str], float]:
    def read(text: str) -> float:
        value = float(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text} is not {low:g} .. {high:g} {unit}")
        return value

    read.__name__ = "number"  # argparse names the type by it
    return read


def _size(text: str) -> tuple[int, int]:
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and 16 <= int(part) <= 4096 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT in pixels, 16 .. 4096 each")
    return int(parts[0]), int(parts[1])


def _animation(text: str) -> Path:
    path = Path(text)
    if path.suffix not in (".gif", ".mp4"):
        raise argparse.ArgumentTypeError(f"{text!r} ends neither in .gif nor in .mp4")
    return path


def _progress(text: str) -> None:
    """One line that is overwritten, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
