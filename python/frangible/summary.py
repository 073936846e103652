"""What a run amounts to: the numbers behind ``--json``, and the same for people."""

from __future__ import annotations

import math
import resource
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .report import StepReport

Summary = dict[str, Any]


def summarise(
    reports: Sequence[StepReport],
    *,
    shot: str,
    method: str,
    dt: float,
    state_hash: str,
    bodies: tuple[int, int],
    mass: tuple[float, float],
    energy: tuple[float, float],
    depths: Sequence[npt.NDArray[np.float64]],
    step_ms: Sequence[float],
) -> Summary:
    """The run's figures; ``bodies`` and ``mass`` [kg] are those of the first and the last state, ``energy`` [J] the kinetic and the
    potential one of the first; ``depths`` [m] are those of the overlapping pairs after each frame.

    Energies are of all dynamic bodies [J]. ``max_frame_gain`` is the largest E(n+1) - E(n) - W of a frame, with what is in
    the ledger's bank counted as energy, ``scale`` the largest kinetic energy plus the range of the potential energy: what a gain is to be measured against. ``stages_ms`` are
    means over all frames.
    """
    gains = [report["energy"]["gain"] for report in reports]
    kinetics = [energy[0], *(report["energy"]["kinetic"] for report in reports)]
    potentials = [energy[1], *(report["energy"]["potential"] for report in reports)]
    penetrations = np.concatenate(depths)
    stages: dict[str, float] = {}
    for report in reports:
        for stage, milliseconds in report["stages"]:
            stages[stage] = stages.get(stage, 0.0) + milliseconds / len(reports)
    return {
        "shot": shot,
        "method": method,
        "frames": len(reports),
        "dt": dt,
        "state_hash": state_hash,
        "fractures": sum(len(report["fractures"]) for report in reports),
        "peak_memory_MiB": peak_memory(),
        "bodies": {
            "start": bodies[0],
            "end": bodies[1],
            "quarantined": sum(len(report["quarantined"]) for report in reports),
        },
        "mass_kg": {"start": mass[0], "end": mass[1]},
        "energy_J": {
            "start": sum(energy),
            "end": reports[-1]["energy"]["total"],
            "work": math.fsum(report["energy"]["work"] for report in reports),
            "dissipated": -math.fsum(gains),
            "banked": math.fsum(report["energy"]["banked"] for report in reports),
            "max_frame_gain": max(gains),
            "scale": max(kinetics) + max(potentials) - min(potentials),
        },
        "momentum": {
            "linear_error": max(report["momentum"]["linear_error"] for report in reports),
            "angular_error": max(report["momentum"]["angular_error"] for report in reports),
        },
        "penetration_m": {
            "p50": _percentile(penetrations, 50),
            "p99": _percentile(penetrations, 99),
            "max": _percentile(penetrations, 100),
        },
        "ms_per_frame": spread(step_ms),
        "stages_ms": stages,
    }


def describe(summary: Summary, seconds: float) -> str:
    """The summary for people; ``seconds`` is the time of all steps."""
    bodies, mass, energy = summary["bodies"], summary["mass_kg"], summary["energy_J"]
    frames = summary["frames"]
    scale = energy["scale"]
    # Round-off around zero would only distract.
    start, work, dissipated, banked, end, gain = (
        energy[key] if abs(energy[key]) > 1e-12 * scale else 0.0
        for key in ("start", "work", "dissipated", "banked", "end", "max_frame_gain")
    )
    lines = [
        f"{summary['shot']}: {frames} frames of {summary['dt'] * 1e3:.4g} ms in {seconds:.2f} s,"
        f" {frames / seconds:.3g} frames per second ({summary['method']} method)",
        f"  bodies    {bodies['start']} at first, {bodies['end']} at last; {_count(summary['fractures'], 'fracture')}",
        f"  mass      {mass['start']:.6g} kg at first, {mass['end']:.6g} kg at last",
        f"  energy    {start:.6g} J at first + {work:.6g} J of work - {dissipated:.6g} J dissipated"
        f" - {banked:.6g} J in the bank = {end:.6g} J at last",
        f"  books     largest gain of a frame {gain:.3g} J, {gain / scale if scale else 0.0:.2g} of the {scale:.4g} J in play",
        f"  state     {summary['state_hash']}",
    ]
    if bodies["quarantined"]:
        lines.insert(2, f"  removed   {bodies['quarantined']} bodies whose numbers went bad")
    return "\n".join(lines)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def spread(values: Sequence[float]) -> dict[str, float]:
    """Mean, median, 95th percentile and maximum."""
    return {
        "mean": float(np.mean(values)),
        "median": _percentile(values, 50),
        "p95": _percentile(values, 95),
        "max": _percentile(values, 100),
    }


def _percentile(values: Any, percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) else 0.0


def peak_memory() -> float:
    """Largest resident set of this process [MiB]."""
    # What `getrusage` says on Linux may be of the process that started this one.
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            for line in file:
                if line.startswith("VmHWM:"):
                    return float(line.split()[1]) / 2**10
    except OSError:
        pass
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # Linux counts kibibytes, macOS bytes.
    return peak / (2**20 if sys.platform == "darwin" else 2**10)
