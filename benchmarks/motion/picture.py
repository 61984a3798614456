"""The picture: error against solves with W."""

from __future__ import annotations

from math import isinf
from pathlib import Path
from typing import Any

from motion.measure import BARS
from motion.report import TEN, Row

COLORS = {
    "implicit Euler": "#7f8c8d",
    "BDF2": "#2471a3",
    "SDIRK2": "#8e44ad",
    "midpoint": "#c0392b",
    "midpoint, Anderson": "#1e8449",
    "midpoint, L-BFGS": "#d68910",
    "cloth_core": "black",
}
"""What is drawn; the others coincide with one of these, or blow up."""


def draw(rows: list[Row], path: Path) -> bool:
    """Write the picture; False where matplotlib is not installed."""
    try:
        import matplotlib
    except ImportError:
        return False
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "motion"  # the same figures give the same file
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, len(BARS), figsize=(10, 4.8), sharey=True, layout="constrained")
    for axes, k in zip(panels, BARS, strict=True):
        _fill(axes, [row for row in rows if row.name in COLORS], k)
    panels[0].set_ylabel("rms error of the mean height, m")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(COLORS), frameon=False, fontsize="small")
    figure.suptitle("Full: angular momentum about the pins given back. Dotted: without.", fontsize="medium")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    pyplot.close(figure)
    return True


def _fill(axes: Any, rows: list[Row], k: int) -> None:
    budgets = list(rows[0].scores)
    for row in rows:
        solves = [n for n, score in row.scores.items() if not isinf(score.error[k])]
        shipped = row.name == "cloth_core"
        axes.plot(
            solves,
            [row.scores[n].error[k] for n in solves],
            color=COLORS[row.name],
            linestyle="none" if shipped else "-" if row.hinge else ":",
            linewidth=2.5 if row.ours and row.hinge else 1.3,
            marker="D" if shipped else "o",
            markersize=7 if shipped else 5,
            markerfacecolor=COLORS[row.name] if row.hinge and not shipped else "white",
            label=row.name if row.hinge else None,
            zorder=4 if shipped else 3 if row.ours else 2,
        )
    for name, error in zip(("bar", "aim"), BARS[k], strict=True):
        axes.plot([0.8 * TEN, 1.25 * TEN], [error, error], color="black", linewidth=1.0, zorder=1)
        axes.annotate(name, (0.8 * TEN, error), va="bottom", fontsize="small")
    axes.set(xscale="log", yscale="log", title=f"k = {k} N/m", xlabel="solves with W per frame of 20 ms")
    axes.set_xticks(budgets, [str(n) for n in budgets])
    axes.set_xticks([], minor=True)
    axes.grid(alpha=0.3)
