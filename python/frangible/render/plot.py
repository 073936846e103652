"""Plots of energy, its changes by cause, and momentum over time."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from ..recording import Float64, Recording
from .energy_series import EnergySeries, read_energy_series

#: [inch], and pixels per inch of a .png: 1500 x 1800.
WIDTH, HEIGHT, RESOLUTION = 10.0, 12.0, 150
#: Told apart with any kind of colour vision (M. Okabe and K. Ito, 2008), without the yellow, which
#: is faint on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
BLUE, VERMILION, GREEN, *_, BLACK = COLOURS
GREY = "0.55"
STYLES = ("-", "--", "-.", ":")
#: A cause that has never changed more than this part of the energy in play is not drawn.
FAINT = 1e-6
#: Nothing less than double precision's rounding can be told from 0.
ROUNDING = 1e-17


def write_plot(recording: Recording, path: str) -> None:
    """Draw energy, its causes and momentum; the path's ending says as what."""
    # Equal recordings give equal files.
    undated = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}
    with rc_context({"svg.hashsalt": "frangible"}):
        draw(recording).savefig(path, dpi=RESOLUTION, metadata=undated.get(path[-4:].lower()))


def draw(recording: Recording) -> Figure:
    """The same as a figure; `CacheError` if the recording has no reports."""
    series = read_energy_series(recording)
    figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    shot = recording.shot or "recording"
    figure.suptitle(
        f"{shot}, {recording.method} method, {recording.fps:g} frames per second",
        fontsize="x-large",
    )
    axes = figure.subplot_mosaic(
        [["energy", "energy"], ["causes", "causes"], ["linear", "angular"], ["drift", "drift"]],
        height_ratios=[3, 3, 2.2, 1.4],
    )
    _energy(axes["energy"], series)
    _causes(axes["causes"], series)
    _momentum(axes["linear"], series.times, series.linear, "Linear momentum", "N s")
    _momentum(
        axes["angular"], series.times, series.angular, "Angular momentum about the origin", "N m s"
    )
    _drift(axes["drift"], series)
    for axis in axes.values():
        axis.set_xlabel("time [s]")
        axis.set_xlim(0.0, series.times[-1])
        axis.grid(color="0.92")
        axis.spines[["top", "right"]].set_visible(False)
    return figure


def _energy(axis: Axes, series: EnergySeries) -> None:
    axis.set_title(
        "Energy of all dynamic bodies, and its bound: what there was and the work that has entered",
        loc="left",
    )
    axis.fill_between(
        series.times, series.total, series.available, color="0.93", label="dissipated"
    )
    axis.plot(
        series.times, series.available, color=BLACK, linestyle="--", label="bound: at first + work"
    )
    axis.plot(series.times, series.total, color=BLACK, linewidth=2.0, label="total")
    axis.plot(series.times, series.kinetic, color=VERMILION, label="kinetic")
    axis.plot(
        series.times,
        series.potential,
        color=BLUE,
        linestyle="-.",
        label="potential, from its lowest",
    )
    axis.plot(
        series.times,
        series.bank,
        color=GREEN,
        linestyle=":",
        linewidth=2.0,
        label="bank, to be spent again",
    )
    _finish(axis, series, "energy")


def _causes(axis: Axes, series: EnergySeries) -> None:
    axis.set_title("What has changed the total since the first step", loc="left")
    scale = FAINT * max(
        np.ptp(series.available), np.ptp(series.total), series.kinetic.max(), series.potential.max()
    )
    drawn = {
        cause: change for cause, change in series.causes.items() if np.abs(change).max() > scale
    }
    # A colour and a style belong to a cause, whichever of them are drawn; no two causes share both.
    for i, (cause, change) in enumerate(series.causes.items()):
        if cause in drawn:
            axis.plot(
                series.times,
                change,
                color=COLOURS[i % len(COLOURS)],
                linestyle=STYLES[i % len(STYLES)],
                label=cause,
            )
    faint = [cause for cause in series.causes if cause not in drawn]
    if faint:
        axis.plot([], [], " ", label="next to nothing:\n" + "\n".join(faint))
    axis.axhline(0.0, color=GREY, linewidth=0.8)
    _finish(axis, series, "change of energy")


def _finish(axis: Axes, series: EnergySeries, label: str) -> None:
    """Common parts of the two energy panels."""
    for i, time in enumerate(series.breaks):
        axis.axvline(
            time,
            color=GREY,
            linewidth=0.8,
            linestyle=(0, (1, 3)),
            label=None if i else "a body breaks",
        )
    axis.set_ylabel(label)
    axis.yaxis.set_major_formatter(EngFormatter("J"))
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)


def _momentum(axis: Axes, times: Float64, momentum: Float64, title: str, unit: str) -> None:
    axis.set_title(title, loc="left")
    for name, values, colour, style in zip(
        "xyz", momentum.T, (VERMILION, GREEN, BLUE), ("-", "--", "-."), strict=True
    ):
        axis.plot(times, values, color=colour, linestyle=style, label=name)
    axis.yaxis.set_major_formatter(EngFormatter(unit))
    axis.legend(loc="best", ncols=3, frameon=False)


def _drift(axis: Axes, series: EnergySeries) -> None:
    axis.set_title(
        "Momentum that neither gravity nor a static or kinematic body explains", loc="left"
    )
    axis.semilogy(
        series.times, np.maximum(series.linear_error, ROUNDING), color=VERMILION, label="linear"
    )
    axis.semilogy(
        series.times,
        np.maximum(series.angular_error, ROUNDING),
        color=BLUE,
        linestyle="-.",
        label="angular",
    )
    axis.set_ylabel("over all momenta")
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
