"""What a run amounts to: the numbers behind ``--json``, and the same for people."""

from __future__ import annotations

import math
import resource
import sys
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..breaking.piece_count import difference
from ..report import StepReport

Summary = dict[str, Any]
Float64 = npt.NDArray[np.float64]

#: Depths that are kept one by one, 4 MiB of them.
_MOST_DEPTHS = 2**19
#: Bits of a number that are not looked at beyond that: ten remain of its 52, a thousandth.
_DROPPED_BITS = 42

#: A smaller share of the energy in play is rounding.
NO_GAIN = 1e-9


class Depths:
    """How deep pairs overlapped in all frames [m]: all of them up to `_MOST_DEPTHS`, beyond that
    how many there are of each size, within a thousandth."""

    def __init__(self) -> None:
        self._all: list[Float64] = []
        self._count = 0
        #: Numbers of depths by the upper bits of their floating-point numbers.
        self._bins: dict[int, int] = {}
        self._most = 0.0

    def add(self, depths: Float64) -> None:
        """Those of one more frame."""
        if not len(depths):
            return
        self._all.append(depths)
        self._count += len(depths)
        self._most = max(self._most, float(depths.max()))
        if self._count <= _MOST_DEPTHS:
            return
        # The bits of numbers that are not negative are in their order.
        bits = np.concatenate(self._all).view(np.uint64) >> np.uint64(_DROPPED_BITS)
        for each, count in zip(*(array.tolist() for array in np.unique_counts(bits)), strict=True):
            self._bins[each] = self._bins.get(each, 0) + count
        self._all, self._count = [], 0

    def percentile(self, percent: float) -> float:
        """0 without any depth."""
        if not self._bins:
            return _percentile(np.concatenate(self._all), percent) if self._all else 0.0
        if percent == 100:
            return self._most
        bits = np.array(sorted(self._bins), np.uint64)
        counts = np.array([self._bins[each] for each in bits.tolist()])
        middles = ((bits << np.uint64(_DROPPED_BITS)) + np.uint64(1 << (_DROPPED_BITS - 1))).view(
            np.float64
        )
        rest = np.concatenate(self._all) if self._all else np.zeros(0)
        values = np.concatenate([middles, rest])
        weights = np.concatenate([counts, np.ones(len(rest), np.int64)])
        order = np.argsort(values)
        past = np.cumsum(weights[order])
        return float(values[order][np.searchsorted(past, percent / 100.0 * past[-1])])


class RunFigures:
    """What is kept of the frames of a run for its summary: a few numbers for each."""

    def __init__(self) -> None:
        self.frames = 0
        self.step_ms = array("d")
        self.depths = Depths()
        self._gains, self._work, self._banked = array("d"), array("d"), array("d")
        self._kinetic, self._potential = array("d"), array("d")
        self._started, self._entered = array("d"), 0.0
        self._linear, self._angular, self._total = 0.0, 0.0, 0.0
        self._stages: dict[str, float] = {}
        self._first_fracture: float | None = None
        self._fractures = 0
        #: The blow that came nearest to breaking something and did not, and when [s].
        self._borne: dict[str, Any] | None = None
        #: For each break that was asked for a number of pieces, that number and how many there are.
        self._asked: list[tuple[int, int]] = []
        #: Fragments that live.
        self._pieces: set[int] = set()
        self._causes: list[str] = []

    def add(self, report: StepReport, step_ms: float | None = None) -> None:
        """One more frame; its depths are added to `depths`."""
        self.frames += 1
        if step_ms is not None:
            self.step_ms.append(step_ms)
        energy, momentum = report["energy"], report["momentum"]
        self._gains.append(energy["gain"])
        self._work.append(energy["work"])
        self._banked.append(energy["banked"])
        self._kinetic.append(energy["kinetic"])
        self._started.append(energy.get("started", 0.0))
        # Relative to what has started by then.
        self._entered += self._started[-1]
        self._potential.append(energy["potential"] - self._entered)
        self._total = energy["total"]
        self._linear = max(self._linear, momentum["linear_error"])
        self._angular = max(self._angular, momentum["angular_error"])
        for stage, milliseconds in report["stages"]:
            self._stages[stage] = self._stages.get(stage, 0.0) + milliseconds
        if blow := report.get("borne"):
            share = blow["impulse"] / blow["bears"]
            if self._borne is None or share > self._borne["impulse"] / self._borne["bears"]:
                self._borne = {**blow, "time": report["time"]}
        for fracture in report["fractures"]:
            if self._first_fracture is None:
                self._first_fracture = report["time"]
            self._fractures += 1
            if wanted := fracture.get("wanted"):
                self._asked.append((wanted, fracture.get("counted", len(fracture["fragments"]))))
            self._pieces.discard(fracture["body"])
            self._pieces.update(fracture["fragments"])
        self._pieces.difference_update(taken["body"] for taken in report["quarantined"])
        self._causes += [taken["cause"] for taken in report["quarantined"]]

    def summary(
        self,
        *,
        shot: str,
        method: str,
        dt: float,
        state_hash: str,
        bodies: tuple[int, int],
        mass: tuple[float, float],
        energy: tuple[float, float],
    ) -> Summary:
        """The run's figures; ``bodies`` and ``mass`` [kg] are those of the first and the last
        state, ``energy`` [J] the kinetic and the potential one of the first.

        Energies are of all dynamic bodies [J]. ``max_frame_gain`` is the largest E(n+1) - E(n) - W
        of a frame, with what is in the ledger's bank counted as energy, ``scale`` the largest
        kinetic energy plus the range of the potential energy: what a gain is to be measured
        against. ``stages_ms`` are means over all frames.
        """
        kinetics, potentials = [energy[0], *self._kinetic], [energy[1], *self._potential]
        first = {} if self._first_fracture is None else {"first_fracture_s": self._first_fracture}
        borne = {} if self._borne is None else {"largest_borne": self._borne}
        return {
            "shot": shot,
            "method": method,
            "frames": self.frames,
            "dt": dt,
            "state_hash": state_hash,
            "pieces_asked": self._asked,
            "fractures": self._fractures,
            "pieces": len(self._pieces),
            **first,
            **borne,
            "peak_memory_MiB": peak_memory(),
            "bodies": {
                "start": bodies[0],
                "end": bodies[1],
                "quarantined": len(self._causes),
            },
            "quarantine_causes": sorted(set(self._causes)),
            "mass_kg": {"start": mass[0], "end": mass[1]},
            "energy_J": {
                "start": sum(energy),
                "end": self._total if self.frames else sum(energy),
                "work": math.fsum(self._work),
                "started": math.fsum(self._started),
                "dissipated": -math.fsum(self._gains),
                "banked": math.fsum(self._banked),
                "max_frame_gain": max(self._gains, default=0.0),
                "scale": max(kinetics) + max(potentials) - min(potentials),
            },
            "momentum": {"linear_error": self._linear, "angular_error": self._angular},
            "penetration_m": {
                "p50": self.depths.percentile(50),
                "p99": self.depths.percentile(99),
                "max": self.depths.percentile(100),
            },
            "ms_per_frame": spread(self.step_ms),
            "stages_ms": {stage: total / self.frames for stage, total in self._stages.items()},
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


def _broken(summary: Summary) -> str:
    if not summary["fractures"]:
        return "nothing broke" + _largest_borne(summary.get("largest_borne"))
    breaks = "" if summary["fractures"] == 1 else f" of {summary['fractures']} breaks, the first"
    return f"{_count(summary['pieces'], 'piece')}{breaks} after {summary['first_fracture_s']:.2f} s"


def _largest_borne(blow: dict[str, Any] | None) -> str:
    """The blow that came nearest to breaking something, and why it did not."""
    if blow is None:
        return ""
    name, striker = blow["name"] or "a body", blow["striker"] or "a body"
    where = ", ".join(f"{at:.3g}" for at in blow["point"])
    why = "" if blow["impulse"] <= blow["bears"] else ", and has too little energy for its cracks"
    return (
        f": the largest blow, {blow['impulse']:.3g} N s by {striker} on {name} after "
        f"{blow['time']:.2f} s at ({where}), meets {blow['bears']:.3g} N s of strength{why}"
    )


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


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def spread(values: Sequence[float]) -> dict[str, float]:
    """Mean, median, 95th percentile and maximum."""
    return {
        "mean": float(np.mean(values)) if len(values) else 0.0,
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
