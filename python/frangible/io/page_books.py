"""The books of a recording in its page: energy by cause, breaks, and gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import cast

import numpy as np

from ..recording import Body, Recording
from ..report import Fracture, StepReport
from .page_streams import Blob, bits

#: Columns of the stream `energy` before those of the causes [J], of each step.
_STATE = ("kinetic", "potential", "gain", "work", "banked", "started")
CAUSES = (
    "work", "collision", "contact", "friction", "projection", "fracture", "balance", "flight",
)  # fmt: skip
#: Gravity is known if frames tell it to this part.
_AGREEMENT = 1e-3
#: So many frames are asked for it.
_ASKED = 8


def add_energy(blob: Blob, reports: Sequence[StepReport]) -> None:
    """Energy after each step, and what changed it, as bits of single-precision numbers."""
    rows = []
    for report in reports:
        energy = cast(dict[str, float], report.get("energy", {}))
        causes = cast(dict[str, float], energy.get("causes", {}))
        rows.append(
            [float(energy.get(name, 0.0)) for name in _STATE]
            + [float(causes.get(name, 0.0)) for name in CAUSES]
        )
    blob.add("energy", bits(np.array(rows).reshape(-1, len(_STATE) + len(CAUSES))))
    blob.add("energy_frames", np.array([report["frame"] for report in reports], np.int64))


def add_breaks(
    blob: Blob, reports: Sequence[StepReport], rows: dict[int, int], new: list[Body], before: int
) -> int:
    """The breaks, and which of them each new body comes from; ``before`` were breaks of earlier
    chunks. The number of breaks with these."""
    breaks: list[tuple[int, Fracture]] = [
        (report["frame"], fracture) for report in reports for fracture in report["fractures"]
    ]
    of_fragment = {
        fragment: before + index
        for index, (_, fracture) in enumerate(breaks)
        for fragment in fracture["fragments"]
    }
    blob.add("broke", np.array([of_fragment.get(body.id, -1) for body in new], np.int64))
    blob.add("break_frame", np.array([frame for frame, _ in breaks], np.int64))
    for name, key in (("break_body", "body"), ("break_striker", "striker")):
        named = [cast(dict[str, int], fracture).get(key, -1) for _, fracture in breaks]
        blob.add(name, np.array([rows.get(one, -1) for one in named], np.int64))
    pieces = [len(fracture["fragments"]) for _, fracture in breaks]
    blob.add("break_pieces", np.array(pieces, np.int64))
    figures = [
        [float(cast(dict[str, float], fracture).get(key, 0.0)) for key in ("impulse", "energy")]
        for _, fracture in breaks
    ]
    blob.add("break_figures", bits(np.array(figures).reshape(-1, 2)))
    return before + len(breaks)


def gravity_of(recording: Recording) -> float | None:
    """Upward acceleration of free flight [m/s^2], which the potential energy of frames tells;
    `None` if they do not agree, as where gravity is not vertical or bodies wait for their start."""
    reports = recording.reports
    found = []
    for report in reports[:: max(1, len(reports) // _ASKED)]:
        frame = report["frame"]
        moment = mass = 0.0
        for body in recording.bodies:
            if math.isfinite(body.mass) and body.alive(frame):
                moment += body.mass * float(body.pose(frame)[0][1])
                mass += body.mass
        # About the ground nothing is told.
        if abs(moment) > 1e-6 * mass and "potential" in report.get("energy", {}):
            found.append(-report["energy"]["potential"] / moment)
    if not found or np.ptp(found) > _AGREEMENT * max(map(abs, found)):
        return None
    return float(np.median(found))
