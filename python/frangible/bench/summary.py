"""What a run amounts to: the numbers behind ``--json``, and the same for people."""

from __future__ import annotations

import math
import resource
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..breaking.piece_count import difference
from ..report import StepReport

Summary = dict[str, Any]

#: A smaller share of the energy in play is rounding.
NO_GAIN = 1e-9


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
    """The run's figures; ``bodies`` and ``mass`` [kg] are those of the first and the last state,
    ``energy`` [J] the kinetic and the potential one of the first; ``depths`` [m] are those of the
    overlapping pairs after each frame.

    Energies are of all dynamic bodies [J]. ``max_frame_gain`` is the largest E(n+1) - E(n) - W of a
    frame, with what is in the ledger's bank counted as energy, ``scale`` the largest kinetic energy
    plus the range of the potential energy: what a gain is to be measured against. ``stages_ms`` are
    means over all frames.
    """
    gains = [report["energy"]["gain"] for report in reports]
    kinetics = [energy[0], *(report["energy"]["kinetic"] for report in reports)]
    started = [report["energy"].get("started", 0.0) for report in reports]
    # Relative to what has started by then.
    entered = np.cumsum(started).tolist()
    potentials = [
        energy[1],
        *(report["energy"]["potential"] - of for report, of in zip(reports, entered, strict=True)),
    ]
    penetrations = np.concatenate(depths)
    stages: dict[str, float] = {}
    for report in reports:
        for stage, milliseconds in report["stages"]:
            stages[stage] = stages.get(stage, 0.0) + milliseconds / len(reports)
    first = [{"first_fracture_s": report["time"]} for report in reports if report["fractures"]][:1]
    return {
        "shot": shot,
        "method": method,
        "frames": len(reports),
        "dt": dt,
        "state_hash": state_hash,
        "pieces_asked": _asked(reports),
        "fractures": sum(len(report["fractures"]) for report in reports),
        "pieces": _pieces(reports),
        **(first[0] if first else {}),
        "peak_memory_MiB": peak_memory(),
        "bodies": {
            "start": bodies[0],
            "end": bodies[1],
            "quarantined": sum(len(report["quarantined"]) for report in reports),
        },
        "quarantine_causes": sorted(
            {taken["cause"] for report in reports for taken in report["quarantined"]}
        ),
        "mass_kg": {"start": mass[0], "end": mass[1]},
        "energy_J": {
            "start": sum(energy),
            "end": reports[-1]["energy"]["total"],
            "work": math.fsum(report["energy"]["work"] for report in reports),
            "started": math.fsum(started),
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
    """The summary for people, in four lines at most; ``seconds`` is the time of all steps."""
    frames, energy, bodies = summary["frames"], summary["energy_J"], summary["bodies"]
    method = "" if summary["method"] == "frame-rate" else f", by the {summary['method']} method"
    lines = [
        f"{summary['shot']}: {frames * summary['dt']:.3g} s in {_count(frames, 'frame')}, "
        f"simulated in {seconds:.2g} s{method}",
        f"{_broken(summary)}; {_dissipated(energy)}; {_gained(energy)}",
    ]
    lines += [
        f"  pieces    {line}"
        for wanted, count in summary["pieces_asked"]
        if (line := difference(count, wanted))
    ]
    if bodies["quarantined"]:
        were = "body was" if bodies["quarantined"] == 1 else "bodies were"
        causes = ", ".join(summary["quarantine_causes"])
        lines.append(f"{bodies['quarantined']} {were} taken out of the world: {causes}")
    return "\n".join(lines)


def _pieces(reports: Sequence[StepReport]) -> int:
    """Fragments that live at the end."""
    pieces: set[int] = set()
    for report in reports:
        for fracture in report["fractures"]:
            pieces.discard(fracture["body"])
            pieces.update(fracture["fragments"])
        pieces.difference_update(taken["body"] for taken in report["quarantined"])
    return len(pieces)


def _broken(summary: Summary) -> str:
    if not summary["fractures"]:
        return "nothing broke"
    breaks = "" if summary["fractures"] == 1 else f" of {summary['fractures']} breaks, the first"
    return f"{_count(summary['pieces'], 'piece')}{breaks} after {summary['first_fracture_s']:.2f} s"


def _dissipated(energy: dict[str, float]) -> str:
    # Work of kinematic bodies is there to be dissipated, too.
    scale = energy["scale"] + max(energy["work"], 0.0)
    share = 100.0 * max(energy["dissipated"], 0.0) / scale if scale > 0.0 else 0.0
    return f"{share:.2g} % of the energy dissipated" if share >= 0.1 else "no energy dissipated"


def _gained(energy: dict[str, float]) -> str:
    scale, gain = energy["scale"], energy["max_frame_gain"]
    if gain <= NO_GAIN * scale:
        return "no frame gained energy"
    return f"A FRAME GAINED ENERGY: {gain:.3g} J, {100.0 * gain / scale:.2g} % of what is in play"


def _asked(reports: Sequence[StepReport]) -> list[tuple[int, int]]:
    """For each break that was asked for a number of pieces, that number and how many there are."""
    breaks = [fracture for report in reports for fracture in report["fractures"]]
    return [(wanted, len(each["fragments"])) for each in breaks if (wanted := each.get("wanted"))]


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
