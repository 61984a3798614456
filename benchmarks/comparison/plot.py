"""The picture: time of a frame against the number of vertices."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from comparison.gate import faults
from comparison.plan import CONTESTANTS
from comparison.report import of

PANELS = ("hang", "drape")
COLORS = dict(zip(CONTESTANTS, ("#c0392b", "#e59866", "#7f8c8d", "#2471a3", "#1e8449", "#8e44ad"), strict=True))
FRAME_MS = 20.0


def draw(document: dict[str, Any], path: Path) -> bool:
    """Write the picture; False where matplotlib is not installed."""
    try:
        import matplotlib
    except ImportError:
        return False
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "bench"  # the same figures give the same file
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, len(PANELS), figsize=(10, 4.5), sharey=True, layout="constrained")
    for axes, scenario in zip(panels, PANELS, strict=True):
        _fill(axes, [r for r in document["results"] if r["scenario"] == scenario and "ms_median" in r])
        axes.set(title=scenario, xlabel="vertices")
    panels[0].set_ylabel("ms per frame of 20 ms, median")
    panels[-1].legend(frameon=False, fontsize="small", loc="lower right")
    how, machine = document["how"], document["machine"]
    figure.suptitle(
        f"{machine['cpu']}, {how['threads']} core(s). Hollow: fails the gate on quality.", fontsize="medium"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    pyplot.close(figure)
    return True


def _fill(axes: Any, results: list[dict[str, Any]]) -> None:
    sizes = sorted({result["n"] ** 2 for result in results})
    axes.set(xscale="log", yscale="log")
    axes.set_xticks(sizes, [f"{size:,}" for size in sizes])
    axes.set_xticks([], minor=True)
    for contestant in CONTESTANTS:
        mine = sorted((r for r in results if of(r) == contestant), key=lambda result: result["n"])
        vertices, ms = [r["n"] ** 2 for r in mine], [r["ms_median"] for r in mine]
        color = COLORS[contestant]
        if mine:
            axes.plot(vertices, ms, color=color, label=contestant.name, linewidth=2.5 if contestant.ours else 1.2)
        for x, y, result in zip(vertices, ms, mine, strict=True):
            axes.plot(x, y, "o", color=color, markerfacecolor="white" if faults(result) else color)
    axes.axhline(FRAME_MS, color="black", linewidth=0.8, linestyle=":")
    axes.annotate("real time", (0.01, FRAME_MS), xycoords=("axes fraction", "data"), va="bottom", fontsize="small")
    axes.grid(alpha=0.3)
