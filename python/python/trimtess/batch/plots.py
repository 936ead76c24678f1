"""A catalogue -> a picture: throughput over time, seconds and memory over size, failures by kind."""

from __future__ import annotations

import collections
from typing import Any

import pyarrow

from .errors import BatchError
from .plan import MEMORY_PER_BYTE, MEMORY_PER_FILE, MIB
from .report import throughput

#: Colour of each status, worst last.
COLOURS = {
    "whole": "#4c78a8",
    "partial": "#f2a541",
    "refused": "#8c8c8c",
    "limit": "#b279a2",
    "timeout": "#e45756",
    "crashed": "#9d1c20",
    "unreadable": "#72614f",
    "lost": "#000000",
}


def plot(table: pyarrow.Table, path: str) -> None:
    """Writes the plots. The ending selects the format. Raises `BatchError` if that cannot be."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7), layout="constrained")
    axes = figure.subplots(2, 2)
    plot_throughput(axes[0][0], table)
    plot_statuses(axes[0][1], table)
    over_size(axes[1][0], table, "seconds", 1.0, "seconds per file")
    over_size(axes[1][1], table, "peak_memory", MIB, "peak memory, MiB")
    draw_asked(axes[1][1])
    try:
        figure.savefig(path, dpi=110)
    except (OSError, ValueError) as error:
        raise BatchError(f"{path}: {getattr(error, 'strerror', None) or error}") from error


def plot_throughput(axes: Any, table: pyarrow.Table) -> None:
    ends, counts = throughput(table, 60)
    if ends:
        axes.step([0.0, *ends], [0.0, *(count / ends[0] for count in counts)], where="pre", color=COLOURS["whole"])
    axes.set(title="throughput", xlabel="seconds", ylabel="files a second", ylim=(0, None))


def plot_statuses(axes: Any, table: pyarrow.Table) -> None:
    counts = collections.Counter(table["status"].to_pylist())
    names = [name for name in COLOURS if counts[name]][::-1]
    bars = axes.barh(names, [counts[name] for name in names], color=[COLOURS[name] for name in names])
    axes.bar_label(bars, padding=3)
    axes.margins(x=0.15)
    axes.set(title="files by status", xlabel="files")


def over_size(axes: Any, table: pyarrow.Table, column: str, unit: float, label: str) -> None:
    """A dot per file, coloured by status."""
    rows = table.select(["size", column, "status"]).to_pylist()
    for status, colour in COLOURS.items():
        dots = [(row["size"], row[column] / unit) for row in rows if row["status"] == status and row[column]]
        dots = [dot for dot in dots if dot[0]]
        if dots:
            axes.plot(*zip(*dots), ".", color=colour, markersize=4, alpha=0.6, label=status)
    axes.set(xscale="log", yscale="log", xlabel="bytes of input", ylabel=label)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize="small")


def draw_asked(axes: Any) -> None:
    """The estimate by which a first attempt asks for memory, before it is rounded up."""
    first, last = axes.get_xlim()
    sizes = [first * (last / first) ** (step / 50) for step in range(51)]
    asked = [(MEMORY_PER_FILE + MEMORY_PER_BYTE * size) / MIB for size in sizes]
    axes.plot(sizes, asked, "--", color="#666666", linewidth=1, label="estimate")
    axes.legend(fontsize="small")
